#include "register/nricp/alignment.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

constexpr int kAlignmentSamples = 500, kCoarseRounds = 15, kFineRounds = 60, kYawStarts = 24;

// Chosen on synthetic shapes and the registration pairs that the tests use
// (nricp_test.cpp, register/pairs_test.cpp); sensitivity: docs/results/sensitivity.md.
struct AlignmentTuning {
  KEYPOSE_TUNED(double, kTrim, 0.8);  // share of the pairs, the closest, that ICP fits
  // factor on the distance that a turned start must reach to be taken instead of the unturned one
  KEYPOSE_TUNED(double, kBetterBy, 0.95);
};

PointsX3 AreaSamples(const Mesh& mesh, std::uint64_t seed) {
  if (SurfaceArea(mesh.points, mesh.faces) > 0)
    return SampleSurface(mesh.points, mesh.faces, kAlignmentSamples, seed).points;
  return mesh.points;
}

std::vector<Eigen::Matrix3d> Starts() {
  std::vector<Eigen::Matrix3d> starts;
  for (int k = 0; k < kYawStarts; ++k)
    starts.push_back(
        Eigen::AngleAxisd(2 * std::numbers::pi * k / kYawStarts, Eigen::Vector3d::UnitZ())
            .toRotationMatrix());
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 3; ++y)
      for (int signs = 0; x != y && signs < 4; ++signs) {
        Eigen::Matrix3d r;
        r.col(0) = (signs & 1 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(x);
        r.col(1) = (signs & 2 ? -1.0 : 1.0) * Eigen::Vector3d::Unit(y);
        r.col(2) = r.col(0).cross(r.col(1));
        starts.push_back(r);
      }
  return starts;
}

double Spread(const PointsX3& p) {
  return std::sqrt((p.rowwise() - p.colwise().mean()).squaredNorm() /
                   static_cast<double>(p.rows()));
}

/// Similarity ICP between two sets of samples, with optional landmarks.
class SimilarityIcp {
 public:
  SimilarityIcp(const PointsX3& a, const PointsX3& b, const PointsX3& a_marks,
                const PointsX3& b_marks)
      : a_(a), b_(b), a_marks_(a_marks), b_marks_(b_marks), b_tree_(b) {}

  /// @return mean squared distance of the matched pairs, plus that of the landmarks
  double Run(Similarity3& b_from_a, int rounds, bool with_scale) const {
    double cost = std::numeric_limits<double>::infinity();
    for (int round = 0; round < rounds; ++round) {
      const double before = cost;
      cost = Round(b_from_a, with_scale);
      if (std::abs(before - cost) <= 1e-9 * cost) break;
    }
    return cost;
  }

 private:
  struct Pair {
    int a, b;
    double squared_distance;
  };

  double Round(Similarity3& b_from_a, bool with_scale) const {
    const PointsX3 moved = Transformed(b_from_a, a_);
    const KdTree a_tree(moved);
    std::vector<Pair> forth, back;
    for (Eigen::Index i = 0; i < moved.rows(); ++i) {
      const auto n = b_tree_.Nearest(moved.row(i));
      forth.push_back({static_cast<int>(i), n.index, n.squared_distance});
    }
    for (Eigen::Index i = 0; i < b_.rows(); ++i) {
      const auto n = a_tree.Nearest(b_.row(i));
      back.push_back({n.index, static_cast<int>(i), n.squared_distance});
    }
    std::vector<Pair> pairs = Closest(forth);
    for (const Pair& p : Closest(back))
      pairs.push_back(p);  // both ways, since one way alone would shrink the source to a point
    const double cost = Cost(b_from_a, pairs);
    b_from_a = Fit(pairs, b_from_a, with_scale);
    return cost;
  }

