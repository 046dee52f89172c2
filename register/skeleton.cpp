#include "register/skeleton.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <optional>

#include "core/geometry.h"
#include "core/kd_tree.h"
#include "core/parallel.h"
#include "core/ray_scene.h"
#include "register/curve_skeleton.h"
#include "register/parts.h"
#include "register/skeleton_tree.h"

namespace keypose::registration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kSamples = 48;        // of a limb
constexpr int kSmoothing = 6;       // rounds over the samples of a limb
constexpr int kCentering = 3;       // rounds
constexpr int kSpokes = 6;          // chords of a section
constexpr double kPrior = 0.1;      // weight of the known turn against one limb's direction
constexpr double kOffAxis = 0.6;    // of the radius: nearer to the axis a landmark says nothing of the turn about it
constexpr int kAttempts = 8;        // matchings of limbs that are carried out to be compared
constexpr int kProbes = 400;        // vertices by which they are compared
constexpr double kWorthTrying = 4;  // times the cost of the best, above which a matching is not tried
constexpr double kUnsure = 1.25;    // a second matching of limbs that costs less than this much more makes the first doubtful

using Mark = std::pair<Vector3d, Vector3d>;  // a landmark's place on the source and on the target

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// One mesh without its loose parts, and all that is derived of it.
struct Body {
  LooseParts loose;
  Mesh mesh;
  RayScene scene;
  CurveSkeleton skeleton;
  std::optional<KdTree> surface_tree;  // of skeleton.surface
  std::optional<SkeletonTree> tree;

  Body(const Mesh& whole, int proxy_faces)
      : loose(FindLooseParts(whole)),
        mesh(HostOf(whole, loose)),
        scene(mesh.points, mesh.faces),
        skeleton(ExtractCurveSkeleton(mesh.points, mesh.faces, proxy_faces)) {
    if (!skeleton.fault.empty()) return;
    surface_tree.emplace(skeleton.surface);
    tree.emplace(skeleton, scene);
  }
  int NodeOf(const Vector3d& p) const { return skeleton.node_of[surface_tree->Nearest(p).index]; }
};

/// A limb of one body as equally spaced samples, from the joint nearer to the root outwards.
struct Axis {
  PointsX3 points;  // kSamples + 1
  double length = 0;

  Vector3d At(double share) const {
    const double x = std::clamp(share, 0.0, 1.0) * kSamples;
    const int k = std::min(static_cast<int>(x), kSamples - 1);
    return points.row(k) + (x - k) * (points.row(k + 1) - points.row(k));
  }
  Vector3d Tangent(double share) const { return (At(share + 0.03) - At(share - 0.03)).normalized(); }
  /// Share of the length at the sample that is nearest to p, between two shares.
  double Project(const Vector3d& p, double low = 0, double high = 1) const {
    double best = std::numeric_limits<double>::infinity(), share = low;
    for (int k = 0; k < kSamples; ++k) {
      if ((k + 1.0) / kSamples < low || static_cast<double>(k) / kSamples > high) continue;
      const Vector3d a = points.row(k), d = points.row(k + 1) - points.row(k);
      const double x = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
      const double distance = (a + x * d - p).squaredNorm();
      if (distance >= best) continue;
      best = distance;
      share = (k + x) / kSamples;
    }
    return std::clamp(share, low, high);
  }
};

PointsX3 Resampled(const std::vector<Vector3d>& line, double& length) {
  std::vector<double> arc(line.size(), 0);
  for (std::size_t k = 1; k < line.size(); ++k) arc[k] = arc[k - 1] + (line[k] - line[k - 1]).norm();
  length = arc.back();
  PointsX3 points(kSamples + 1, 3);
  std::size_t k = 1;
  for (int i = 0; i <= kSamples; ++i) {
    const double at = length * i / kSamples;
    while (k + 1 < line.size() && arc[k] < at) ++k;
    const double span = arc[k] - arc[k - 1];
    const double x = span > 0 ? std::clamp((at - arc[k - 1]) / span, 0.0, 1.0) : 0;
    points.row(i) = (line[k - 1] + x * (line[k] - line[k - 1])).transpose();
  }
  return points;
}

