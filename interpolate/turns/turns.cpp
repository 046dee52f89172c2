#include "interpolate/turns/turns.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::interpolation {

namespace {

// Chosen on bends and twists with known answers and on real keys (docs/results/interpolation.md,
// docs/algorithms/interpolate.md); sensitivity: docs/results/sensitivity.md.
struct TurnsTuning {
  // rad: smaller smooth turns fade out, their axis is noise
  KEYPOSE_TUNED(double, kSmallTurn, 0.1);
  KEYPOSE_TUNED(int, kSmoothingPasses, 3);         // over the screening length each
  KEYPOSE_TUNED(double, kLargestRemainder, 1.5);   // rad: a face with more is far from its turn
  KEYPOSE_TUNED(double, kTear, 0.5);               // rad: beyond the difference of two rotations
  KEYPOSE_TUNED(double, kFewFaces, 0.005);         // share of far faces that turns may have
  KEYPOSE_TUNED(double, kFewEdges, 0.01);          // share of torn edges that turns may have
  KEYPOSE_TUNED(double, kEnoughSupport, 0.45);     // of the largest support, for a root
  KEYPOSE_TUNED(double, kBodySine2, 0.0302);       // sin^2 of half of 20 degrees: the same body
  KEYPOSE_TUNED(double, kClusterSine2, 0.0076);    // of half of 10 degrees: the same rigid cluster
  KEYPOSE_TUNED(double, kHalfTurnSine2, 0.99931);  // of half of 177 degrees: either way round
  KEYPOSE_TUNED(double, kLimbArea, 0.002);         // share of the area: less is a fold, not a limb
};

constexpr double kWholeTurn = 6.283185307179586;
constexpr double kAxisless = 1e-6;  // rotations below this have no usable axis
constexpr std::size_t kMostHalfTurns = 4;
constexpr int kCandidates = 32, kSamples = 512;
constexpr int kBuckets = 160;
constexpr double kLeastWeight = 1e-3;

/// Index of the quarter octave of the difference; all below 2^-30 share one bucket.
int BucketOf(double sine2) {
  const auto bits =
      static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(std::max(sine2, 0x1p-30)) >> 50);
  const auto lowest = static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(0x1p-30) >> 50);
  return static_cast<int>(std::min<std::int64_t>(bits - lowest, kBuckets - 1));
}

Eigen::Matrix3d NearestRotation(const Eigen::Matrix3d& m) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d flip = Eigen::Matrix3d::Identity();
  flip(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * flip * svd.matrixV().transpose();
}

/// Angle of a rotation about a unit axis (its twist), in the winding nearest to `near`.
double TwistNear(const Eigen::Quaterniond& q, const Eigen::Vector3d& axis, double near) {
  const double twist = 2 * std::atan2(q.vec().dot(axis), q.w());
  return twist + kWholeTurn * std::round((near - twist) / kWholeTurn);
}

class TurnLift {
 public:
  TurnLift(const PoissonSystem& system, SegmentMaps& maps)
      : system_(system),
        maps_(maps),
        neighbours_(FaceNeighbours(system.vertex_count(), system.faces())) {
    FacesByPart();
    relative_.resize(maps_.faces.size());
    ParallelFor(
        std::ssize(relative_),
        [&](std::int64_t f) {
          relative_[f] = Eigen::Quaterniond(maps_.faces[f].rotation).normalized();
        },
        1024);
    const int body = FindBody();
    const Eigen::Quaterniond back = body_.conjugate();
    for (Eigen::Quaterniond& q : relative_) q = back * q;
    maps_.body_turn = LogOf(body_);
    std::vector<int> roots;
    for (std::size_t part = 0; part < faces_of_part_.size(); ++part)
      if (!faces_of_part_[part].empty())
        roots.push_back(static_cast<int>(part) == body ? body_root_
                                                       : RootOf(faces_of_part_[part], relative_));
    TakeTurns(roots);
  }

