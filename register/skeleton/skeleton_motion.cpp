#include "register/skeleton/skeleton_motion.h"

#include <cmath>
#include <cstdint>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kAxisSamples = LimbAxis::kSamples;
constexpr int kSpokes = 6;  // chords of a cross-section

// Measured on tentacles bent by 60 to 450 degrees and on real pairs (docs/algorithms/register.md);
// no record of single values. Sensitivity: docs/results/sensitivity.md.
struct LimbAxisTuning {
  KEYPOSE_TUNED(int, kSmoothing, 6);      // rounds of smoothing of a limb's samples
  KEYPOSE_TUNED(int, kCentering, 3);      // rounds of centring
  KEYPOSE_TUNED(double, kChordReach, 3);  // of the limb's radius: longer chords are of other limbs
  KEYPOSE_TUNED(double, kCenterStep, 0.8);   // share of the way to the centre that is made
  KEYPOSE_TUNED(double, kOutsideBall, 0.8);  // of the joint's radius: thicker nodes are in its ball
  // of the tip's radius, and of the limb's length: longest way from the tip to the surface
  KEYPOSE_TUNED(double, kTipRadii, 4);
  KEYPOSE_TUNED(double, kTipLength, 0.1);
};

// On the same data; no record of single values.
struct SkeletonMotionTuning {
  // weights of rotations and directions; the direction of a limb has 1
  KEYPOSE_TUNED(double, kPrior, 0.1);       // of the prior rotation at the root
  KEYPOSE_TUNED(double, kChildPrior, 3);    // at other joints, over that at the root
  KEYPOSE_TUNED(double, kMarkWeight, 0.7);  // of the direction to a landmark
  // of the joint's radius
  KEYPOSE_TUNED(double, kDirection, 1.6);   // from the joint: where a limb's direction is taken
  KEYPOSE_TUNED(double, kSourceNear, 1.5);  // landmarks nearer turn the joint
  KEYPOSE_TUNED(double, kTargetNear, 2);    // the same on the target
  // of the limb's length
  KEYPOSE_TUNED(double, kMostQuiet, 0.4);   // longest part without twist
  KEYPOSE_TUNED(double, kMarkReach, 0.12);  // around a landmark's place, where its foot is searched
  KEYPOSE_TUNED(double, kLeastSpan, 0.08);  // between landmarks that stretch the limb
  KEYPOSE_TUNED(double, kMostBlurred, 0.2);  // largest spread of the mean over motions
  KEYPOSE_TUNED(double, kSkinReach, 0.05);   // around a vertex' place, where its foot is searched
  // of the twisted part: landmarks nearer to its start tell nothing
  KEYPOSE_TUNED(double, kLeastTwisted, 0.05);
  // ratios of lengths between landmarks; others are wrong
  KEYPOSE_TUNED(double, kLeastStretch, 0.4);
  KEYPOSE_TUNED(double, kMostStretch, 2.5);
  // of the radius: landmarks nearer to the axis tell no twist
  KEYPOSE_TUNED(double, kOffAxis, 0.6);
  KEYPOSE_TUNED(double, kNoTwist, 0.02);  // weight of no twist; a landmark at the limb's end has 1
  // of the distance to the axis: spread of the mean over motions
  KEYPOSE_TUNED(double, kBlur, 0.5);
};

PointsX3 Resampled(const std::vector<Vector3d>& line, double& length) {
  std::vector<double> arc(line.size(), 0);
  for (std::size_t k = 1; k < line.size(); ++k)
    arc[k] = arc[k - 1] + (line[k] - line[k - 1]).norm();
  length = arc.back();
  PointsX3 points(kAxisSamples + 1, 3);
  std::size_t k = 1;
  for (int i = 0; i <= kAxisSamples; ++i) {
    const double at = length * i / kAxisSamples;
    while (k + 1 < line.size() && arc[k] < at) ++k;
    const double span = arc[k] - arc[k - 1];
    const double x = span > 0 ? std::clamp((at - arc[k - 1]) / span, 0.0, 1.0) : 0;
    points.row(i) = (line[k - 1] + x * (line[k] - line[k - 1])).transpose();
  }
  return points;
}