void Smooth(PointsX3& points) {
  for (int round = 0; round < kSmoothing; ++round) {
    const PointsX3 before = points;
    for (int i = 1; i < kSamples; ++i) points.row(i) = (before.row(i - 1) + 2 * before.row(i) + before.row(i + 1)) / 4;
  }
}

/// The contraction ends nearer to the inner side of a bend: samples move to the middle between the walls, square to the line.
/// @param first  samples before this one stay, since they lie inside a joint
/// @param thick  radius of the limb, about
void Center(const RayScene& surface, int first, double thick, PointsX3& points) {
  for (int round = 0; round < kCentering; ++round) {
    PointsX3 moved = points;
    for (int i = std::max(1, first); i < kSamples; ++i) {
      const Vector3d p = points.row(i), tangent = (points.row(i + 1) - points.row(i - 1)).normalized();
      const Vector3d u = tangent.unitOrthogonal(), v = tangent.cross(u);
      const double reach = 3 * std::max(thick, std::sqrt(surface.ClosestPoint(p).squared_distance));
      Vector3d shift = Vector3d::Zero();
      int used = 0;
      for (int k = 0; k < kSpokes; ++k) {
        const Vector3d way = std::cos(M_PI * k / kSpokes) * u + std::sin(M_PI * k / kSpokes) * v;
        const RayScene::Hit there = surface.Cast(p, way), back = surface.Cast(p, -way);
        if (there.face < 0 || back.face < 0 || there.distance > reach || back.distance > reach) continue;
        shift += (there.distance - back.distance) / 2 * way;
        ++used;
      }
      // In a round section the chords' middles lie, on average, half way to the centre.
      if (2 * used > kSpokes) moved.row(i) += (2.0 / used * shift).transpose() * 0.8;
    }
    points = moved;
    Smooth(points);
  }
}

Axis MakeAxis(const Body& body, const Limb& limb, bool backwards, bool to_tip) {
  std::vector<Vector3d> line;
  for (int n : limb.nodes) line.emplace_back(body.tree->nodes().row(n));
  if (backwards) std::reverse(line.begin(), line.end());
  Axis axis;
  axis.points = Resampled(line, axis.length);
  Smooth(axis.points);
  const double ball = body.tree->joints()[backwards ? limb.to : limb.from].radius;
  // Where the line strayed to a wall its own distance says little; the limb's thicker places tell how far the walls can be.
  std::vector<double> radii;
  for (int n : limb.nodes)
    if (body.tree->radius()[n] < 0.8 * ball || limb.nodes.size() < 8) radii.push_back(body.tree->radius()[n]);
  std::sort(radii.begin(), radii.end());
  const double thick = radii.empty() ? 0 : radii[radii.size() * 4 / 5];
  Center(body.scene, static_cast<int>(kSamples * ball / std::max(axis.length, 1e-300)), thick, axis.points);
  line.clear();
  for (int i = 0; i <= kSamples; ++i) line.emplace_back(axis.points.row(i));
  if (to_tip) {
    // The contraction stops short of the surface by another bit in each pose; the surface itself is the better end.
    const double radius = body.tree->radius()[backwards ? limb.nodes.front() : limb.nodes.back()];
    const Vector3d tangent = (line[kSamples] - line[kSamples - 5]).normalized();
    const RayScene::Hit hit = body.scene.Cast(line.back(), tangent);
    if (hit.face >= 0 && hit.distance < 4 * radius + 0.1 * axis.length) line.push_back(line.back() + hit.distance * tangent);
  }
  axis.points = Resampled(line, axis.length);
  return axis;
}

/// A landmark on its limb.
struct LimbMark {
  double source_share = 0, target_share = 0;
  Vector3d source, target;
};

/// A limb of the source beside its counterpart.
struct LimbPair {
  int source_limb = -1;
  bool backwards = false;  // the source limb's own order against the order from the root
  int from = -1, to = -1;  // source joints, from nearer to the root
  Axis source, target;
  std::vector<std::pair<double, double>> knots;  // shares of the source's and the target's length, ascending in both
  std::vector<LimbMark> marks;
  std::vector<Matrix3d> turns;  // kSamples + 1: target from source
  double quiet = 0;             // share of the length that lies inside the joint's ball

  double TargetShare(double share) const {
    std::size_t k = 1;
    while (k + 1 < knots.size() && knots[k].first < share) ++k;
    const auto& [s0, t0] = knots[k - 1];
    const auto& [s1, t1] = knots[k];
    return t0 + (t1 - t0) * std::clamp((share - s0) / std::max(s1 - s0, 1e-12), 0.0, 1.0);
  }
};