  static std::vector<Pair> Closest(std::vector<Pair> pairs) {
    std::stable_sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
      return x.squared_distance < y.squared_distance;
    });
    pairs.resize(std::max<std::size_t>(
        3, static_cast<std::size_t>(AlignmentTuning::kTrim * static_cast<double>(pairs.size()))));
    return pairs;
  }

  double Cost(const Similarity3& b_from_a, const std::vector<Pair>& pairs) const {
    double sum = 0;
    for (const Pair& p : pairs) sum += p.squared_distance;
    sum /= static_cast<double>(pairs.size());
    if (a_marks_.rows() > 0)
      sum += (Transformed(b_from_a, a_marks_) - b_marks_).squaredNorm() /
             static_cast<double>(a_marks_.rows());
    return sum;
  }

  Similarity3 Fit(const std::vector<Pair>& pairs, const Similarity3& before,
                  bool with_scale) const {
    const Eigen::Index n = std::ssize(pairs), marks = a_marks_.rows();
    PointsX3 from(n + marks, 3), to(n + marks, 3);
    Eigen::VectorXd weights(n + marks);
    for (Eigen::Index i = 0; i < n; ++i) {
      from.row(i) = a_.row(pairs[i].a);
      to.row(i) = b_.row(pairs[i].b);
      weights[i] = 1;
    }
    from.bottomRows(marks) = a_marks_;
    to.bottomRows(marks) = b_marks_;
    if (marks > 0)
      weights.tail(marks).setConstant(static_cast<double>(n) / static_cast<double>(marks));
    if (with_scale) return FitSimilarity(from, to, weights, true);
    from *= before.scale;
    Similarity3 rigid = FitSimilarity(from, to, weights, false);
    rigid.scale = before.scale;
    return rigid;
  }

  PointsX3 a_, b_, a_marks_, b_marks_;
  KdTree b_tree_;
};

Alignment AlignByIcp(const Mesh& source, const Mesh& target, const PointsX3& source_marks,
                     const PointsX3& target_marks) {
  const PointsX3 a = AreaSamples(source, 1), b = AreaSamples(target, 1);
  const double spread = Spread(a);
  if (!(spread > 0))
    throw InputError("register: all vertices of the source coincide; pass a mesh with some extent");
  const SimilarityIcp icp(a, b, source_marks, target_marks);
  const std::vector<Eigen::Matrix3d> starts = Starts();
  std::vector<Similarity3> fits(starts.size());
  std::vector<double> costs(starts.size());
  ParallelFor(std::ssize(starts), [&](std::int64_t s) {
    fits[s].scale = Spread(b) / spread;
    fits[s].rotation = starts[s];
    fits[s].translation = (b.colwise().mean().transpose() -
                           fits[s].scale * (starts[s] * a.colwise().mean().transpose()))
                              .eval();
    costs[s] = icp.Run(fits[s], kCoarseRounds, false);
  });
  std::size_t best = 0;
  for (std::size_t s = 1; s < starts.size(); ++s)
    if (costs[s] <
        (best == 0 ? AlignmentTuning::kBetterBy * AlignmentTuning::kBetterBy : 1.0) * costs[best])
      best = s;
  Alignment result;
  result.target_from_source = fits[best];
  const double cost = icp.Run(result.target_from_source, kFineRounds, true);
  result.method = source_marks.rows() > 0 ? "icp with landmarks" : "icp";
  result.starts = SizeOf(starts);
  result.residual = std::sqrt(cost) / BoundingDiagonal(target.points);
  return result;
}

}  // namespace

int SpreadRank(const PointsX3& points) {
  if (points.rows() < 2) return 0;
  const Eigen::MatrixXd centred = points.rowwise() - points.colwise().mean();
  const Eigen::VectorXd sv = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
  if (!(sv[0] > 0)) return 0;
  return static_cast<int>((sv.array() >= 0.05 * sv[0]).count());
}

Alignment AlignGlobally(const Mesh& source, const Mesh& target, const PointsX3& source_marks,
                        const PointsX3& target_marks) {
  const int rank = std::min(SpreadRank(source_marks), SpreadRank(target_marks));
  Alignment result;
  if (source_marks.rows() >= 3 && rank >= 2) {
    result.target_from_source = FitSimilarity(source_marks, target_marks);
    const double squares =
        (Transformed(result.target_from_source, source_marks) - target_marks).squaredNorm();
    result.method = "procrustes";
    result.residual = std::sqrt(squares / static_cast<double>(source_marks.rows())) /
                      BoundingDiagonal(target.points);
  } else {
    result = AlignByIcp(source, target, source_marks, target_marks);
  }
  result.rank = rank;
  return result;
}

}  // namespace keypose::registration