void Smooth(PointsX3& points) {
  for (int round = 0; round < LimbAxisTuning::kSmoothing; ++round) {
    const PointsX3 before = points;
    for (int i = 1; i < kAxisSamples; ++i)
      points.row(i) = (before.row(i - 1) + 2 * before.row(i) + before.row(i + 1)) / 4;
  }
}

/// Moves the samples of a limb to the middle of its cross-sections. In bends, the contraction ends
/// too near to the inner side.
/// @param first  samples before this one are inside a joint and do not move
/// @param thick  approximate radius of the limb
void Center(const RayScene& surface, int first, double thick, PointsX3& points) {
  for (int round = 0; round < LimbAxisTuning::kCentering; ++round) {
    PointsX3 moved = points;
    for (int i = std::max(1, first); i < kAxisSamples; ++i) {
      const Vector3d p = points.row(i),
                     tangent = (points.row(i + 1) - points.row(i - 1)).normalized();
      const Vector3d u = tangent.unitOrthogonal(), v = tangent.cross(u);
      const double reach = LimbAxisTuning::kChordReach *
                           std::max(thick, std::sqrt(surface.ClosestPoint(p).squared_distance));
      Vector3d shift = Vector3d::Zero();
      int used = 0;
      for (int k = 0; k < kSpokes; ++k) {
        const Vector3d way = std::cos(M_PI * k / kSpokes) * u + std::sin(M_PI * k / kSpokes) * v;
        const RayScene::Hit there = surface.Cast(p, way), back = surface.Cast(p, -way);
        if (there.face < 0 || back.face < 0 || there.distance > reach || back.distance > reach)
          continue;
        shift += (there.distance - back.distance) / 2 * way;
        ++used;
      }
      // In a round cross-section the middles of the chords are on average half way to the centre,
      // hence the factor of 2.
      if (2 * used > kSpokes)
        moved.row(i) += (2.0 / used * shift).transpose() * LimbAxisTuning::kCenterStep;
    }
    points = moved;
    Smooth(points);
  }
}

LimbAxis MakeAxis(const LimbedBody& body, const Limb& limb, bool backwards, bool to_tip) {
  std::vector<Vector3d> line;
  for (int n : limb.nodes) line.emplace_back(body.tree->nodes().row(n));
  if (backwards) std::reverse(line.begin(), line.end());
  LimbAxis axis;
  axis.points = Resampled(line, axis.length);
  Smooth(axis.points);
  const double ball = body.tree->joints()[backwards ? limb.to : limb.from].radius;
  // Where the line is too near to a wall, its distance to the surface is too small. So the radius
  // comes from the thicker places of the limb.
  std::vector<double> radii;
  for (int n : limb.nodes)
    if (body.tree->radius()[n] < LimbAxisTuning::kOutsideBall * ball || limb.nodes.size() < 8)
      radii.push_back(body.tree->radius()[n]);
  const double thick = QuantileAbove(std::move(radii), 0.8);
  Center(body.scene, static_cast<int>(kAxisSamples * ball / std::max(axis.length, 1e-300)), thick,
         axis.points);
  line.clear();
  for (int i = 0; i <= kAxisSamples; ++i) line.emplace_back(axis.points.row(i));
  if (to_tip) {
    // The contraction stops before the surface, at a different distance in each pose. So the limb
    // is extended to the surface.
    const double radius = body.tree->radius()[backwards ? limb.nodes.front() : limb.nodes.back()];
    const Vector3d tangent = (line[kAxisSamples] - line[kAxisSamples - 5]).normalized();
    const RayScene::Hit hit = body.scene.Cast(line.back(), tangent);
    if (hit.face >= 0 && hit.distance < LimbAxisTuning::kTipRadii * radius +
                                            LimbAxisTuning::kTipLength * axis.length)
      line.push_back(line.back() + hit.distance * tangent);
  }
  axis.points = Resampled(line, axis.length);
  return axis;
}

Matrix3d LeastTurn(const Vector3d& from, const Vector3d& to) {
  return Eigen::Quaterniond::FromTwoVectors(from, to).toRotationMatrix();
}