/// How a joint moves.
struct JointMotion {
  Vector3d source = Vector3d::Zero(), target = Vector3d::Zero();
  Matrix3d turn = Matrix3d::Identity();
  double radius = 0;
  bool known = false;
};

Matrix3d LeastTurn(const Vector3d& from, const Vector3d& to) { return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix(); }

/// The rotation that best takes directions to directions, near a known one.
Matrix3d FitTurn(const std::vector<std::pair<Vector3d, Vector3d>>& directions, const std::vector<double>& weights, const Matrix3d& prior,
                 double prior_weight) {
  Matrix3d sum = prior_weight * prior;
  for (std::size_t i = 0; i < directions.size(); ++i) sum += weights[i] * directions[i].second * directions[i].first.transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

/// Frames along a line that turn no more than they must. Source: Wang et al., Computation of Rotation Minimizing Frames, 2008 (double
/// reflection).
std::vector<Matrix3d> Frames(const std::vector<Vector3d>& points, const std::vector<Vector3d>& tangents, const Matrix3d& first) {
  std::vector<Matrix3d> frames{first};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vector3d v1 = points[i + 1] - points[i];
    const double c1 = v1.squaredNorm();
    Matrix3d next = frames.back();
    if (c1 > 0) {
      const auto reflect = [](const Vector3d& x, const Vector3d& v, double c) { return (x - 2 / c * v.dot(x) * v).eval(); };
      const Vector3d r = reflect(frames.back().col(1), v1, c1), t = reflect(frames.back().col(0), v1, c1);
      const Vector3d v2 = tangents[i + 1] - t;
      const double c2 = v2.squaredNorm();
      const Vector3d side = c2 > 1e-24 ? reflect(r, v2, c2) : r;
      next.col(0) = tangents[i + 1];
      next.col(1) = (side - side.dot(next.col(0)) * next.col(0)).normalized();
      next.col(2) = next.col(0).cross(next.col(1));
    }
    frames.push_back(next);
  }
  return frames;
}

/// The source's motion, worked out joint by joint from the root.
class Motion {
 public:
  Motion(const Body& source, const Body& target, const TipMatch& match, const std::vector<Mark>& landmarks, const Similarity3& coarse,
         double scale)
      : source_(source), target_(target), coarse_(coarse), scale_(scale), joints_(source.tree->joints().size()), marks_(landmarks) {
    PairJoints(match);
    int root = 0;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const Joint& joint = source.tree->joints()[j];
      // A thick fork; where there is none, the thick end of the only limb.
      const auto rank = [](const Joint& a) { return std::pair(!a.tip(), a.radius); };
      if (rank(joint) > rank(source.tree->joints()[root])) root = static_cast<int>(j);
    }
    Walk(root);
  }

  /// Points on the source's surface, moved.
  PointsX3 Apply(const PointsX3& points) const;
  int limb_count() const { return static_cast<int>(pairs_.size()); }

 private:
  void PairJoints(const TipMatch& match);
  void Walk(int root);
  void AddLimbs(int joint, int came_by);
  void PlaceMarks(LimbPair& pair);
  void TurnJoint(int joint, int came_by, const Matrix3d& prior, double prior_weight);
  void TurnLimb(LimbPair& pair);
  void Twist(LimbPair& pair, const std::vector<Vector3d>& tangents);
  Vector3d Moved(const LimbPair& pair, double share, const Vector3d& x) const;

  const Body& source_;
  const Body& target_;
  const Similarity3& coarse_;
  double scale_;
  std::vector<JointMotion> joints_;             // by source joint
  std::vector<int> target_joint_;               // by source joint
  std::vector<std::array<int, 2>> limb_match_;  // source limb -> target limb, 1 when it runs the other way
  std::vector<LimbPair> pairs_;
  std::vector<int> pair_of_limb_;
  const std::vector<Mark>& marks_;
};

