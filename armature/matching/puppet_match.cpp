#include "armature/matching/puppet_match.h"

#include <cmath>

#include "armature/matching/carried_frames.h"
#include "armature/matching/match_parts.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

/// A chain's joints in the skeleton, and what stays the same while it moves.
struct ChainRods {
  std::vector<int> joints;              ///< M+1, from the near anchor on
  std::vector<std::vector<int>> bones;  ///< M; those that each rod carries
  Eigen::VectorXd lengths;              ///< M
  PointsX3 rest;                        ///< M x 3, unit
  PointsX3 zero;                        ///< M x 3, unit: directions in the armature's zero position
  std::vector<Quaterniond> zero_from_rest;  ///< M
};

[[noreturn]] void RefuseChain(const Chain& chain, const std::string& what) {
  throw InputError("armature: chain '" + chain.name + "' (line " + std::to_string(chain.line) +
                   " of the chain file): " + what);
}

int JointOf(const Chain& chain, const Skeleton& skeleton, const std::string& name) {
  const int joint = skeleton.Find(name);
  if (joint < 0) RefuseChain(chain, "the computer skeleton has no joint '" + name + "'");
  return joint;
}

/// The bones between two joints that follow each other in a chain.
std::vector<int> BonesBetween(const Chain& chain, const Skeleton& skeleton, int a, int b) {
  const std::vector<int> path = skeleton.PathBetween(a, b);
  if (path.size() < 2)
    RefuseChain(chain, "joints '" + skeleton.joints[a].name + "' and '" + skeleton.joints[b].name +
                           "' are the same, or stand in different trees");
  std::vector<int> bones;
  for (std::size_t i = 1; i < path.size(); ++i)
    bones.push_back(skeleton.joints[path[i]].parent == path[i - 1] ? path[i] : path[i - 1]);
  return bones;
}

std::vector<int> JointsOf(const Chain& chain, const ChainPlan& plan, const Skeleton& skeleton) {
  const int from = JointOf(chain, skeleton, plan.anchors[chain.from].computer);
  const int to = JointOf(chain, skeleton, plan.anchors[chain.to].computer);
  if (chain.computer.empty()) return skeleton.PathBetween(from, to);
  std::vector<int> joints = {from};
  for (const std::string& name : chain.computer) joints.push_back(JointOf(chain, skeleton, name));
  joints.push_back(to);
  return joints;
}

ChainRods RodsOf(const Chain& chain, const ChainPlan& plan, const Skeleton& skeleton) {
  ChainRods rods;
  rods.joints = JointsOf(chain, plan, skeleton);
  const int count = SizeOf(rods.joints) - 1;
  if (count < 1) RefuseChain(chain, "its ends stand in different trees of the computer skeleton");
  rods.lengths.resize(count);
  rods.rest.resize(count, 3);
  for (int i = 0; i < count; ++i) {
    rods.bones.push_back(BonesBetween(chain, skeleton, rods.joints[i], rods.joints[i + 1]));
    const SkeletonJoint& begin = skeleton.joints[rods.joints[i]];
    const SkeletonJoint& end = skeleton.joints[rods.joints[i + 1]];
    rods.lengths[i] = (end.rest - begin.rest).norm();
    if (!(rods.lengths[i] > 0))
      RefuseChain(chain, "joints '" + begin.name + "' and '" + end.name + "' are at one place");
    rods.rest.row(i) = (end.rest - begin.rest) / rods.lengths[i];
  }
  return rods;
}

/// The armature's side of a chain at a moment.
struct PhysicalChain {
  PointsX3 curve;                  ///< P x 3
  std::vector<Quaterniond> turns;  ///< P-1
};

}  // namespace

struct PuppetMatcher::Impl {
  Armature armature;
  ChainPlan plan;
  Skeleton skeleton;
  Similarity3 world_from_armature;
  Quaterniond world_turn;
  PuppetOptions options;

  std::vector<ChainRods> rods;
  std::vector<int> chain_of_bone;   ///< -1: none, it follows its parent
  std::vector<int> anchor_of_bone;  ///< the anchor at a bone's parent joint, for bones of no chain
  std::vector<std::vector<int>> chains_of_joint;
  std::vector<Rigid3> frames;
  std::vector<double> values;
  SkeletonPose pose;
  std::vector<ChainState> states;
  int matched = 0;
  bool moved = false;

