// A random forest of decision trees that separates two kinds of pixels by a few features.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace keypose::capture {

inline constexpr int kFeatures = 11;       ///< number of features of a pixel
inline constexpr int kFeatureLevels = 64;  ///< each is in [0, kFeatureLevels)

using PixelFeatures = std::array<std::uint8_t, kFeatures>;

/// Pixels with an assumed label.
struct PixelSamples {
  std::vector<PixelFeatures> features;
  std::vector<std::uint8_t> object;  ///< 1 or 0, one for each of `features`
};

struct ClassifierOptions {
  int trees = 8;
  int depth = 10;          ///< largest number of decisions from root to leaf
  int least_samples = 24;  ///< a node with fewer is a leaf
  int tries = 5;           ///< features that are tried at each node
};

/// Trees grown on random halves of the samples. Each decision is the best of a few random features
/// by purity (Gini). Both kinds have the same weight, independent of their number of samples.
/// Source: Breiman, "Random forests", Machine Learning 2001.
/// Departs: samples are drawn without replacement.
class PixelClassifier {
 public:
  /// @param samples  of several images, in any order; if one kind has none, all odds are 0
  /// Same samples, same classifier.
  PixelClassifier(const std::vector<const PixelSamples*>& samples,
                  const ClassifierOptions& options);

  /// ln p(object) / p(background), within +-limit.
  float Odds(const PixelFeatures& pixel, float limit) const;

 private:
  struct Node {
    std::uint8_t feature = 0,
                 threshold = 0;     ///< the first child is for features below the threshold
    std::int32_t first_child = -1;  ///< -1: a leaf
    float object_share = 0.5F;
  };
  struct Grower;
  std::vector<std::vector<Node>> trees_;
};

}  // namespace keypose::capture