void Motion::PairJoints(const TipMatch& match) {
  const SkeletonTree &s = *source_.tree, &t = *target_.tree;
  std::vector<int> s_label(s.joints().size(), -1), t_label(t.joints().size(), -1);
  for (std::size_t k = 0; k < match.pairs.size(); ++k) {
    s_label[match.pairs[k].first] = static_cast<int>(k);
    t_label[match.pairs[k].second] = static_cast<int>(k);
  }
  const std::uint32_t all = (1u << match.pairs.size()) - 1;
  target_joint_.assign(s.joints().size(), -1);
  limb_match_.assign(s.limbs().size(), {-1, 0});
  for (std::size_t l = 0; l < s.limbs().size(); ++l) {
    const std::uint32_t bits = s.TipsBeyond(static_cast<int>(l), s_label);
    for (std::size_t m = 0; m < t.limbs().size(); ++m) {
      const std::uint32_t other = t.TipsBeyond(static_cast<int>(m), t_label);
      if (other != bits && other != (all & ~bits)) continue;
      const bool turned = other != bits;
      limb_match_[l] = {static_cast<int>(m), turned ? 1 : 0};
      target_joint_[s.limbs()[l].from] = turned ? t.limbs()[m].to : t.limbs()[m].from;
      target_joint_[s.limbs()[l].to] = turned ? t.limbs()[m].from : t.limbs()[m].to;
    }
  }
}

/// Limb pairs in order from the root.
void Motion::AddLimbs(int joint, int came_by) {
  const SkeletonTree &s = *source_.tree, &t = *target_.tree;
  for (int l : s.joints()[joint].limbs) {
    if (l == came_by || limb_match_[l][0] < 0) continue;
    const Limb& limb = s.limbs()[l];
    LimbPair pair;
    pair.source_limb = l;
    pair.backwards = limb.from != joint;
    pair.from = joint;
    pair.to = pair.backwards ? limb.from : limb.to;
    const bool tip = s.joints()[pair.to].tip();
    pair.source = MakeAxis(source_, limb, pair.backwards, tip);
    pair.target = MakeAxis(target_, t.limbs()[limb_match_[l][0]], pair.backwards != (limb_match_[l][1] == 1), tip);
    pair.quiet = std::min(0.4, s.joints()[joint].radius / std::max(pair.source.length, 1e-300));
    PlaceMarks(pair);
    pair_of_limb_[l] = static_cast<int>(pairs_.size());
    pairs_.push_back(std::move(pair));
    AddLimbs(pairs_.back().to, l);
  }
}

/// Landmarks on this limb; those that agree with an orderly stretch become knots between the arc lengths.
void Motion::PlaceMarks(LimbPair& pair) {
  for (const auto& [from, to] : marks_) {
    const NodePlace place = source_.tree->PlaceOf(source_.NodeOf(from)), other = target_.tree->PlaceOf(target_.NodeOf(to));
    const bool at_tip = place.joint >= 0 && place.joint == pair.to;
    if (place.limb != pair.source_limb && !at_tip) continue;
    const bool other_at_tip = other.joint >= 0 && other.joint == target_joint_[pair.to];
    if (other.limb != limb_match_[pair.source_limb][0] && !other_at_tip) continue;
    const double length = source_.tree->limbs()[pair.source_limb].length,
                 other_length = target_.tree->limbs()[limb_match_[pair.source_limb][0]].length;
    const auto guess = [](const NodePlace& p, double whole, bool backwards, bool tip) {
      return tip ? 1 : backwards ? 1 - p.arc / whole : p.arc / whole;
    };
    const double s = guess(place, length, pair.backwards, at_tip);
    const double t = guess(other, other_length, pair.backwards != (limb_match_[pair.source_limb][1] == 1), other_at_tip);
    pair.marks.push_back({pair.source.Project(from, std::max(0.0, s - 0.12), std::min(1.0, s + 0.12)),
                          pair.target.Project(to, std::max(0.0, t - 0.12), std::min(1.0, t + 0.12)), from, to});
  }
  std::sort(pair.marks.begin(), pair.marks.end(), [](const LimbMark& a, const LimbMark& b) { return a.source_share < b.source_share; });
  pair.knots = {{0, 0}};
  for (const LimbMark& m : pair.marks) {
    const double ds = m.source_share - pair.knots.back().first, dt = m.target_share - pair.knots.back().second;
    const double rest_s = 1 - m.source_share, rest_t = 1 - m.target_share;
    const auto orderly = [](double a, double b) { return a > 0.08 && b > 0.4 * a && b < 2.5 * a; };
    if (orderly(ds, dt) && orderly(rest_s, rest_t)) pair.knots.emplace_back(m.source_share, m.target_share);
  }
  pair.knots.emplace_back(1, 1);
}

