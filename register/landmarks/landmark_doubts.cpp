#include "register/landmarks/landmark_doubts.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/numbers/kd_tree.h"
#include "core/numbers/statistics.h"
#include "core/values/camera.h"
#include "core/values/tuned.h"
#include "deform/levels/geodesics.h"
#include "register/nricp/alignment.h"

namespace keypose::registration {

namespace {

// Chosen on hand-picked landmarks of squashed clay, whose distances change by a third when they are
// correct, so the margins are wide; no record of single values. Sensitivity:
// docs/results/sensitivity.md.
struct LandmarkDoubtTuning {
  KEYPOSE_TUNED(double, kSwapGain, 0.45);  // stress after the exchange over stress before
  // mean |log ratio|: least stress of the two landmarks for a warning
  KEYPOSE_TUNED(double, kSwapLeast, 0.12);
  // log ratio: a landmark whose distances change by a factor of 1.8 more than the rest
  KEYPOSE_TUNED(double, kMisplacedLog, 0.6);
  KEYPOSE_TUNED(double, kRestLog, 0.25);      // log ratio: the others agree within a factor of 1.3
  KEYPOSE_TUNED(double, kMirrorGain, 0.4);    // residual after reflection over residual before
  KEYPOSE_TUNED(double, kMirrorLeast, 0.08);  // of the spread of the landmarks: residual before
  // of the largest distance: added to all, so that near landmarks count less
  KEYPOSE_TUNED(double, kFloor, 0.02);
};

/// L x L distances along the surface between landmarks.
Eigen::MatrixXd Between(const Mesh& mesh, const std::vector<int>& vertices) {
  const GeodesicGraph graph(mesh.points, mesh.faces, GeodesicGraph::kEdgesOnly);
  const Eigen::MatrixXd rows = graph.Rows(vertices);
  Eigen::MatrixXd between(rows.rows(), rows.rows());
  for (Eigen::Index i = 0; i < rows.rows(); ++i)
    for (Eigen::Index j = 0; j < rows.rows(); ++j) between(i, j) = rows(i, vertices[j]);
  return between;
}

/// Changes of distances between landmarks: log ratios minus their median. Targets may be exchanged.
class Stress {
 public:
  Stress(Eigen::MatrixXd source, Eigen::MatrixXd target)
      : source_(std::move(source)), target_(std::move(target)) {
    floor_ = LandmarkDoubtTuning::kFloor * std::max(source_.maxCoeff(), 1e-300);
    target_floor_ = LandmarkDoubtTuning::kFloor * std::max(target_.maxCoeff(), 1e-300);
    std::vector<double> logs;
    for (Eigen::Index i = 0; i < source_.rows(); ++i)
      for (Eigen::Index j = 0; j < i; ++j) logs.push_back(Log(i, j, i, j));
    median_ = UpperMedian(logs);
  }
  /// |change| of the distance between landmarks i and j whose targets are those of ti and tj.
  double Change(Eigen::Index i, Eigen::Index j, Eigen::Index ti, Eigen::Index tj) const {
    return std::abs(Log(i, j, ti, tj) - median_);
  }
  Eigen::Index count() const { return source_.rows(); }

  /// Mean change over all distances from a and b to the others, with or without their targets
  /// exchanged.
  double OfTwo(Eigen::Index a, Eigen::Index b, bool exchanged) const {
    double sum = 0;
    for (Eigen::Index k = 0; k < count(); ++k) {
      if (k == a || k == b) continue;
      sum += Change(a, k, exchanged ? b : a, k) + Change(b, k, exchanged ? a : b, k);
    }
    return sum / static_cast<double>(2 * std::max<Eigen::Index>(1, count() - 2));
  }
  /// Median change over the distances from a to the others.
  double OfOne(Eigen::Index a) const {
    std::vector<double> changes;
    for (Eigen::Index k = 0; k < count(); ++k)
      if (k != a) changes.push_back(Change(a, k, a, k));
    return UpperMedian(changes);
  }