  void Override(const TurnOverride& limb, bool axis_in_second_key) {
    const std::vector<int> faces = FacesOf(limb);
    Eigen::Vector3d axis =
        axis_in_second_key ? (-(body_.conjugate() * limb.axis)).eval() : limb.axis;
    if (axis.norm() == 0)
      for (int f : faces) axis += system_.face_areas()[f] * maps_.faces[f].turn;
    double area = 0;
    for (int f : faces) area += system_.face_areas()[f];
    if (!axis.allFinite() || axis.norm() <= 1e-3 * (limb.axis.norm() == 0 ? area : 0.0))
      throw InputError("interpolate: turns of '" + limb.name +
                       "' need an axis; the limb itself does not turn between these keys");
    axis.normalize();
    for (int f : faces) {
      Eigen::Vector3d& turn = maps_.faces[f].turn;
      const double angle = turn.norm();
      const Eigen::Vector3d own =
          angle > Tuning::kSmallTurn ? (turn.dot(axis) < 0 ? -turn : turn).eval() / angle : axis;
      turn += kWholeTurn * limb.extra_turns * own;
    }
  }

  /// Splits each face's rotation into a turn about a smooth axis and a remainder across it.
  void Smooth() {
    // Near whole turns the direction of a rotation vector amplifies noise by x / sin x, where x is
    // half its length. The weight is the inverse square of that.
    Eigen::MatrixXd weighted(maps_.faces.size(), 4);
    ParallelFor(
        weighted.rows(),
        [&](std::int64_t f) {
          const Eigen::Vector3d& turn = maps_.faces[f].turn;
          const double half = 0.5 * turn.norm(),
                       magnified = half > kAxisless ? std::sin(half) / half : 1.0;
          const double weight = std::max(kLeastWeight, magnified * magnified);
          weighted.row(f) << weight * turn.transpose(), weight;
        },
        1024);
    const Eigen::MatrixXd smooth = system_.SmoothOverVertices(weighted, Tuning::kSmoothingPasses);
    maps_.vertex_turns.resize(smooth.rows(), 3);
    for (Eigen::Index i = 0; i < smooth.rows(); ++i)
      maps_.vertex_turns.row(i) = smooth.row(i).head<3>() / std::max(smooth(i, 3), kLeastWeight);
    const FacesX3& faces = system_.faces();
    ParallelFor(
        weighted.rows(),
        [&](std::int64_t f) {
          FaceMap& map = maps_.faces[f];
          if (map.degenerate) return;
          const PointsX3& turns = maps_.vertex_turns;
          const Eigen::Vector3d mean =
              (turns.row(faces(f, 0)) + turns.row(faces(f, 1)) + turns.row(faces(f, 2)))
                  .transpose() /
              3;
          const double length = mean.norm();
          if (length < kAxisless) return SetTurn(map, f, Eigen::Vector3d::Zero());
          const Eigen::Vector3d axis = mean / length;
          const double twist = TwistNear(relative_[f], axis, map.turn.dot(axis));
          SetTurn(map, f, twist * std::min(1.0, length / Tuning::kSmallTurn) * axis);
        },
        256);
  }

  void KeepRaw() {
    ParallelFor(
        std::ssize(maps_.faces),
        [&](std::int64_t f) { SetTurn(maps_.faces[f], f, maps_.faces[f].turn); }, 512);
  }

  /// Whether turns and remainders are usable: single faces, such as folded ones, may tear, but not
  /// regions.
  bool Holds(const TurnReport& report) const {
    const double faces = static_cast<double>(maps_.faces.size());
    return report.far_faces <= Tuning::kFewFaces * faces &&
           report.torn_edges <= Tuning::kFewEdges * 1.5 * faces;
  }

  std::vector<Eigen::Vector3d> Turns() const {
    std::vector<Eigen::Vector3d> turns;
    for (const FaceMap& map : maps_.faces) turns.push_back(map.turn);
    return turns;
  }
  void Restore(const std::vector<Eigen::Vector3d>& turns) {
    for (std::size_t f = 0; f < turns.size(); ++f) maps_.faces[f].turn = turns[f];
  }