void Motion::TurnJoint(int joint, int came_by, const Matrix3d& prior, double prior_weight) {
  JointMotion& m = joints_[joint];
  m.radius = source_.tree->joints()[joint].radius;
  m.source = m.target = Vector3d::Zero();
  std::vector<std::pair<Vector3d, Vector3d>> directions;
  std::vector<double> weights;
  double count = 0;
  for (int l : source_.tree->joints()[joint].limbs) {
    if (pair_of_limb_[l] < 0) continue;
    const LimbPair& pair = pairs_[pair_of_limb_[l]];
    const bool outwards = l != came_by;
    m.source += outwards ? pair.source.At(0) : pair.source.At(1);
    m.target += outwards ? pair.target.At(0) : pair.target.At(1);
    ++count;
  }
  m.source /= count;
  m.target /= count;
  for (int l : source_.tree->joints()[joint].limbs) {
    if (pair_of_limb_[l] < 0) continue;
    const LimbPair& pair = pairs_[pair_of_limb_[l]];
    const double reach = std::min(0.5, 1.6 * m.radius / std::max(pair.source.length, 1e-300));
    const double share = l != came_by ? reach : 1 - reach;
    directions.emplace_back((pair.source.At(share) - m.source).normalized(),
                            (pair.target.At(pair.TargetShare(share)) - m.target).normalized());
    weights.push_back(1);
  }
  for (const auto& [from, to] : marks_) {
    const NodePlace place = source_.tree->PlaceOf(source_.NodeOf(from));
    const bool near = (from - m.source).norm() < 1.5 * m.radius && (to - m.target).norm() < 2 * scale_ * m.radius;
    if (place.joint != joint && !near) continue;
    directions.emplace_back((from - m.source) / m.radius, (to - m.target) / (scale_ * m.radius));
    weights.push_back(0.7);
  }
  m.turn = FitTurn(directions, weights, prior, prior_weight);
  m.known = true;
}

/// What landmarks off the axis say of the turn about it: linear along the limb, none at its root.
void Motion::Twist(LimbPair& pair, const std::vector<Vector3d>& tangents) {
  double sum_uu = 0.02, sum_ua = 0, radius = 0;
  const std::vector<int>& run = source_.tree->limbs()[pair.source_limb].nodes;
  for (int n : run) radius += source_.tree->radius()[n] / static_cast<double>(run.size());
  for (const LimbMark& m : pair.marks) {
    const double u = (m.source_share - pair.quiet) / (1 - pair.quiet);
    if (u <= 0.05) continue;
    const int k = static_cast<int>(std::lround(m.source_share * kSamples));
    const Vector3d t = tangents[k];
    const Vector3d place = pair.source.At(m.source_share);
    Vector3d a = pair.turns[k] * (m.source - place), b = m.target - pair.target.At(m.target_share);
    a -= a.dot(t) * t;
    b -= b.dot(t) * t;
    if (a.norm() < kOffAxis * radius || b.norm() < kOffAxis * scale_ * radius) continue;
    const double angle = std::atan2(t.dot(a.cross(b)), a.dot(b));
    sum_uu += u * u;
    sum_ua += u * angle;
  }
  for (int k = 0; k <= kSamples; ++k) {
    const double u = std::max(0.0, (static_cast<double>(k) / kSamples - pair.quiet) / (1 - pair.quiet));
    pair.turns[k] = Eigen::AngleAxisd(u * sum_ua / sum_uu, tangents[k]).toRotationMatrix() * pair.turns[k];
  }
}

