#include "register/map_search.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "register/tip_matching.h"

namespace keypose::registration {

namespace {

constexpr double kTurnWeight = 0.15;        // of turns (up to 1) beside distances (over the square root of the area)
constexpr double kDescriptorWeight = 0.05;  // of descriptors (of the order of 1)
constexpr double kHintWeight = 0.5;         // of the start's rows while few functions are in use
const std::vector<int> kHintedSizes = {8, 10, 12, 14, 17, 20}, kFreeSizes = {24, 28, 32};

/// What all candidates share.
struct Pair {
  const IntrinsicShape& source;
  const IntrinsicShape& target;
  Eigen::MatrixXd source_between, target_between;          ///< distances between samples
  Eigen::MatrixXd source_descriptors, target_descriptors;  ///< at samples
};

Eigen::MatrixXd AtSamples(const Eigen::MatrixXd& rows, const std::vector<int>& samples) {
  Eigen::MatrixXd picked(static_cast<Eigen::Index>(samples.size()), rows.cols());
  for (std::size_t s = 0; s < samples.size(); ++s) picked.row(static_cast<Eigen::Index>(s)) = rows.row(samples[s]);
  return picked;
}

Pair MakePair(const IntrinsicShape& source, const IntrinsicShape& target) {
  return {source,
          target,
          AtSamples(source.sample_distances.transpose(), source.samples),
          AtSamples(target.sample_distances.transpose(), target.samples),
          AtSamples(source.descriptors, source.samples),
          AtSamples(target.descriptors, target.samples)};
}

TipProblem MakeTipProblem(const IntrinsicShape& source, const IntrinsicShape& target, int known) {
  TipProblem problem;
  problem.known = known;
  problem.source_distances = AtSamples(source.tip_distances.transpose(), source.tips);
  problem.target_distances = AtSamples(target.tip_distances.transpose(), target.tips);
  const Eigen::MatrixXd a = AtSamples(source.descriptors, source.tips), b = AtSamples(target.descriptors, target.tips);
  problem.unlike.resize(a.rows(), b.rows());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j) problem.unlike(i, j) = std::min(1.0, (a.row(i) - b.row(j)).cwiseAbs().mean());
  return problem;
}

/// Rows that are alike where a point lies alike towards the tips; `turns` is left for judging the result.
Eigen::MatrixXf StartRows(const IntrinsicShape& shape, const std::vector<int>& tips, const Eigen::MatrixXd& descriptors,
                          const Eigen::MatrixXd& turns) {
  const auto count = static_cast<Eigen::Index>(tips.size()), samples = static_cast<Eigen::Index>(shape.samples.size());
  Eigen::MatrixXf rows(samples, count + turns.cols() + descriptors.cols());
  for (Eigen::Index t = 0; t < count; ++t)
    for (Eigen::Index s = 0; s < samples; ++s)
      rows(s, t) = static_cast<float>(shape.tip_distances(tips[static_cast<std::size_t>(t)], shape.samples[static_cast<std::size_t>(s)]));
  const double turn_weight = turns.cols() > 0 ? kTurnWeight * std::sqrt(static_cast<double>(count) / static_cast<double>(turns.cols())) : 0;
  rows.middleCols(count, turns.cols()) = (turn_weight * turns).cast<float>();
  rows.rightCols(descriptors.cols()) = (kDescriptorWeight * std::sqrt(static_cast<double>(count)) * descriptors).cast<float>();
  return rows;
}

/// Weighted mean of |d1(i,j) - d2(m(i), m(j))|.
double Distortion(const Eigen::MatrixXd& from, const Eigen::MatrixXd& to, const std::vector<int>& map, const Eigen::VectorXd& weights) {
  double sum = 0;
  for (Eigen::Index j = 0; j < from.cols(); ++j) {
    const int mj = map[static_cast<std::size_t>(j)];
    double column = 0;
    for (Eigen::Index i = 0; i < from.rows(); ++i) column += weights[i] * std::abs(from(i, j) - to(map[static_cast<std::size_t>(i)], mj));
    sum += weights[j] * column;
  }
  return sum;
}

double Coverage(const std::vector<int>& map, const Eigen::VectorXf& weights) {
  std::vector<char> hit(static_cast<std::size_t>(weights.size()), 0);
  for (const int j : map) hit[static_cast<std::size_t>(j)] = 1;
  double covered = 0;
  for (Eigen::Index j = 0; j < weights.size(); ++j) covered += hit[static_cast<std::size_t>(j)] ? weights[j] : 0;
  return covered / static_cast<double>(weights.sum());
}

double Correlation(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b, const std::vector<int>& map, const Eigen::VectorXd& weights) {
  double ab = 0, aa = 1e-12, bb = 1e-12;
  for (Eigen::Index i = 0; i < a.rows(); ++i) {
    const auto row = b.row(map[static_cast<std::size_t>(i)]);
    ab += weights[i] * a.row(i).dot(row);
    aa += weights[i] * a.row(i).squaredNorm();
    bb += weights[i] * row.squaredNorm();
  }
  return ab / std::sqrt(aa * bb);
}

void Judge(const Pair& pair, const Eigen::MatrixXd& source_turns, const Eigen::MatrixXd& target_turns, MapCandidate& c) {
  const Eigen::VectorXd ws = pair.source.sampled.weights.cast<double>() / pair.source.sampled.weights.sum();
  const Eigen::VectorXd wt = pair.target.sampled.weights.cast<double>() / pair.target.sampled.weights.sum();
  c.distortion = 0.5 * (Distortion(pair.source_between, pair.target_between, c.maps.forward, ws) +
                        Distortion(pair.target_between, pair.source_between, c.maps.backward, wt));
  c.coverage = std::min(Coverage(c.maps.forward, pair.target.sampled.weights), Coverage(c.maps.backward, pair.source.sampled.weights));
  c.orientation = Correlation(source_turns, target_turns, c.maps.forward, ws);
  c.unlike = 0;
  for (Eigen::Index i = 0; i < ws.size(); ++i)
    c.unlike +=
        ws[i] *
        (pair.source_descriptors.row(i) - pair.target_descriptors.row(c.maps.forward[static_cast<std::size_t>(i)])).cwiseAbs().mean();
  c.score = c.distortion + 0.05 * (1 - c.orientation) + 0.05 * (1 - c.coverage) + 0.05 * c.unlike;
}

MapCandidate Grow(const Pair& pair, const TipAssignment& assignment) {
  MapCandidate c;
  for (std::size_t s = 0; s < assignment.target_of.size(); ++s)
    if (assignment.target_of[s] >= 0) {
      c.source_tips.push_back(static_cast<int>(s));
      c.target_tips.push_back(assignment.target_of[s]);
    }
  const Eigen::MatrixXd source_turns = TurnsBetweenTips(pair.source, c.source_tips, pair.source.samples);
  const Eigen::MatrixXd target_turns = TurnsBetweenTips(pair.target, c.target_tips, pair.target.samples);
  MatchHints hints{StartRows(pair.source, c.source_tips, pair.source_descriptors, source_turns),
                   StartRows(pair.target, c.target_tips, pair.target_descriptors, target_turns), kHintWeight};
  c.maps = NearestRows(hints.source, hints.target);
  c.maps = RefineMaps(pair.source.sampled, pair.target.sampled, c.maps, kHintedSizes, hints);
  c.maps = RefineMaps(pair.source.sampled, pair.target.sampled, c.maps, kFreeSizes);
  Judge(pair, source_turns, target_turns, c);
  return c;
}

}  // namespace