 private:
  double Log(Eigen::Index i, Eigen::Index j, Eigen::Index ti, Eigen::Index tj) const {
    return std::log((target_(ti, tj) + target_floor_) / (source_(i, j) + floor_));
  }
  Eigen::MatrixXd source_, target_;
  double median_ = 0, floor_ = 0, target_floor_ = 0;
};

std::string Quoted(const std::string& name) { return "'" + name + "'"; }

void FindSwapped(const Stress& stress, const std::vector<LandmarkGoal>& goals,
                 std::vector<char>& named, std::vector<std::string>& doubts) {
  struct Exchange {
    double gain;
    Eigen::Index a, b;
  };
  std::vector<Exchange> exchanges;
  for (Eigen::Index a = 0; a < stress.count(); ++a)
    for (Eigen::Index b = a + 1; b < stress.count(); ++b) {
      const double before = stress.OfTwo(a, b, false), after = stress.OfTwo(a, b, true);
      if (before > LandmarkDoubtTuning::kSwapLeast &&
          after < LandmarkDoubtTuning::kSwapGain * before)
        exchanges.push_back({before - after, a, b});
    }
  std::stable_sort(exchanges.begin(), exchanges.end(),
                   [](const Exchange& x, const Exchange& y) { return x.gain > y.gain; });
  for (const Exchange& e : exchanges) {
    char &first = named[e.a], &second = named[e.b];
    if (first || second) continue;
    first = second = 1;
    doubts.push_back("landmarks " + Quoted(goals[e.a].name) + " and " + Quoted(goals[e.b].name) +
                     " look swapped: with their targets exchanged the distances along the surface "
                     "would fit; check which is which");
  }
}

void FindMisplaced(const Stress& stress, const std::vector<LandmarkGoal>& goals,
                   std::vector<char>& named, std::vector<std::string>& doubts) {
  std::vector<double> changes;
  for (Eigen::Index a = 0; a < stress.count(); ++a) changes.push_back(stress.OfOne(a));
  if (UpperMedian(changes) > LandmarkDoubtTuning::kRestLog)
    return;  // nothing fits: probably another shape, not one bad landmark
  for (std::size_t a = 0; a < changes.size(); ++a) {
    if (named[a] || changes[a] < LandmarkDoubtTuning::kMisplacedLog) continue;
    // Name the landmark that it disagrees with most, as a hint where it is wrong.
    std::size_t worst = a == 0 ? 1 : 0;
    for (std::size_t k = 0; k < changes.size(); ++k) {
      const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(k),
                 w = static_cast<Eigen::Index>(worst);
      if (k != a && stress.Change(i, j, i, j) > stress.Change(i, w, i, w)) worst = k;
    }
    named[a] = 1;
    doubts.push_back("landmark " + Quoted(goals[a].name) +
                     " contradicts most others, most of all " + Quoted(goals[worst].name) +
                     ": their distance along the surface changes far more than that of the rest; "
                     "check where it was picked");
  }
}

/// Root mean square residual of the best similarity transform, over the spread.
double FitResidual(const PointsX3& from, const PointsX3& to) {
  const Similarity3 fit = FitSimilarity(from, to);
  const double spread = (to.rowwise() - to.colwise().mean()).norm();
  return spread > 0 ? (Transformed(fit, from) - to).norm() / spread : 0;
}

void FindMirrored(const PointsX3& from, const PointsX3& to, std::vector<std::string>& doubts) {
  if (from.rows() < 5 || SpreadRank(from) < 3 || SpreadRank(to) < 3) return;
  PointsX3 reflected = from;
  reflected.col(0) *= -1;
  const double straight = FitResidual(from, to), mirrored = FitResidual(reflected, to);
  if (straight > LandmarkDoubtTuning::kMirrorLeast &&
      mirrored < LandmarkDoubtTuning::kMirrorGain * straight)
    doubts.push_back(
        "the landmarks describe a mirror image: left and right look exchanged throughout; check "
        "the sides");
}

}  // namespace

std::vector<std::string> WarningsAbout(const std::vector<LandmarkGoal>& goals, const Mesh& source,
                                       const Mesh& target) {
  std::vector<std::string> doubts;
  if (goals.size() < 4) return doubts;
  PointsX3 from(std::ssize(goals), 3), to(from.rows(), 3);
  for (std::size_t k = 0; k < goals.size(); ++k) {
    from.row(k) = PositionOf(goals[k].source, source.points).transpose();
    to.row(k) = goals[k].target.transpose();
  }
  FindMirrored(from, to, doubts);
  if (std::max(source.vertex_count(), target.vertex_count()) > kLargestForDistances) return doubts;
  std::vector<int> on_source, on_target;
  const KdTree tree(target.points);
  for (const LandmarkGoal& goal : goals) {
    Eigen::Index heaviest = 0;
    goal.source.weights.maxCoeff(&heaviest);
    on_source.push_back(goal.source.vertices[heaviest]);
    on_target.push_back(tree.Nearest(goal.target).index);
  }
  const Stress stress(Between(source, on_source), Between(target, on_target));
  std::vector<char> named(goals.size(), 0);
  FindSwapped(stress, goals, named, doubts);
  FindMisplaced(stress, goals, named, doubts);
  return doubts;
}

}  // namespace keypose::registration