void Motion::TurnLimb(LimbPair& pair) {
  std::vector<Vector3d> sp, st, tp, tt;
  for (int k = 0; k <= kSamples; ++k) {
    const double s = static_cast<double>(k) / kSamples, t = pair.TargetShare(s);
    sp.push_back(pair.source.At(s));
    st.push_back(pair.source.Tangent(s));
    tp.push_back(pair.target.At(t));
    tt.push_back(pair.target.Tangent(t));
  }
  // Inside the joint's ball the line wanders: the frames start where it leaves.
  const int start = std::min(kSamples - 4, static_cast<int>(std::lround(pair.quiet * kSamples)));
  const Matrix3d& joint = joints_[pair.from].turn;
  const auto from = [&](std::vector<Vector3d>& v) { return std::vector<Vector3d>(v.begin() + start, v.end()); };
  Matrix3d first;
  first.col(0) = st[start];
  first.col(1) = st[start].unitOrthogonal();
  first.col(2) = first.col(0).cross(first.col(1));
  const Matrix3d first_turn = LeastTurn(joint * st[start], tt[start]) * joint;
  const std::vector<Matrix3d> source_frames = Frames(from(sp), from(st), first),
                              target_frames = Frames(from(tp), from(tt), first_turn * first);
  pair.turns.assign(kSamples + 1, joint);
  for (int k = start; k <= kSamples; ++k) pair.turns[k] = target_frames[k - start] * source_frames[k - start].transpose();
  const Eigen::Quaterniond q0(joint), q1(first_turn);
  for (int k = 0; k < start; ++k) pair.turns[k] = q0.slerp(static_cast<double>(k) / start, q1).toRotationMatrix();
  Twist(pair, tt);
}

void Motion::Walk(int root) {
  pair_of_limb_.assign(source_.tree->limbs().size(), -1);
  AddLimbs(root, -1);
  TurnJoint(root, -1, coarse_.rotation, kPrior);
  // Pairs come parents first.
  for (LimbPair& pair : pairs_) {
    TurnLimb(pair);
    if (!source_.tree->joints()[pair.to].tip()) TurnJoint(pair.to, pair.source_limb, pair.turns.back(), 3 * kPrior);
  }
}

/// Motion at a share of a limb, averaged over a stretch as long as the limb is thick.
Vector3d Motion::Moved(const LimbPair& pair, double share, const Vector3d& x) const {
  const double reach = std::clamp(0.5 * (x - pair.source.At(share)).norm() / std::max(pair.source.length, 1e-300), 0.5 / kSamples, 0.2);
  const int low = std::max(0, static_cast<int>(std::floor((share - 2 * reach) * kSamples)));
  const int high = std::min(kSamples, static_cast<int>(std::ceil((share + 2 * reach) * kSamples)));
  Vector3d sum = Vector3d::Zero();
  double total = 0;
  for (int k = low; k <= high; ++k) {
    const double s = static_cast<double>(k) / kSamples, d = (s - share) / reach;
    const double w = std::exp(-0.5 * d * d);
    sum += w * (pair.target.At(pair.TargetShare(s)) + scale_ * (pair.turns[k] * (x - pair.source.At(s))));
    total += w;
  }
  return sum / total;
}

PointsX3 Motion::Apply(const PointsX3& points) const {
  const SkeletonTree& tree = *source_.tree;
  std::vector<NodePlace> places;
  for (Eigen::Index n = 0; n < tree.nodes().rows(); ++n) places.push_back(tree.PlaceOf(static_cast<int>(n)));
  PointsX3 moved(points.rows(), 3);
  ParallelBlocks(points.rows(), 128, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const Vector3d x = points.row(v);
      const NodePlace& place = places[source_.NodeOf(x)];
      const LimbPair* pair = nullptr;
      double share = 0;
      if (place.limb >= 0) {
        pair = &pairs_[pair_of_limb_[place.limb]];
        share = place.arc / tree.limbs()[place.limb].length;
        if (pair->backwards) share = 1 - share;
      } else if (tree.joints()[place.joint].tip() && !joints_[place.joint].known) {
        pair = &pairs_[pair_of_limb_[tree.joints()[place.joint].limbs.front()]];
        share = 1;
      }
      const auto rigid = [&](const JointMotion& joint) { return (joint.target + scale_ * (joint.turn * (x - joint.source))).eval(); };
      if (!pair) {
        moved.row(v) = rigid(joints_[place.joint]);
        continue;
      }
      const double thick = (x - pair->source.At(share)).norm() / std::max(pair->source.length, 1e-300);
      share = pair->source.Project(x, std::max(0.0, share - 0.05 - thick), std::min(1.0, share + 0.05 + thick));
      Vector3d p = Moved(*pair, share, x);
      // Within a joint's ball the limb gives way to the joint.
      for (int j : {pair->from, pair->to}) {
        const JointMotion& joint = joints_[j];
        if (!joint.known || !(joint.radius > 0)) continue;
        const double along = (j == pair->from ? share : 1 - share) * pair->source.length;
        const double u = std::clamp(along / joint.radius, 0.0, 1.0);
        const double w = 1 - u * u * (3 - 2 * u);
        p = w * rigid(joint) + (1 - w) * p;
      }
      moved.row(v) = p;
    }
  });
  return moved;
}