MapCandidate JudgeMaps(const IntrinsicShape& source, const IntrinsicShape& target, const std::vector<int>& source_tips,
                       const std::vector<int>& target_tips, const PointMaps& maps) {
  MapCandidate candidate;
  candidate.source_tips = source_tips;
  candidate.target_tips = target_tips;
  candidate.maps = maps;
  Judge(MakePair(source, target), TurnsBetweenTips(source, source_tips, source.samples),
        TurnsBetweenTips(target, target_tips, target.samples), candidate);
  return candidate;
}

std::vector<MapCandidate> SearchMaps(const IntrinsicShape& source, const IntrinsicShape& target, int known, int tried) {
  const Pair pair = MakePair(source, target);
  const std::vector<TipAssignment> assignments = MatchTips(MakeTipProblem(source, target, known), tried);
  std::vector<MapCandidate> candidates(assignments.size());
  ParallelFor(static_cast<std::int64_t>(assignments.size()),
              [&](std::int64_t i) { candidates[static_cast<std::size_t>(i)] = Grow(pair, assignments[static_cast<std::size_t>(i)]); });
  std::stable_sort(candidates.begin(), candidates.end(), [](const MapCandidate& a, const MapCandidate& b) { return a.score < b.score; });
  return candidates;
}

}  // namespace keypose::registration