/// The rotation that best maps the first directions to the second, with a prior rotation.
Matrix3d FitTurn(const std::vector<std::pair<Vector3d, Vector3d>>& directions,
                 const std::vector<double>& weights, const Matrix3d& prior, double prior_weight) {
  Matrix3d sum = prior_weight * prior;
  for (std::size_t i = 0; i < directions.size(); ++i)
    sum += weights[i] * directions[i].second * directions[i].first.transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d sign = Matrix3d::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

/// Rotation minimising frames along a line.
/// Source: Wang et al., Computation of Rotation Minimizing Frames, 2008 (double reflection).
std::vector<Matrix3d> Frames(const std::vector<Vector3d>& points,
                             const std::vector<Vector3d>& tangents, const Matrix3d& first) {
  std::vector<Matrix3d> frames{first};
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const Vector3d v1 = points[i + 1] - points[i];
    const double c1 = v1.squaredNorm();
    Matrix3d next = frames.back();
    if (c1 > 0) {
      const auto reflect = [](const Vector3d& x, const Vector3d& v, double c) {
        return (x - 2 / c * v.dot(x) * v).eval();
      };
      const Vector3d r = reflect(frames.back().col(1), v1, c1),
                     t = reflect(frames.back().col(0), v1, c1);
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

}  // namespace

SkeletonMotion::SkeletonMotion(const LimbedBody& source, const LimbedBody& target,
                               const TipMatch& match, const std::vector<MarkPair>& landmarks,
                               const Similarity3& coarse, double scale)
    : source_(source),
      target_(target),
      coarse_(coarse),
      scale_(scale),
      joints_(source.tree->joints().size()),
      marks_(landmarks) {
  PairJoints(match);
  int root = 0;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const Joint& joint = source.tree->joints()[j];
    // The root is the thickest fork, or the thick end of the only limb.
    const auto rank = [](const Joint& a) { return std::pair(!a.tip(), a.radius); };
    if (rank(joint) > rank(source.tree->joints()[root])) root = static_cast<int>(j);
  }
  Walk(root);
}

void SkeletonMotion::PairJoints(const TipMatch& match) {
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

/// Adds the limb pairs beyond a joint, in order from the root.
void SkeletonMotion::AddLimbs(int joint, int came_by) {
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
    pair.target = MakeAxis(target_, t.limbs()[limb_match_[l][0]],
                           pair.backwards != (limb_match_[l][1] == 1), tip);
    pair.quiet = std::min(SkeletonMotionTuning::kMostQuiet,
                          s.joints()[joint].radius / std::max(pair.source.length, 1e-300));
    PlaceMarks(pair);
    pair_of_limb_[l] = SizeOf(pairs_);
    pairs_.push_back(std::move(pair));
    AddLimbs(pairs_.back().to, l);
  }
}

/// Finds the landmarks on this limb. Those that imply a moderate stretch become knots of the map
/// between arc lengths.
void SkeletonMotion::PlaceMarks(LimbPair& pair) {
  for (const auto& [from, to] : marks_) {
    const NodePlace place = source_.tree->PlaceOf(source_.NodeOf(from)),
                    other = target_.tree->PlaceOf(target_.NodeOf(to));
    const bool at_tip = place.joint >= 0 && place.joint == pair.to;
    if (place.limb != pair.source_limb && !at_tip) continue;
    const bool other_at_tip = other.joint >= 0 && other.joint == target_joint_[pair.to];
    if (other.limb != limb_match_[pair.source_limb][0] && !other_at_tip) continue;
    const double length = source_.tree->limbs()[pair.source_limb].length,
                 other_length = target_.tree->limbs()[limb_match_[pair.source_limb][0]].length;
    const auto guess = [](const NodePlace& p, double whole, bool backwards, bool tip) {
      if (tip) return 1.0;
      return backwards ? 1 - p.arc / whole : p.arc / whole;
    };
    const double s = guess(place, length, pair.backwards, at_tip);
    const double t = guess(other, other_length,
                           pair.backwards != (limb_match_[pair.source_limb][1] == 1), other_at_tip);
    pair.marks.push_back(
        {pair.source.Project(from, std::max(0.0, s - SkeletonMotionTuning::kMarkReach),
                             std::min(1.0, s + SkeletonMotionTuning::kMarkReach)),
         pair.target.Project(to, std::max(0.0, t - SkeletonMotionTuning::kMarkReach),
                             std::min(1.0, t + SkeletonMotionTuning::kMarkReach)),
         from, to});
  }
  std::sort(pair.marks.begin(), pair.marks.end(),
            [](const LimbMark& a, const LimbMark& b) { return a.source_share < b.source_share; });
  pair.knots = {{0, 0}};
  for (const LimbMark& m : pair.marks) {
    const double ds = m.source_share - pair.knots.back().first,
                 dt = m.target_share - pair.knots.back().second;
    const double rest_s = 1 - m.source_share, rest_t = 1 - m.target_share;
    const auto orderly = [](double a, double b) {
      return a > SkeletonMotionTuning::kLeastSpan && b > SkeletonMotionTuning::kLeastStretch * a &&
             b < SkeletonMotionTuning::kMostStretch * a;
    };
    if (orderly(ds, dt) && orderly(rest_s, rest_t))
      pair.knots.emplace_back(m.source_share, m.target_share);
  }
  pair.knots.emplace_back(1, 1);
}

void SkeletonMotion::TurnJoint(int joint, int came_by, const Matrix3d& prior, double prior_weight) {
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
    const double reach = std::min(
        0.5, SkeletonMotionTuning::kDirection * m.radius / std::max(pair.source.length, 1e-300));
    const double share = l != came_by ? reach : 1 - reach;
    directions.emplace_back((pair.source.At(share) - m.source).normalized(),
                            (pair.target.At(pair.TargetShare(share)) - m.target).normalized());
    weights.push_back(1);
  }
  for (const auto& [from, to] : marks_) {
    const NodePlace place = source_.tree->PlaceOf(source_.NodeOf(from));
    const bool near =
        (from - m.source).norm() < SkeletonMotionTuning::kSourceNear * m.radius &&
        (to - m.target).norm() < SkeletonMotionTuning::kTargetNear * scale_ * m.radius;
    if (place.joint != joint && !near) continue;
    directions.emplace_back((from - m.source) / m.radius, (to - m.target) / (scale_ * m.radius));
    weights.push_back(SkeletonMotionTuning::kMarkWeight);
  }
  m.turn = FitTurn(directions, weights, prior, prior_weight);
  m.known = true;
}