std::string Percent(double share) {
  const double rounded = std::round(1000 * share) / 10;
  std::string text = std::to_string(rounded);
  return text.substr(0, text.find('.') + 2) + " %";
}

/// Mean distance to the target's surface, over its diagonal.
double Misfit(const PointsX3& points, const Body& target) {
  double sum = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v) sum += std::sqrt(target.scene.ClosestPoint(points.row(v)).squared_distance);
  return sum / static_cast<double>(points.rows()) / BoundingDiagonal(target.mesh.points);
}

TreeEvidence Evidence(const Body& source, const Body& target, const std::vector<Mark>& landmarks, const Similarity3& coarse) {
  TreeEvidence evidence;
  evidence.scale = std::sqrt(SurfaceArea(target.mesh.points, target.mesh.faces) / SurfaceArea(source.mesh.points, source.mesh.faces));
  for (const auto& [from, to] : landmarks) {
    evidence.source_nodes.push_back(source.NodeOf(from));
    evidence.target_nodes.push_back(target.NodeOf(to));
  }
  evidence.source_in_target = Transformed(coarse, source.tree->nodes());
  return evidence;
}

SkeletonStart Refused(const std::string& why) {
  SkeletonStart start;
  start.words = why;
  return start;
}

/// Throws away the joint numbers of a match, which change when trees are pruned, for the tips' nodes and back.
TipMatch Renumbered(const TipMatch& match, const SkeletonTree& source_before, const SkeletonTree& target_before, const SkeletonTree& source,
                    const SkeletonTree& target) {
  const auto find = [](const SkeletonTree& before, int joint, const SkeletonTree& now) {
    const int node = before.joints()[joint].nodes.front();
    for (int tip : now.Tips())
      if (now.joints()[tip].nodes.front() == node) return tip;
    return -1;
  };
  TipMatch result = match;
  result.pairs.clear();
  for (const auto& [a, b] : match.pairs) {
    const int s = find(source_before, a, source), t = find(target_before, b, target);
    if (s >= 0 && t >= 0) result.pairs.emplace_back(s, t);
  }
  return result;
}

/// Both start in the ball at the thick end, or neither. Where one has a clear ball the other's may be less clear.
void RootBoth(Body& source, Body& target) {
  const bool first = source.tree->RootThickEnd(source.scene, 1.6, 1.6), second = target.tree->RootThickEnd(target.scene, 1.6, 1.6);
  if (first == second) return;
  (first ? target : source).tree->RootThickEnd((first ? target : source).scene, 1.2, 3);
}

PointsX3 SomeVertices(const PointsX3& points) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / kProbes), count = (points.rows() + stride - 1) / stride;
  PointsX3 some(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) some.row(i) = points.row(i * stride);
  return some;
}

/// One matching of limbs, carried out.
struct Attempt {
  std::string fault;
  double misfit = 0, residual = 0;  ///< of some vertices to the target and of the landmarks, means over the diagonal
  PointsX3 points;
  int limbs = 0;
  double Score() const { return misfit + residual; }
};

/// The bodies' trees are made alike for this matching, and left as they were.
Attempt Try(Body& source, Body& target, const TipMatch& match, const std::vector<Mark>& marks, const Similarity3& coarse, double scale) {
  Attempt attempt;
  const SkeletonTree source_before = *source.tree, target_before = *target.tree;
  attempt.fault = Reconcile(*source.tree, *target.tree, match);
  if (attempt.fault.empty()) {
    const TipMatch now = Renumbered(match, source_before, target_before, *source.tree, *target.tree);
    if (now.pairs.size() < match.pairs.size()) attempt.fault = "a limb vanished while the two were made alike";
    if (attempt.fault.empty()) {
      const Motion motion(source, target, now, marks, coarse, scale);
      attempt.points = motion.Apply(source.mesh.points);
      attempt.limbs = motion.limb_count();
      attempt.misfit = Misfit(SomeVertices(attempt.points), target);
      PointsX3 from(static_cast<Eigen::Index>(marks.size()), 3);
      for (std::size_t i = 0; i < marks.size(); ++i) from.row(static_cast<Eigen::Index>(i)) = marks[i].first.transpose();
      const PointsX3 moved = motion.Apply(from);
      for (std::size_t i = 0; i < marks.size(); ++i)
        attempt.residual += (moved.row(static_cast<Eigen::Index>(i)).transpose() - marks[i].second).norm() /
                            static_cast<double>(marks.size()) / BoundingDiagonal(target.mesh.points);
      if (!attempt.points.allFinite()) attempt.fault = "the limbs are too short to follow";
    }
  }
  *source.tree = source_before;
  *target.tree = target_before;
  return attempt;
}