  TurnReport Report() const {
    TurnReport report;
    report.half_turns = half_turns_;
    for (const FaceMap& map : maps_.faces) {
      if (map.degenerate) continue;
      report.largest_turn = std::max(report.largest_turn, map.turn.norm());
      report.largest_remainder = std::max(report.largest_remainder, map.remainder.norm());
      report.far_faces += map.remainder.norm() > Tuning::kLargestRemainder;
    }
    std::vector<Eigen::Quaterniond> middle(maps_.faces.size());
    ParallelFor(
        std::ssize(middle),
        [&](std::int64_t f) {
          middle[f] = QuaternionOf(0.5 * maps_.faces[f].turn) *
                      QuaternionOf(0.5 * maps_.faces[f].remainder);
        },
        512);
    for (int f = 0; f < std::ssize(neighbours_); ++f)
      for (int g : neighbours_[f]) {
        if (g <= f || maps_.faces[f].degenerate || maps_.faces[g].degenerate) continue;
        const double half = RotationDifference(middle[f], middle[g]);
        if (half < 0.04) continue;  // under 0.4 rad: no tear, whatever the rotations at the ends
        const double whole = AngleOfDifference(RotationDifference(relative_[f], relative_[g]));
        if (AngleOfDifference(half) <= whole + Tuning::kTear) continue;
        ++report.torn_edges;
        report.loops_that_do_not_close += whole < Tuning::kTear;
      }
    return report;
  }

 private:
  using Tuning = TurnsTuning;

  void FacesByPart() {
    faces_of_part_.resize(system_.part_count());
    for (Eigen::Index f = 0; f < system_.faces().rows(); ++f)
      if (!maps_.faces[f].degenerate)
        faces_of_part_[system_.parts()[system_.faces()(f, 0)]].push_back(static_cast<int>(f));
  }

  /// Area of sampled faces whose rotation is within 20 degrees of `rotation`.
  double Support(const std::vector<int>& faces, const Eigen::Quaterniond& rotation,
                 const std::vector<Eigen::Quaterniond>& rotations) const {
    const std::size_t stride = std::max<std::size_t>(1, faces.size() / kSamples);
    double area = 0;
    for (std::size_t k = stride / 2; k < faces.size(); k += stride)
      if (RotationDifference(rotations[faces[k]], rotation) < Tuning::kBodySine2)
        area += system_.face_areas()[faces[k]];
    return area;
  }

  /// The face that turns least among those whose rotation many others share: the trunk, or the
  /// fixed end of a limb.
  int RootOf(const std::vector<int>& faces,
             const std::vector<Eigen::Quaterniond>& rotations) const {
    const Eigen::Quaterniond still = Eigen::Quaterniond::Identity();
    std::vector<int> candidates;
    const std::size_t stride = std::max<std::size_t>(1, faces.size() / kCandidates);
    for (std::size_t k = stride / 2; k < faces.size(); k += stride) candidates.push_back(faces[k]);
    candidates.push_back(*std::min_element(faces.begin(), faces.end(), [&](int a, int b) {
      return RotationDifference(rotations[a], still) < RotationDifference(rotations[b], still);
    }));
    std::vector<double> support;
    for (int f : candidates) support.push_back(Support(faces, rotations[f], rotations));
    const double enough =
        Tuning::kEnoughSupport * *std::max_element(support.begin(), support.end());
    int root = -1;
    for (std::size_t k = 0; k < candidates.size(); ++k)
      if (support[k] >= enough && (root < 0 || RotationDifference(rotations[candidates[k]], still) <
                                                   RotationDifference(rotations[root], still)))
        root = candidates[k];
    return root;
  }