/// Adds the twist about the axis that landmarks off the axis imply. It is zero at the root of the
/// limb and grows linearly.
void SkeletonMotion::Twist(LimbPair& pair, const std::vector<Vector3d>& tangents) {
  double sum_uu = SkeletonMotionTuning::kNoTwist, sum_ua = 0, radius = 0;
  const std::vector<int>& run = source_.tree->limbs()[pair.source_limb].nodes;
  for (int n : run) radius += source_.tree->radius()[n] / static_cast<double>(run.size());
  for (const LimbMark& m : pair.marks) {
    const double u = (m.source_share - pair.quiet) / (1 - pair.quiet);
    if (u <= SkeletonMotionTuning::kLeastTwisted) continue;
    const int k = static_cast<int>(std::lround(m.source_share * kAxisSamples));
    const Vector3d t = tangents[k];
    const Vector3d place = pair.source.At(m.source_share);
    Vector3d a = pair.turns[k] * (m.source - place), b = m.target - pair.target.At(m.target_share);
    a -= a.dot(t) * t;
    b -= b.dot(t) * t;
    if (a.norm() < SkeletonMotionTuning::kOffAxis * radius ||
        b.norm() < SkeletonMotionTuning::kOffAxis * scale_ * radius)
      continue;
    const double angle = std::atan2(t.dot(a.cross(b)), a.dot(b));
    sum_uu += u * u;
    sum_ua += u * angle;
  }
  for (int k = 0; k <= kAxisSamples; ++k) {
    const double u =
        std::max(0.0, (static_cast<double>(k) / kAxisSamples - pair.quiet) / (1 - pair.quiet));
    pair.turns[k] =
        Eigen::AngleAxisd(u * sum_ua / sum_uu, tangents[k]).toRotationMatrix() * pair.turns[k];
  }
}

