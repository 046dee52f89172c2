#include "capture/segmentation/pixel_classifier.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "core/numbers/parallel.h"

namespace keypose::capture {

/// Grows one tree over given samples.
struct PixelClassifier::Grower {
  struct Sample {
    const PixelFeatures* features;
    bool object;
  };
  struct Question {
    int feature = -1, threshold = 0;
    double impurity = 0;
  };
  std::vector<Sample> samples;
  std::array<double, 2> weight;  // of one sample of each kind
  ClassifierOptions options;
  std::mt19937 random;
  std::vector<Node> nodes;

  /// The best threshold of one feature; replaces `best` if it is purer.
  void Ask(int feature, std::size_t begin, std::size_t end, Question& best) const {
    std::array<std::array<double, 2>, kFeatureLevels> counts{};
    std::array<double, 2> total{};
    for (std::size_t i = begin; i < end; ++i) {
      const auto level = (*samples[i].features)[feature];
      counts[level][samples[i].object] += weight[samples[i].object];
    }
    for (const auto& c : counts) {
      total[0] += c[0];
      total[1] += c[1];
    }
    std::array<double, 2> below{};
    for (int threshold = 1; threshold < kFeatureLevels; ++threshold) {
      for (std::size_t k = 0; k < 2; ++k) below[k] += counts[threshold - 1][k];
      const double here = below[0] + below[1], there = total[0] + total[1] - here;
      if (here <= 0 || there <= 0) continue;
      const double impurity =
          below[0] * below[1] / here + (total[0] - below[0]) * (total[1] - below[1]) / there;
      if (impurity < best.impurity) best = {feature, threshold, impurity};
    }
  }

  void Grow(std::size_t node, std::size_t begin, std::size_t end, int depth) {
    std::array<double, 2> total{};
    for (std::size_t i = begin; i < end; ++i) total[samples[i].object] += weight[samples[i].object];
    // Half a typical sample of each kind is added, so that a pure leaf of few samples is less
    // certain than one of many.
    const double prior = 0.5 * (weight[0] + weight[1]);
    nodes[node].object_share =
        static_cast<float>((total[1] + prior) / (total[0] + total[1] + 2 * prior));
    if (depth == 0 || end - begin < static_cast<std::size_t>(options.least_samples) ||
        total[0] <= 0 || total[1] <= 0)
      return;
    std::array<int, kFeatures> order{};
    for (int f = 0; f < kFeatures; ++f) order[f] = f;
    Question best{-1, 0, 0.999 * total[0] * total[1] / (total[0] + total[1])};
    for (std::size_t t = 0; t < static_cast<std::size_t>(std::min(options.tries, kFeatures)); ++t) {
      std::swap(order[t], order[t + random() % (kFeatures - t)]);
      Ask(order[t], begin, end, best);
    }
    if (best.feature < 0) return;
    const auto middle = std::partition(
        samples.begin() + static_cast<std::ptrdiff_t>(begin),
        samples.begin() + static_cast<std::ptrdiff_t>(end),
        [&](const Sample& s) { return (*s.features)[best.feature] < best.threshold; });
    const auto first = nodes.size();
    nodes[node].feature = static_cast<std::uint8_t>(best.feature);
    nodes[node].threshold = static_cast<std::uint8_t>(best.threshold);
    nodes[node].first_child = static_cast<std::int32_t>(first);
    nodes.resize(first + 2);
    const auto split = static_cast<std::size_t>(middle - samples.begin());
    Grow(first, begin, split, depth - 1);
    Grow(first + 1, split, end, depth - 1);
  }
};

PixelClassifier::PixelClassifier(const std::vector<const PixelSamples*>& samples,
                                 const ClassifierOptions& options) {
  std::array<double, 2> count{};
  for (const PixelSamples* s : samples)
    for (const std::uint8_t object : s->object) count[object != 0] += 1;
  if (count[0] == 0 || count[1] == 0) return;
  const double all = count[0] + count[1];
  trees_.resize(static_cast<std::size_t>(options.trees));
  ParallelFor(options.trees, [&](std::int64_t t) {
    Grower grower{{},
                  {all / (2 * count[0]), all / (2 * count[1])},
                  options,
                  std::mt19937(static_cast<unsigned>(t + 1)),
                  {}};
    for (const PixelSamples* s : samples)
      for (std::size_t i = 0; i < s->features.size(); ++i)
        if (grower.random() & 1U) grower.samples.push_back({&s->features[i], s->object[i] != 0});
    grower.nodes.resize(1);
    grower.Grow(0, 0, grower.samples.size(), options.depth);
    trees_[t] = std::move(grower.nodes);
  });
}

float PixelClassifier::Odds(const PixelFeatures& pixel, float limit) const {
  if (trees_.empty()) return 0;
  float share = 0;
  for (const std::vector<Node>& tree : trees_) {
    const Node* node = &tree[0];
    while (node->first_child >= 0)
      node = &tree[node->first_child + (pixel[node->feature] >= node->threshold)];
    share += node->object_share;
  }
  share /= static_cast<float>(trees_.size());
  return std::clamp(std::log(share / (1 - share)), -limit, limit);
}

}  // namespace keypose::capture