  /// The part of largest area. Its root, and the mean rotation around the root, become the body's.
  int FindBody() {
    std::vector<double> area(faces_of_part_.size(), 0);
    for (std::size_t p = 0; p < area.size(); ++p)
      for (int f : faces_of_part_[p]) area[p] += system_.face_areas()[f];
    const int body = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());
    if (faces_of_part_[body].empty()) return body;
    body_root_ = RootOf(faces_of_part_[body], relative_);
    body_ = relative_[body_root_];
    for (int pass = 0; pass < 3; ++pass) {
      Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
      for (int f : faces_of_part_[body])
        if (RotationDifference(relative_[f], body_) < Tuning::kBodySine2)
          sum += system_.face_areas()[f] * maps_.faces[f].rotation;
      body_ = NearestRotation(sum);
    }
    return body;
  }

  /// Sets each face's turn from its parent's.
  void TakeTurns(const std::vector<int>& roots) {
    std::vector<char> loose;
    for (const FaceMap& map : maps_.faces) loose.push_back(map.degenerate);
    const FaceTree tree = GrowTree(neighbours_, relative_, loose, roots);
    FindHalfTurns(tree, loose);
    for (const auto& [face, parent] : tree.steps) {
      Eigen::Vector3d& turn = maps_.faces[face].turn;
      if (loose[face]) {
        relative_[face] = relative_[parent];
        turn = maps_.faces[parent].turn;
      } else
        turn = face == parent
                   ? LogOf(relative_[face])
                   : TurnAfter(maps_.faces[parent].turn, relative_[parent], relative_[face]);
    }
  }

  /// Collects the faces beyond each step of half a turn, if they are a limb and not a fold.
  void FindHalfTurns(const FaceTree& tree, const std::vector<char>& loose) {
    std::vector<int> limb_of(maps_.faces.size(), -1);
    std::vector<std::vector<int>> limbs;
    for (const auto& [face, parent] : tree.steps) {
      if (face == parent) continue;
      const bool half =
          !loose[face] && !loose[parent] &&
          RotationDifference(relative_[parent], relative_[face]) > Tuning::kHalfTurnSine2;
      if (half) limbs.emplace_back();
      limb_of[face] = half ? SizeOf(limbs) - 1 : limb_of[parent];
      if (limb_of[face] >= 0) limbs[limb_of[face]].push_back(face);
    }
    for (const std::vector<int>& limb : limbs) {
      double area = 0;
      for (int f : limb) area += system_.face_areas()[f];
      if (area > Tuning::kLimbArea * system_.face_areas().sum() &&
          half_turns_.size() < kMostHalfTurns)
        half_turns_.push_back(limb);
    }
  }

  void SetTurn(FaceMap& map, std::size_t face, const Eigen::Vector3d& turn) const {
    map.turn = turn;
    map.remainder = map.degenerate ? Eigen::Vector3d::Zero().eval()
                                   : LogOf(QuaternionOf(-turn) * relative_[face]);
  }

  std::vector<int> FacesOf(const TurnOverride& limb) const {
    const int count = SizeOf(maps_.faces);
    if (limb.faces.empty())
      throw InputError("interpolate: turns of '" + limb.name + "' name no face");
    for (int f : limb.faces)
      if (f < 0 || f >= count)
        throw InputError("interpolate: turns of '" + limb.name + "' name face " +
                         std::to_string(f) + ", but the keys have " + std::to_string(count));
    if (limb.faces.size() > 1) return limb.faces;
    std::vector<int> cluster = limb.faces;
    std::vector<char> in(count, 0);
    in[cluster[0]] = 1;
    for (std::size_t at = 0; at < cluster.size(); ++at)
      for (int next : neighbours_[cluster[at]])
        if (next >= 0 && !in[next] &&
            RotationDifference(relative_[cluster[at]], relative_[next]) < Tuning::kClusterSine2) {
          in[next] = 1;
          cluster.push_back(next);
        }
    return cluster;
  }

  const PoissonSystem& system_;
  SegmentMaps& maps_;
  std::vector<std::array<int, 3>> neighbours_;
  std::vector<std::vector<int>> faces_of_part_;
  Eigen::Quaterniond body_ = Eigen::Quaterniond::Identity();
  int body_root_ = -1;
  std::vector<Eigen::Quaterniond> relative_;  // to the body
  std::vector<std::vector<int>> half_turns_;
};

}  // namespace