void SkeletonMotion::TurnLimb(LimbPair& pair) {
  std::vector<Vector3d> sp, st, tp, tt;
  for (int k = 0; k <= kAxisSamples; ++k) {
    const double s = static_cast<double>(k) / kAxisSamples, t = pair.TargetShare(s);
    sp.push_back(pair.source.At(s));
    st.push_back(pair.source.Tangent(s));
    tp.push_back(pair.target.At(t));
    tt.push_back(pair.target.Tangent(t));
  }
  // Inside the joint's ball the line is not reliable, so the frames start where it leaves the ball.
  const int start =
      std::min(kAxisSamples - 4, static_cast<int>(std::lround(pair.quiet * kAxisSamples)));
  const Matrix3d& joint = joints_[pair.from].turn;
  const auto from = [&](std::vector<Vector3d>& v) {
    return std::vector<Vector3d>(v.begin() + start, v.end());
  };
  Matrix3d first;
  first.col(0) = st[start];
  first.col(1) = st[start].unitOrthogonal();
  first.col(2) = first.col(0).cross(first.col(1));
  const Matrix3d first_turn = LeastTurn(joint * st[start], tt[start]) * joint;
  const std::vector<Matrix3d> source_frames = Frames(from(sp), from(st), first),
                              target_frames = Frames(from(tp), from(tt), first_turn * first);
  pair.turns.assign(kAxisSamples + 1, joint);
  for (int k = start; k <= kAxisSamples; ++k)
    pair.turns[k] = target_frames[k - start] * source_frames[k - start].transpose();
  const Eigen::Quaterniond q0(joint), q1(first_turn);
  for (int k = 0; k < start; ++k)
    pair.turns[k] = q0.slerp(static_cast<double>(k) / start, q1).toRotationMatrix();
  Twist(pair, tt);
}

void SkeletonMotion::Walk(int root) {
  pair_of_limb_.assign(source_.tree->limbs().size(), -1);
  AddLimbs(root, -1);
  TurnJoint(root, -1, coarse_.rotation, SkeletonMotionTuning::kPrior);
  // Parents come before their children.
  for (LimbPair& pair : pairs_) {
    TurnLimb(pair);
    if (!source_.tree->joints()[pair.to].tip())
      TurnJoint(pair.to, pair.source_limb, pair.turns.back(),
                SkeletonMotionTuning::kChildPrior * SkeletonMotionTuning::kPrior);
  }
}

/// The motion of point x at a share of a limb, averaged over a length about the limb's thickness.
Vector3d SkeletonMotion::Moved(const LimbPair& pair, double share, const Vector3d& x) const {
  const double reach = std::clamp(SkeletonMotionTuning::kBlur * (x - pair.source.At(share)).norm() /
                                      std::max(pair.source.length, 1e-300),
                                  0.5 / kAxisSamples, SkeletonMotionTuning::kMostBlurred);
  const int low = std::max(0, static_cast<int>(std::floor((share - 2 * reach) * kAxisSamples)));
  const int high =
      std::min(kAxisSamples, static_cast<int>(std::ceil((share + 2 * reach) * kAxisSamples)));
  Vector3d sum = Vector3d::Zero();
  double total = 0;
  for (int k = low; k <= high; ++k) {
    const double s = static_cast<double>(k) / kAxisSamples, d = (s - share) / reach;
    const double w = std::exp(-0.5 * d * d);
    sum += w * (pair.target.At(pair.TargetShare(s)) +
                scale_ * (pair.turns[k] * (x - pair.source.At(s))));
    total += w;
  }
  return sum / total;
}

PointsX3 SkeletonMotion::Apply(const PointsX3& points) const {
  const SkeletonTree& tree = *source_.tree;
  std::vector<NodePlace> places;
  for (Eigen::Index n = 0; n < tree.nodes().rows(); ++n)
    places.push_back(tree.PlaceOf(static_cast<int>(n)));
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
      const auto rigid = [&](const JointMotion& joint) {
        return (joint.target + scale_ * (joint.turn * (x - joint.source))).eval();
      };
      if (!pair) {
        moved.row(v) = rigid(joints_[place.joint]);
        continue;
      }
      const double thick =
          (x - pair->source.At(share)).norm() / std::max(pair->source.length, 1e-300);
      share =
          pair->source.Project(x, std::max(0.0, share - SkeletonMotionTuning::kSkinReach - thick),
                               std::min(1.0, share + SkeletonMotionTuning::kSkinReach + thick));
      Vector3d p = Moved(*pair, share, x);
      // Inside a joint's ball, blend from the motion of the limb to that of the joint.
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

}  // namespace keypose::registration