  Vector3d InWorld(int node) const { return world_from_armature * frames[node].translation; }
  /// How a node has turned since the zero position, in the skeleton's world.
  Quaterniond TurnOf(int node) const {
    return world_turn * frames[node].rotation * world_turn.conjugate();
  }

  PhysicalChain Physical(const Chain& chain) const {
    PhysicalChain physical;
    const int count = SizeOf(chain.nodes);
    physical.curve.resize(count, 3);
    for (int p = 0; p < count; ++p) physical.curve.row(p) = InWorld(chain.nodes[p]);
    // What lies between two nodes is fixed to what the lower of both stands on: if that is a joint,
    // its own turn comes after the piece.
    for (int p = 0; p + 1 < count; ++p) {
      const int lower = std::max(chain.nodes[p], chain.nodes[p + 1]);
      physical.turns.push_back(TurnOf(armature.nodes[lower].parent));
    }
    return physical;
  }

  void Prepare() {
    for (const Chain& chain : plan.chains) rods.push_back(RodsOf(chain, plan, skeleton));
    chain_of_bone.assign(skeleton.joints.size(), -1);
    for (int c = 0; c < SizeOf(rods); ++c)
      for (const auto& bones : rods[c].bones)
        for (const int bone : bones) {
          if (chain_of_bone[bone] >= 0)
            RefuseChain(plan.chains[c], "the bone to joint '" + skeleton.joints[bone].name +
                                            "' belongs to another chain too");
          chain_of_bone[bone] = c;
        }
    FindAnchors();
    frames = ForwardKinematics(armature, std::vector<double>(armature.joints.size(), 0));
    for (int c = 0; c < SizeOf(rods); ++c) AlignZero(c);
  }

  void FindAnchors() {
    anchor_of_bone.assign(skeleton.joints.size(), -1);
    for (int a = 0; a < SizeOf(plan.anchors); ++a) {
      const int joint = skeleton.Find(plan.anchors[a].computer);
      if (joint < 0) continue;
      for (int j = 0; j < skeleton.size(); ++j)
        if (skeleton.joints[j].parent == joint) anchor_of_bone[j] = a;
      if (skeleton.joints[joint].parent < 0) anchor_of_bone[joint] = a;
    }
  }

  /// How the chain lies in the zero position, and the turn that each rod takes from rest to there:
  /// that with the least twist along the chain.
  void AlignZero(int c) {
    ChainRods& chain = rods[c];
    const Polyline curve(Physical(plan.chains[c]).curve);
    const bool exact = plan.chains[c].mode == ChainMode::kExact;
    if (exact) RequireAsMany(c, curve);
    const ChainMatch match =
        exact ? MatchGreedily(curve, chain.lengths) : Match(curve, chain.lengths, {}, nullptr);
    const Directions exact_directions = exact ? PieceDirections(curve) : Directions();
    chain.zero.resize(chain.lengths.size(), 3);
    Quaterniond turn = Quaterniond::Identity();
    for (Eigen::Index i = 0; i < chain.lengths.size(); ++i) {
      chain.zero.row(i) = exact ? exact_directions[i] : Vector3d(match.directions.row(i));
      turn = Redirected(turn, turn * Vector3d(chain.rest.row(i)), chain.zero.row(i));
      chain.zero_from_rest.push_back(turn);
    }
  }

  static Directions PieceDirections(const Polyline& curve) {
    Directions directions;
    for (Eigen::Index p = 0; p + 1 < curve.points().rows(); ++p)
      if (curve.ends()[p + 1] > curve.ends()[p])
        directions.push_back((curve.points().row(p + 1) - curve.points().row(p)).normalized());
    return directions;
  }

  void RequireAsMany(int c, const Polyline& curve) const {
    const int pieces = SizeOf(PieceDirections(curve)), count = SizeOf(rods[c].joints) - 1;
    if (pieces != count)
      RefuseChain(plan.chains[c], "it is exact, but has " + std::to_string(pieces) +
                                      " rods in the armature and " + std::to_string(count) +
                                      " in the computer skeleton; use mode match");
  }

  ChainMatch Match(const Polyline& curve, const Eigen::VectorXd& lengths, const PointsX3& wanted,
                   const ChainMatch* before) const {
    return options.greedy ? MatchGreedily(curve, lengths)
                          : MatchBothEnds(curve, lengths, wanted, before, options.match);
  }

