#include "register/intrinsic/map_candidates.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/camera.h"
#include "core/values/tuned.h"
#include "register/intrinsic/tip_matching.h"

namespace keypose::registration {

namespace {

// Chosen on the seven registration pairs (docs/results/landmarks.md); sensitivity:
// docs/results/sensitivity.md.
struct MapCandidatesTuning {
  // Weights of start rows. Distances (over the square root of the area) have weight 1.
  KEYPOSE_TUNED(double, kTurnWeight, 0.15);        // of turns, which are up to 1
  KEYPOSE_TUNED(double, kDescriptorWeight, 0.05);  // of descriptors, of the order of 1
  // Weights during refinement. Eigenfunctions have weight 1.
  KEYPOSE_TUNED(double, kHintWeight, 0.5);          // of the start rows while functions are few
  KEYPOSE_TUNED(double, kLikenessAfterwards, 0.5);  // of descriptors in the rounds without hints
  // Weights in the score. The mean change of distances (over the square root of the area) has 1.
  KEYPOSE_TUNED(double, kMissedWeight, 0.5);      // of the known landmarks' mean error, likewise
  KEYPOSE_TUNED(double, kUnfitWeight, 0.1);       // of the best similarity's error, likewise
  KEYPOSE_TUNED(double, kMirroredWeight, 0.05);   // of 1 - correlation of turns
  KEYPOSE_TUNED(double, kUncoveredWeight, 0.05);  // of the share of area that nothing maps to
  KEYPOSE_TUNED(double, kUnlikeWeight, 0.1);      // of the mean difference of descriptors
};

constexpr Eigen::Index kMarks = 12;

/// Candidates are refined in stages, and each stage keeps only the best. The score at the start
/// already predicts the result: the final best were nearly always among the first third.
struct Stage {
  std::size_t kept;
  std::vector<int> hinted_sizes, free_sizes;
};
const std::vector<Stage> kStages = {{32, {8, 10, 12}, {}}, {16, {14, 17, 20}, {24, 28, 32}}};

/// The data that all candidates share. A rise is the direction in which the distance to a point
/// grows, see RisesAtSamples.
struct Pair {
  const IntrinsicShape& source;
  const IntrinsicShape& target;
  Eigen::MatrixXd source_between, target_between;            ///< distances between samples
  Eigen::MatrixXd source_descriptors, target_descriptors;    ///< at samples
  std::vector<PointsX3> source_tip_rises, target_tip_rises;  ///< for distances to tips
  /// for distances to the first kMarks samples, which are far from each other
  std::vector<PointsX3> source_mark_rises;
  std::vector<PointsX3> target_sample_rises;  ///< for distances to all samples
  PointsX3 source_normals, target_normals, source_places, target_places;  ///< at samples
};

Eigen::MatrixXd AtSamples(const Eigen::MatrixXd& rows, const std::vector<int>& samples) {
  Eigen::MatrixXd picked(std::ssize(samples), rows.cols());
  for (std::size_t s = 0; s < samples.size(); ++s) picked.row(s) = rows.row(samples[s]);
  return picked;
}

Pair MakePair(const IntrinsicShape& source, const IntrinsicShape& target) {
  const Eigen::Index marks = std::min<Eigen::Index>(kMarks, source.sample_distances.rows());
  return {source,
          target,
          AtSamples(source.sample_distances.transpose(), source.samples),
          AtSamples(target.sample_distances.transpose(), target.samples),
          AtSamples(source.descriptors, source.samples),
          AtSamples(target.descriptors, target.samples),
          RisesAtSamples(source, source.tip_distances),
          RisesAtSamples(target, target.tip_distances),
          RisesAtSamples(source, source.sample_distances.topRows(marks)),
          RisesAtSamples(target, target.sample_distances),
          AtSamples(source.proxy.normals, source.samples),
          AtSamples(target.proxy.normals, target.samples),
          AtSamples(source.proxy.points, source.samples),
          AtSamples(target.proxy.points, target.samples)};
}

/// For each sample and each pair of the chosen tips: the sine of the angle between the two rises,
/// about the outward normal. It is equal under bending and opposite in a mirror image.
Eigen::MatrixXd TurnsBetween(const std::vector<PointsX3>& rises, const std::vector<int>& tips,
                             const PointsX3& normals) {
  const auto count = std::ssize(tips);
  Eigen::MatrixXd turns(normals.rows(), count * (count - 1) / 2);
  Eigen::Index column = 0;
  for (std::size_t a = 0; a < tips.size(); ++a)
    for (std::size_t b = a + 1; b < tips.size(); ++b, ++column)
      for (Eigen::Index i = 0; i < normals.rows(); ++i) {
        const Eigen::RowVector3d u = rises[tips[a]].row(i), v = rises[tips[b]].row(i);
        turns(i, column) = normals.row(i).dot(u.cross(v));
      }
  return turns;
}

TipProblem MakeTipProblem(const IntrinsicShape& source, const IntrinsicShape& target, int known) {
  TipProblem problem;
  problem.known = known;
  problem.source_distances = AtSamples(source.tip_distances.transpose(), source.tips);
  problem.target_distances = AtSamples(target.tip_distances.transpose(), target.tips);
  const Eigen::MatrixXd a = AtSamples(source.descriptors, source.tips),
                        b = AtSamples(target.descriptors, target.tips);
  problem.unlike.resize(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j)
      problem.unlike(i, j) = std::min(1.0, (a.row(i) - b.row(j)).cwiseAbs().mean());
  return problem;
}

Eigen::MatrixXd StraightDistances(const IntrinsicShape& shape) {
  const auto count = std::ssize(shape.tips);
  Eigen::MatrixXd distances(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    for (Eigen::Index j = 0; j < count; ++j)
      distances(i, j) =
          (shape.proxy.points.row(shape.tips[i]) - shape.proxy.points.row(shape.tips[j])).norm();
  return distances;
}

/// The assignments to try. Three quarters are found by distances along the surface, the rest by
/// straight distances. The latter help when poses are similar but bodies differ (a long and a short
/// tail).
std::vector<TipAssignment> Assignments(const IntrinsicShape& source, const IntrinsicShape& target,
                                       int known, int tried) {
  TipProblem problem = MakeTipProblem(source, target, known);
  const int straight = tried / 4;
  std::vector<TipAssignment> assignments = MatchTips(problem, tried - straight);
  problem.source_distances = StraightDistances(source);
  problem.target_distances = StraightDistances(target);
  for (TipAssignment& more : MatchTips(problem, std::max(1, straight)))
    if (std::none_of(assignments.begin(), assignments.end(),
                     [&](const auto& a) { return a.target_of == more.target_of; }))
      assignments.push_back(std::move(more));
  return assignments;
}

/// One row per sample, for matching: distances to the tips, turns and descriptors. Corresponding
/// points have similar rows.
Eigen::MatrixXf StartRows(const IntrinsicShape& shape, const std::vector<int>& tips,
                          const Eigen::MatrixXd& descriptors, const Eigen::MatrixXd& turns) {
  const auto count = std::ssize(tips), samples = std::ssize(shape.samples);
  Eigen::MatrixXf rows(samples, count + turns.cols() + descriptors.cols());
  for (Eigen::Index t = 0; t < count; ++t)
    for (Eigen::Index s = 0; s < samples; ++s)
      rows(s, t) = static_cast<float>(shape.tip_distances(tips[t], shape.samples[s]));
  const double turn_weight =
      turns.cols() > 0
          ? MapCandidatesTuning::kTurnWeight *
                std::sqrt(static_cast<double>(count) / static_cast<double>(turns.cols()))
          : 0;
  rows.middleCols(count, turns.cols()) = (turn_weight * turns).cast<float>();
  rows.rightCols(descriptors.cols()) =
      (MapCandidatesTuning::kDescriptorWeight * std::sqrt(static_cast<double>(count)) * descriptors)
          .cast<float>();
  return rows;
}

/// Weighted mean of |d1(i,j) - d2(m(i), m(j))|.
double Distortion(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to,
                  const std::vector<int>& map, const Eigen::VectorXd& weights) {
  double sum = 0;
  for (Eigen::Index j = 0; j < from.cols(); ++j) {
    const int mj = map[j];
    double column = 0;
    for (Eigen::Index i = 0; i < from.rows(); ++i)
      column += weights[i] * std::abs(from(i, j) - to(map[i], mj));
    sum += weights[j] * column;
  }
  return sum;
}

double Coverage(const std::vector<int>& map, const Eigen::VectorXf& weights) {
  std::vector<char> hit(static_cast<std::size_t>(weights.size()), 0);
  for (const int j : map) hit[j] = 1;
  double covered = 0;
  for (Eigen::Index j = 0; j < weights.size(); ++j) covered += hit[j] ? weights[j] : 0;
  return covered / static_cast<double>(weights.sum());
}

/// Whether a map keeps the order of directions about the normal: the correlation of the turns
/// between rises to marks, before and after mapping. 1: kept; -1: a mirror image.
double OrientationOf(const Pair& pair, const std::vector<int>& map,
                     const Eigen::VectorXd& weights) {
  double ab = 0, aa = 1e-12, bb = 1e-12;
  const std::size_t marks = pair.source_mark_rises.size();
  for (Eigen::Index i = 0; i < pair.source_normals.rows(); ++i) {
    const int j = map[i];
    const Eigen::RowVector3d n = pair.source_normals.row(i), m = pair.target_normals.row(j);
    for (std::size_t k = 0; k < marks; ++k) {
      const Eigen::RowVector3d u = n.cross(pair.source_mark_rises[k].row(i));
      const Eigen::RowVector3d v = m.cross(pair.target_sample_rises[map[k]].row(j));
      for (std::size_t l = k + 1; l < marks; ++l) {
        const double a = u.dot(pair.source_mark_rises[l].row(i));
        const double b = v.dot(pair.target_sample_rises[map[l]].row(j));
        ab += weights[i] * a * b;
        aa += weights[i] * a * a;
        bb += weights[i] * b * b;
      }
    }
  }
  return ab / std::sqrt(aa * bb);
}

/// Mean distance of the mapped landmarks from their targets.
double MissedLandmarks(const Pair& pair, const std::vector<int>& map) {
  double missed = 0;
  for (int k = 0; k < pair.source.known; ++k) {
    const int sample = pair.source.sample_of[pair.source.tips[k]];
    const int image = pair.target.samples[map[sample]];
    missed += pair.target.tip_distances(k, image) / pair.source.known;
  }
  return missed;
}

void SetScore(const Pair& pair, MapCandidate& c) {
  const Eigen::VectorXd ws =
      pair.source.sampled.weights.cast<double>() / pair.source.sampled.weights.sum();
  const Eigen::VectorXd wt =
      pair.target.sampled.weights.cast<double>() / pair.target.sampled.weights.sum();
  c.distortion = 0.5 * (Distortion(pair.source_between, pair.target_between, c.maps.forward, ws) +
                        Distortion(pair.target_between, pair.source_between, c.maps.backward, wt));
  c.coverage = std::min(Coverage(c.maps.forward, pair.target.sampled.weights),
                        Coverage(c.maps.backward, pair.source.sampled.weights));
  c.orientation = OrientationOf(pair, c.maps.forward, ws);
  c.unlike = 0;
  for (Eigen::Index i = 0; i < ws.size(); ++i)
    c.unlike +=
        ws[i] * (pair.source_descriptors.row(i) - pair.target_descriptors.row(c.maps.forward[i]))
                    .cwiseAbs()
                    .mean();
  const PointsX3 image = AtSamples(pair.target_places, c.maps.forward);
  const Similarity3 fit = FitSimilarity(pair.source_places, image, ws);
  c.unfit =
      std::sqrt(ws.dot((Transformed(fit, pair.source_places) - image).rowwise().squaredNorm()));
  using Tuning = MapCandidatesTuning;
  c.score = Tuning::kMissedWeight * MissedLandmarks(pair, c.maps.forward) +
            Tuning::kUnfitWeight * c.unfit + c.distortion +
            Tuning::kMirroredWeight * (1 - c.orientation) +
            Tuning::kUncoveredWeight * (1 - c.coverage) + Tuning::kUnlikeWeight * c.unlike;
}

/// A candidate during refinement, with the start rows as hints.
struct StartedCandidate {
  MapCandidate candidate;
  MatchHints hints;
};

StartedCandidate Started(const Pair& pair, const TipAssignment& assignment) {
  StartedCandidate start;
  MapCandidate& c = start.candidate;
  for (std::size_t s = 0; s < assignment.target_of.size(); ++s)
    if (assignment.target_of[s] >= 0) {
      c.source_tips.push_back(static_cast<int>(s));
      c.target_tips.push_back(assignment.target_of[s]);
    }
  const Eigen::MatrixXd source_turns =
      TurnsBetween(pair.source_tip_rises, c.source_tips, pair.source_normals);
  const Eigen::MatrixXd target_turns =
      TurnsBetween(pair.target_tip_rises, c.target_tips, pair.target_normals);
  start.hints = {StartRows(pair.source, c.source_tips, pair.source_descriptors, source_turns),
                 StartRows(pair.target, c.target_tips, pair.target_descriptors, target_turns),
                 MapCandidatesTuning::kHintWeight};
  c.maps = NearestRows(start.hints.source, start.hints.target);
  SetScore(pair, c);
  return start;
}

void Refine(const Pair& pair, const Stage& stage, StartedCandidate& start) {
  PointMaps& maps = start.candidate.maps;
  maps =
      RefineMaps(pair.source.sampled, pair.target.sampled, maps, stage.hinted_sizes, start.hints);
  if (!stage.free_sizes.empty()) {
    const MatchHints likeness{pair.source_descriptors.cast<float>(),
                              pair.target_descriptors.cast<float>(),
                              MapCandidatesTuning::kLikenessAfterwards};
    maps = RefineMaps(pair.source.sampled, pair.target.sampled, maps, stage.free_sizes, likeness);
  }
  SetScore(pair, start.candidate);
}

}  // namespace

struct MapSearch::Shared {
  Pair pair;
};

MapSearch::MapSearch(const IntrinsicShape& source, const IntrinsicShape& target)
    : shared_(new Shared{MakePair(source, target)}) {}
MapSearch::~MapSearch() = default;

MapCandidate MapSearch::Scored(const std::vector<int>& source_tips,
                               const std::vector<int>& target_tips, const PointMaps& maps) const {
  MapCandidate candidate;
  candidate.source_tips = source_tips;
  candidate.target_tips = target_tips;
  candidate.maps = maps;
  SetScore(shared_->pair, candidate);
  return candidate;
}

std::vector<MapCandidate> MapSearch::Run(int known, int tried) const {
  const std::vector<TipAssignment> assignments =
      Assignments(shared_->pair.source, shared_->pair.target, known, tried);
  std::vector<StartedCandidate> started(assignments.size());
  const auto for_all = [&](const auto& change) {
    ParallelFor(std::ssize(started), [&](std::int64_t i) { change(static_cast<std::size_t>(i)); });
    std::stable_sort(started.begin(), started.end(),
                     [](const StartedCandidate& a, const StartedCandidate& b) {
                       return a.candidate.score < b.candidate.score;
                     });
  };
  for_all([&](std::size_t i) { started[i] = Started(shared_->pair, assignments[i]); });
  for (const Stage& stage : kStages) {
    started.resize(std::min(started.size(), stage.kept));
    for_all([&](std::size_t i) { Refine(shared_->pair, stage, started[i]); });
  }
  std::vector<MapCandidate> candidates;
  for (StartedCandidate& start : started) candidates.push_back(std::move(start.candidate));
  return candidates;
}

}  // namespace keypose::registration