SkeletonStart MatchBodies(Body& source, Body& target, const std::vector<Mark>& marks, const Similarity3& coarse,
                          const SkeletonOptions& options) {
  RootBoth(source, target);
  const std::size_t tips = source.tree->Tips().size(), other_tips = target.tree->Tips().size();
  const std::string counts = std::to_string(tips) + " ends of limbs on the source and " + std::to_string(other_tips) + " on the target";
  if (static_cast<int>(std::max(tips, other_tips)) > options.max_tips) return Refused("skeletons: too many branches: " + counts);
  if (std::min(tips, other_tips) < 2 || (std::min(tips, other_tips) == 2 && tips != other_tips))
    return Refused("skeletons: the branches differ: " + counts + "; a landmark on each end of a limb would help other starts");
  const TreeEvidence evidence = Evidence(source, target, marks, coarse);
  // Distances along limbs cannot tell left from right; how the whole comes to lie on the target can.
  Attempt best;
  double second = std::numeric_limits<double>::infinity();
  const std::vector<TipMatch> matches = MatchTreeTips(*source.tree, *target.tree, evidence, kAttempts);
  for (const TipMatch& match : matches) {
    if (match.cost > kWorthTrying * matches.front().cost + 0.05) break;
    Attempt attempt = Try(source, target, match, marks, coarse, evidence.scale);
    if (!attempt.fault.empty()) {
      if (best.limbs == 0 && best.fault.empty()) best.fault = attempt.fault;
      continue;
    }
    if (best.limbs > 0 && attempt.Score() >= best.Score()) {
      second = std::min(second, attempt.Score());
      continue;
    }
    if (best.limbs > 0) second = best.Score();
    best = std::move(attempt);
  }
  if (best.limbs == 0)
    return Refused("skeletons: " + best.fault + " (" + counts + "); a landmark on each end of a limb would help other starts");
  SkeletonStart start;
  start.points = best.points;
  start.branches = best.limbs;
  start.ambiguous = second < kUnsure * best.Score() + 0.002;
  start.words = "skeletons: matched " + std::to_string(start.branches) + " limbs (" + counts + "); vertices are " + Percent(best.misfit) +
                " of the diagonal off the target's surface";
  if (!marks.empty()) start.words += ", landmarks " + Percent(best.residual);
  if (start.ambiguous) start.words += "; another matching fits nearly as well: a landmark on the end of a limb would settle it";
  return start;
}

}  // namespace

SkeletonStart StartFromSkeletons(const Mesh& source, const Mesh& target, const std::vector<LandmarkGoal>& landmarks,
                                 const Similarity3& target_from_source, const SkeletonOptions& options) {
  const double before = CpuSeconds();
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  std::vector<Mark> marks;
  for (const LandmarkGoal& goal : landmarks) marks.emplace_back(PositionOf(goal.source, source.points), goal.target);
  SkeletonStart start;
  Body from(source, options.proxy_faces);
  if (!from.skeleton.fault.empty()) {
    start = Refused("skeletons: the source " + from.skeleton.fault);
  } else {
    Body to(target, options.proxy_faces);
    start = to.skeleton.fault.empty() ? MatchBodies(from, to, marks, target_from_source, options)
                                      : Refused("skeletons: the target " + to.skeleton.fault);
  }
  if (start.usable()) start.points = MoveLoosePartsWithHost(source, from.loose, start.points);
  start.seconds = CpuSeconds() - before;
  return start;
}

}  // namespace keypose::registration