  /// The physical curve with its beginning where the chain's first joint already is; that moves
  /// linearly to nothing at the far end.
  static void BeginAt(const Vector3d& start, PointsX3& curve) {
    const Vector3d shift = start - curve.row(0).transpose();
    const Polyline before(curve);
    for (Eigen::Index p = 0; p < curve.rows(); ++p)
      curve.row(p) += (1 - before.ends()[p] / std::max(before.length(), 1e-300)) * shift;
  }

  /// Joints are placed by the chains before; a near anchor that none has placed stands where the
  /// armature's does.
  void MatchChain(int c, bool first) {
    const Chain& chain = plan.chains[c];
    const ChainRods& rod = rods[c];
    PhysicalChain physical = Physical(chain);
    const int near = rod.joints.front();
    if (placed_by_[near] < 0)
      pose.joints.row(near) = physical.curve.row(0);
    else
      BeginAt(pose.joints.row(near), physical.curve);
    starts_[c] = pose.joints.row(near);
    const bool exact = chain.mode == ChainMode::kExact;
    const Polyline curve(physical.curve);
    const auto turns =
        exact ? ExactTurns(curve, physical.turns) : TurnsAlong(curve, physical.turns, rod.lengths);
    PointsX3 wanted(rod.lengths.size(), 3);
    for (Eigen::Index i = 0; i < wanted.rows(); ++i)
      wanted.row(i) = turns[i] * Vector3d(rod.zero.row(i));
    ChainMatch match =
        exact ? Measured(curve, rod.lengths, DirectionsOf(wanted), curve.points().row(0))
              : Match(curve, rod.lengths, wanted, first ? nullptr : &states[c].match);
    Place(c, turns, wanted, match);
    states[c].match = std::move(match);
  }

  static std::vector<Quaterniond> ExactTurns(const Polyline& curve,
                                             const std::vector<Quaterniond>& turns) {
    std::vector<Quaterniond> kept;
    for (int p = 0; p < SizeOf(turns); ++p)
      if (curve.ends()[p + 1] > curve.ends()[p]) kept.push_back(turns[p]);
    return kept;
  }

  void Place(int c, const std::vector<Quaterniond>& turns, const PointsX3& wanted,
             const ChainMatch& match) {
    const ChainRods& rod = rods[c];
    for (Eigen::Index i = 0; i < rod.lengths.size(); ++i) {
      const Quaterniond turn =
          Redirected(turns[i], wanted.row(i), match.directions.row(i)) * rod.zero_from_rest[i];
      const Vector3d begin = match.joints.row(i);
      for (const int bone : rod.bones[i])
        SetBone(bone, turn, begin - turn * skeleton.joints[rod.joints[i]].rest);
      pose.joints.row(rod.joints[i + 1]) = match.joints.row(i + 1);
    }
  }

  /// Of the two quaternions of a rotation, that nearer to the bone's last one.
  void SetBone(int bone, Quaterniond turn, const Vector3d& shift) {
    turn.normalize();
    if (turn.dot(pose.bones[bone].rotation) < 0) turn.coeffs() *= -1;
    pose.bones[bone] = {turn, shift};
  }

  /// Bones of no chain: those at an anchor turn with the armature there, others with their parent.
  void PlaceOthers() {
    for (int j = 0; j < skeleton.size(); ++j) {
      if (chain_of_bone[j] >= 0) {
        if (!held_[j]) pose.joints.row(j) = pose.bones[j] * skeleton.joints[j].rest;
        continue;
      }
      const int parent = skeleton.joints[j].parent, anchor = anchor_of_bone[j];
      const int hinge = parent < 0 ? j : parent;
      if (anchor >= 0)
        SetBone(j, TurnOf(plan.anchors[anchor].node), Vector3d::Zero());
      else if (parent >= 0)
        pose.bones[j] = pose.bones[parent];
      const Vector3d at = pose.joints.row(hinge);
      pose.bones[j].translation = at - pose.bones[j].rotation * skeleton.joints[hinge].rest;
      if (!held_[j]) pose.joints.row(j) = pose.bones[j] * skeleton.joints[j].rest;
    }
  }

