#include "texture/unwrap/flat_charts.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <string>
#include <tuple>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "texture/charts/hidden_seams.h"
#include "texture/charts/parametrise.h"

namespace keypose::texture {
namespace {

// Chosen on the meshes of docs/results/texture.md (armadillo, ogre, spot, skull, plush dog, limbed
// figure); no record of the trials.
struct FlatChartTuning {
  KEYPOSE_TUNED(int, kFacesPerChart, 300);  // faces, initially, before charts are merged
  KEYPOSE_TUNED(int, kEarlyBand, 5);        // rings by which a border of the small charts may move
  KEYPOSE_TUNED(int, kLateBand, 20);        // ... of the large ones
  // share of the smaller chart's rim cost, times the mean cost per length: merges with a lower
  // score are not tried
  KEYPOSE_TUNED(double, kLeastScore, 0.03);
  // |sum of normals| / area: merges with less are not tried
  KEYPOSE_TUNED(double, kLeastFlatness, 0.35);
  // largest stretch max(s1, 1 / s2) within a chart: of 99 % of the area, and of any face
  KEYPOSE_TUNED(double, kP99Distortion, 2);
  KEYPOSE_TUNED(double, kWorstDistortion, 8);
};

constexpr int kLloydRounds = 6;
constexpr int kRounds = 25;  // of flattening while charts are cut and merged
constexpr int kFinalRounds = 200;
constexpr int kEarlyHidingRounds = 2;
// faces: charts of at most this size are merged with a neighbour even with a little too much
// distortion
constexpr std::size_t kCrumb = 12;
constexpr double kCrumbSlack = 1.05;

}  // namespace

std::optional<FlatChart> ChartAtlas::TryFlat(std::vector<int> faces, int rounds,
                                             double slack) const {
  FlatChart flat;
  flat.chart = MakeChart(surface_, std::move(faces));
  if (!flat.chart.disk) return std::nullopt;
  std::optional<UvsX2> uvs = Flattened(surface_, flat.chart, rounds);
  if (!uvs) return std::nullopt;
  if (flat.chart.faces.size() > 1) {
    const Distortion distortion = MeasureDistortion(surface_, flat.chart, *uvs);
    if (!(distortion.mean <= slack * max_distortion_) ||
        !(distortion.p99 <= slack * FlatChartTuning::kP99Distortion) ||
        !(distortion.max <= slack * FlatChartTuning::kWorstDistortion))
      return std::nullopt;
  }
  flat.uvs = std::move(*uvs);
  return flat;
}

// Each round flattens all open pieces in parallel, and halves those that failed; a single triangle
// is always flat.
void ChartAtlas::Settle(std::vector<std::vector<int>> work) {
  while (!work.empty()) {
    ReportProgress(progress_, 0.2, "flattening " + std::to_string(work.size()) + " charts");
    std::vector<std::optional<FlatChart>> flats(work.size());
    ParallelFor(std::ssize(work), [&](std::int64_t i) { flats[i] = TryFlat(work[i], kRounds); });
    std::vector<std::vector<int>> next;
    for (std::size_t i = 0; i < work.size(); ++i) {
      if (flats[i]) {
        charts_.push_back(std::move(*flats[i]));
        continue;
      }
      if (work[i].size() == 1)
        throw InputError("unwrap: face " + std::to_string(work[i][0]) +
                         " has practically no area; run cleanup on the mesh first");
      for (std::vector<int>& half : Halved(surface_, work[i])) next.push_back(std::move(half));
    }
    work = std::move(next);
  }
}

void ChartAtlas::Cut() {
  const int faces = static_cast<int>(surface_.faces.rows());
  std::vector<int> label = CutIntoCharts(
      surface_, std::clamp(faces / FlatChartTuning::kFacesPerChart, 1, 120), kLloydRounds);
  const int count = *std::max_element(label.begin(), label.end()) + 1;
  for (int round = 0; round < kEarlyHidingRounds; ++round) {
    for (const auto& [pair, cost] : Shared(label, costs_))
      for (const int f : BetterBorder(surface_, costs_, label, pair.first, pair.second,
                                      FlatChartTuning::kEarlyBand))
        label[f] = pair.first + pair.second - label[f];
  }
  std::vector<std::vector<int>> work(count);
  for (int f = 0; f < faces; ++f) work[label[f]].push_back(f);
  std::erase_if(work, [](const std::vector<int>& faces_of) { return faces_of.empty(); });
  Settle(std::move(work));
}

std::vector<int> ChartAtlas::Labels() const {
  std::vector<int> label(surface_.faces.rows());
  for (int c = 0; c < std::ssize(charts_); ++c)
    for (const int f : charts_[c].chart.faces) label[f] = c;
  return label;
}

std::map<std::pair<int, int>, double> ChartAtlas::Shared(const std::vector<int>& label,
                                                         const PointsX3& of_edges) const {
  std::map<std::pair<int, int>, double> shared;
  for (int f = 0; f < std::ssize(label); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int other = label[surface_.neighbors(f, k)];
      if (other > label[f]) shared[{label[f], other}] += of_edges(f, k);
    }
  }
  return shared;
}

double ChartAtlas::RimCost(const FlatChart& flat, const std::vector<int>& label) const {
  double cost = 0;
  for (const int f : flat.chart.faces)
    for (int k = 0; k < 3; ++k)
      if (label[surface_.neighbors(f, k)] != label[f]) cost += costs_(f, k);
  return cost;
}