FaceTree GrowTree(const std::vector<std::array<int, 3>>& neighbours,
                  const std::vector<Eigen::Quaterniond>& rotations, const std::vector<char>& loose,
                  const std::vector<int>& first_roots) {
  const int count = SizeOf(rotations);
  FaceTree tree;
  tree.steps.reserve(count);
  std::vector<char> done(count, 0);
  // Prim's algorithm with buckets of quarter octaves in place of a heap: the order matters only at
  // large differences.
  std::vector<std::vector<FaceTree::Step>> open(kBuckets);
  int lowest = 0;
  const auto visit = [&](const FaceTree::Step& step) {
    if (done[step.face]) return;
    done[step.face] = 1;
    tree.steps.push_back(step);
    for (int next : neighbours[step.face]) {
      if (next < 0 || done[next]) continue;
      const int bucket = loose[next] || loose[step.face]
                             ? kBuckets - 1
                             : BucketOf(RotationDifference(rotations[step.face], rotations[next]));
      open[bucket].push_back({next, step.face});
      lowest = std::min(lowest, bucket);
    }
  };
  const auto grow_from = [&](int root) {
    visit({root, root});
    for (;;) {
      while (lowest < kBuckets && open[lowest].empty()) ++lowest;
      if (lowest == kBuckets) return;
      const FaceTree::Step step = open[lowest].back();
      open[lowest].pop_back();
      visit(step);
    }
  };
  for (int root : first_roots) grow_from(root);
  for (int face = 0; face < count; ++face)
    if (!done[face]) grow_from(face);
  return tree;
}

std::vector<std::array<int, 3>> FaceNeighbours(int vertex_count, const FacesX3& faces) {
  struct Side {
    int high, face, side;
  };
  std::vector<int> first(vertex_count + 1, 0);
  const auto low = [&](Eigen::Index f, int k) {
    return std::min(faces(f, k), faces(f, (k + 1) % 3));
  };
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++first[low(f, k) + 1];
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<Side> sides(faces.size());
  std::vector<int> at(first.begin(), first.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      sides[at[low(f, k)]++] = {std::max(faces(f, k), faces(f, (k + 1) % 3)), static_cast<int>(f),
                                k};
  std::vector<std::array<int, 3>> neighbours(faces.rows(), {-1, -1, -1});
  for (int i = 0; i < vertex_count; ++i)
    for (int a = first[i]; a < first[i + 1]; ++a)
      for (int b = a + 1; b < first[i + 1] && neighbours[sides[a].face][sides[a].side] < 0; ++b)
        if (sides[a].high == sides[b].high && sides[a].face != sides[b].face &&
            neighbours[sides[b].face][sides[b].side] < 0) {
          neighbours[sides[a].face][sides[a].side] = sides[b].face;
          neighbours[sides[b].face][sides[b].side] = sides[a].face;
        }
  return neighbours;
}

TurnReport FollowTurns(const PoissonSystem& system, SegmentMaps& maps,
                       const std::vector<TurnOverride>& overrides, bool axes_in_second_key) {
  TurnLift lift(system, maps);
  for (const TurnOverride& limb : overrides) lift.Override(limb, axes_in_second_key);
  const std::vector<Eigen::Vector3d> raw = lift.Turns();
  lift.Smooth();
  TurnReport report = lift.Report();
  if (lift.Holds(report)) return report;
  // Smoothing mixed parts that turn about other axes. The faces' own turns may still be consistent.
  lift.Restore(raw);
  lift.KeepRaw();
  const TurnReport unsmoothed = lift.Report();
  if (lift.Holds(unsmoothed)) return unsmoothed;
  report.differential = maps.differential = overrides.empty();
  if (!overrides.empty()) report = unsmoothed;
  return report;
}

}  // namespace keypose::interpolation
