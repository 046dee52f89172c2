#include "capture/segmentation/pixel_classifier.h"

#include <gtest/gtest.h>

#include "core/numbers/parallel.h"

namespace keypose::capture::pixel_classifier_test {

/// Object where exactly one of two features is high: no single decision separates the two.
PixelSamples Crossed(int seed) {
  PixelSamples samples;
  for (int i = 0; i < 400; ++i) {
    PixelFeatures f{};
    for (std::size_t k = 0; k < f.size(); ++k)
      f[k] = static_cast<std::uint8_t>(
          (i * 37 + static_cast<int>(k) * 101 + seed * 13 + i * i * 7) % 64);
    f[0] = static_cast<std::uint8_t>((i * 29 + seed) % 64);
    f[1] = static_cast<std::uint8_t>((i * 23 + i / 64 + seed) % 64);
    samples.features.push_back(f);
    samples.object.push_back((f[0] >= 32) != (f[1] >= 32));
  }
  return samples;
}

TEST(PixelClassifier, LearnsWhatTwoFeaturesTellOnlyTogether) {
  const PixelSamples a = Crossed(1), b = Crossed(2), unseen = Crossed(3);
  const PixelClassifier classifier({&a, &b}, {});
  int right = 0;
  for (std::size_t i = 0; i < unseen.features.size(); ++i)
    right += (classifier.Odds(unseen.features[i], 6) > 0) == (unseen.object[i] != 0);
  EXPECT_GT(right, 340);
}

TEST(PixelClassifier, SameOddsForAnyThreadCountAndNoneWithoutBothKinds) {
  const PixelSamples samples = Crossed(1);
  SetThreadCount(1);
  const PixelClassifier one({&samples}, {});
  SetThreadCount(4);
  const PixelClassifier four({&samples}, {});
  SetThreadCount(0);
  for (const PixelFeatures& f : samples.features) EXPECT_EQ(one.Odds(f, 6), four.Odds(f, 6));
  PixelSamples background = samples;
  background.object.assign(background.object.size(), 0);
  EXPECT_EQ(PixelClassifier({&background}, {}).Odds(samples.features[0], 6), 0);
}

}  // namespace keypose::capture::pixel_classifier_test