  void Update(const std::vector<double>& next) {
    const bool first = values.empty();
    std::vector<char> dirty(rods.size(), first ? 1 : 0);
    moved = first;
    for (int j = 0; j < SizeOf(next); ++j) {
      if (!first && next[j] == values[j]) continue;
      moved = true;
      for (const int chain : chains_of_joint[j]) dirty[chain] = 1;
    }
    matched = 0;
    if (!moved) return;
    ForwardKinematics(armature, next, &frames);
    for (int c = 0; c < SizeOf(rods); ++c) {
      const Vector3d start = pose.joints.row(rods[c].joints.front());
      if (!dirty[c] && start == starts_[c]) continue;
      MatchChain(c, first);
      ++matched;
    }
    PlaceOthers();
    values = next;
  }

  void Start() {
    placed_by_.assign(skeleton.joints.size(), -1);
    for (int c = 0; c < SizeOf(rods); ++c)
      for (std::size_t i = 1; i < rods[c].joints.size(); ++i) placed_by_[rods[c].joints[i]] = c;
    starts_.assign(rods.size(), Vector3d::Zero());
    held_.assign(skeleton.joints.size(), 0);
    for (const ChainRods& rod : rods)
      for (const int joint : rod.joints) held_[joint] = 1;
    pose.bones.resize(skeleton.joints.size());
    pose.joints.resize(skeleton.size(), 3);
    for (int j = 0; j < skeleton.size(); ++j) pose.joints.row(j) = skeleton.joints[j].rest;
    for (int c = 0; c < SizeOf(rods); ++c)
      states.push_back({plan.chains[c].name, {}, rods[c].lengths.sum()});
  }

  std::vector<int> placed_by_;    ///< the chain that places a joint; -1: none
  std::vector<char> held_;        ///< joints of chains, which stand where those put them
  std::vector<Vector3d> starts_;  ///< where each chain began in its last match
};

PuppetMatcher::PuppetMatcher(const Armature& armature, const ChainPlan& plan,
                             const Skeleton& skeleton, const Similarity3& world_from_armature,
                             const PuppetOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->armature = armature;
  impl_->plan = plan;
  impl_->skeleton = skeleton;
  impl_->world_from_armature = world_from_armature;
  impl_->world_turn = Quaterniond(world_from_armature.rotation).normalized();
  impl_->options = options;
  impl_->chains_of_joint = ChainsMovedBy(armature, plan);
  impl_->Prepare();
  impl_->Start();
}
PuppetMatcher::~PuppetMatcher() = default;
PuppetMatcher::PuppetMatcher(PuppetMatcher&&) noexcept = default;

const SkeletonPose& PuppetMatcher::Update(const std::vector<double>& values) {
  if (values.size() != impl_->armature.joints.size())
    throw InputError("armature: " + std::to_string(values.size()) + " values for an armature of " +
                     std::to_string(impl_->armature.joints.size()) + " joints");
  for (std::size_t j = 0; j < values.size(); ++j)
    if (!std::isfinite(values[j]))
      throw InputError("armature: the value of joint '" +
                       impl_->armature.nodes[impl_->armature.joints[j]].name +
                       "' is not a finite number");
  impl_->Update(values);
  return impl_->pose;
}

const SkeletonPose& PuppetMatcher::pose() const { return impl_->pose; }
const std::vector<ChainState>& PuppetMatcher::chains() const { return impl_->states; }
int PuppetMatcher::matched() const { return impl_->matched; }
bool PuppetMatcher::moved() const { return impl_->moved; }

Similarity3 PlacementOf(const Armature& armature, const ChainPlan& plan, const Skeleton& skeleton,
                        bool y_up) {
  if (plan.chains.empty()) throw InputError("armature: the chain file has no chain");
  const auto frames = ForwardKinematics(armature, std::vector<double>(armature.joints.size(), 0));
  double physical = 0, computer = 0;
  for (const Chain& chain : plan.chains) {
    computer += RodsOf(chain, plan, skeleton).lengths.sum();
    for (std::size_t n = 1; n < chain.nodes.size(); ++n)
      physical +=
          (frames[chain.nodes[n]].translation - frames[chain.nodes[n - 1]].translation).norm();
  }
  if (!(physical > 0)) throw InputError("armature: the chains have no rods in the armature");
  Similarity3 placement;
  placement.scale = computer / physical;
  if (y_up) placement.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  const Anchor& root = plan.anchors[plan.chains.front().from];
  const int joint = JointOf(plan.chains.front(), skeleton, root.computer);
  placement.translation = skeleton.joints[joint].rest -
                          placement.scale * (placement.rotation * frames[root.node].translation);
  return placement;
}

}  // namespace keypose::armature