// Charts that bend too far cannot be flat; testing that first avoids most attempts.
bool ChartAtlas::WorthJoining(const FlatChart& a, const FlatChart& b) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  double area = 0;
  for (const FlatChart* flat : {&a, &b}) {
    for (const int f : flat->chart.faces) {
      sum += surface_.areas[f] * surface_.normals.row(f);
      area += surface_.areas[f];
    }
  }
  return area <= largest_share_ * surface_.areas.sum() &&
         sum.norm() >= FlatChartTuning::kLeastFlatness * area;
}

// One pass over the pairs, those with the largest and most visible shared borders first. Each chart
// takes part in one merge per round.
bool ChartAtlas::JoinRound(std::set<std::pair<int, int>>& failed) {
  const std::vector<int> label = Labels();
  std::vector<double> rim;
  for (const FlatChart& flat : charts_) rim.push_back(RimCost(flat, label));
  std::vector<std::tuple<double, int, int>> pairs;
  const std::map<std::pair<int, int>, double> lengths = Shared(label, lengths_);
  for (const auto& [pair, cost] : Shared(label, costs_)) {
    const auto [a, b] = pair;
    const std::pair<int, int> name =
        std::minmax(charts_[a].chart.faces.front(), charts_[b].chart.faces.front());
    if (failed.contains(name)) continue;
    pairs.emplace_back(-cost / std::min(rim[a], rim[b]) * (cost / lengths.at(pair)), a, b);
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<char> used(charts_.size(), 0);
  bool joined = false;
  for (const auto& [score, a, b] : pairs) {
    if (used[a] || used[b]) continue;
    const std::pair<int, int> name =
        std::minmax(charts_[a].chart.faces.front(), charts_[b].chart.faces.front());
    std::optional<FlatChart> both;
    const bool crumb =
        std::min(charts_[a].chart.faces.size(), charts_[b].chart.faces.size()) <= kCrumb;
    if (crumb || (-score > FlatChartTuning::kLeastScore && WorthJoining(charts_[a], charts_[b]))) {
      std::vector<int> faces = charts_[a].chart.faces;
      faces.insert(faces.end(), charts_[b].chart.faces.begin(), charts_[b].chart.faces.end());
      both = TryFlat(std::move(faces), kRounds, crumb ? kCrumbSlack : 1);
    }
    if (!both) {
      failed.insert(name);
      continue;
    }
    // The merged chart keeps the lower index. Pairs that failed with either part may work with the
    // merged chart, so they are tried again.
    std::erase_if(failed, [&](const std::pair<int, int>& p) {
      return p.first == name.first || p.second == name.first;
    });
    charts_[a] = std::move(*both);
    charts_[b].chart.faces.clear();
    used[a] = used[b] = 1;
    joined = true;
  }
  std::erase_if(charts_, [](const FlatChart& flat) { return flat.chart.faces.empty(); });
  return joined;
}

void ChartAtlas::Join(double largest_share) {
  largest_share_ = largest_share;
  std::set<std::pair<int, int>> failed;
  for (int round = 0; round < 12; ++round) {
    ReportProgress(progress_, 0.3 + 0.03 * round,
                   "merging " + std::to_string(charts_.size()) + " charts");
    if (!JoinRound(failed)) break;
  }
}

// One border after the other, the costliest first, since each change affects a chart's next border.
void ChartAtlas::Hide() {
  std::vector<int> label = Labels();
  std::vector<std::tuple<double, int, int>> pairs;
  for (const auto& [pair, cost] : Shared(label, costs_))
    pairs.emplace_back(-cost, pair.first, pair.second);
  std::sort(pairs.begin(), pairs.end());
  for (const auto& pair : pairs) {
    const int a = std::get<1>(pair), b = std::get<2>(pair);
    ReportProgress(progress_, 0.6, "hiding seams");
    const std::vector<int> changed =
        BetterBorder(surface_, costs_, label, a, b, FlatChartTuning::kLateBand);
    if (changed.empty()) continue;
    for (const int f : changed) label[f] = a + b - label[f];
    std::array<std::optional<FlatChart>, 2> flats;
    ParallelFor(2, [&](std::int64_t i) {
      std::vector<int> faces;
      for (int f = 0; f < std::ssize(label); ++f)
        if (label[f] == (i ? b : a)) faces.push_back(f);
      flats[i] = TryFlat(std::move(faces), kRounds);
    });
    if (flats[0] && flats[1]) {
      charts_[a] = std::move(*flats[0]);
      charts_[b] = std::move(*flats[1]);
    } else {
      for (const int f : changed) label[f] = a + b - label[f];
    }
  }
}

// More rounds for the final charts; where they lead to a fold, the earlier result is kept.
void ChartAtlas::Refine() {
  ParallelFor(std::ssize(charts_), [&](std::int64_t i) {
    const Chart& chart = charts_[i].chart;
    std::optional<UvsX2> uvs = Flattened(surface_, chart, kFinalRounds);
    if (uvs && MeasureDistortion(surface_, chart, *uvs).max <= FlatChartTuning::kWorstDistortion)
      charts_[i].uvs = std::move(*uvs);
  });
}

}  // namespace keypose::texture
