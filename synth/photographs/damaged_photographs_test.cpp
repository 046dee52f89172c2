#include "synth/photographs/damaged_photographs.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <numeric>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "synth/photographs/testing/synth_files.h"

namespace keypose::synth::damaged_photographs_test {

namespace fs = std::filesystem;

TEST_F(SynthFiles, DamagedCopiesAreDamagedAsNamedAndOriginalsAreNot) {
  const std::string name = "IMG_0002.jpg";
  const std::string original_bytes = ReadFile(folder_ / "photos/rest" / name);
  const Image8 original = ReadImage(folder_ / "photos/rest" / name, 3);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kTruncate, name)), InputError);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kEmpty, name)), InputError);
  EXPECT_THROW(ReadImage(Spoilt(DamageKind::kNoImage, name)), InputError);
  EXPECT_FALSE(fs::exists(Spoilt(DamageKind::kDrop, name)));
  EXPECT_FALSE(ReadImageInfo(Spoilt(DamageKind::kStripExif, name)).focal_35mm.has_value());
  EXPECT_EQ(ReadImageInfo(Spoilt(DamageKind::kResize, name)).width, 160);
  const Image8 dark = ReadImage(Spoilt(DamageKind::kDark, name), 3);
  EXPECT_LT(std::accumulate(dark.data.begin(), dark.data.end(), 0.0) /
                static_cast<double>(dark.data.size()),
            12);
  const fs::path turned = Spoilt(DamageKind::kRotate, name);
  EXPECT_EQ(ReadImageInfo(turned).orientation, 6);
  const Image8 upright = ReadImage(turned, 3);
  ASSERT_EQ(upright.width, original.width);
  double difference = 0;
  for (std::size_t i = 0; i < original.data.size(); ++i)
    difference += std::abs(original.data[i] - upright.data[i]);
  EXPECT_LT(difference / static_cast<double>(original.data.size()),
            3);  // one more JPEG compression
  EXPECT_EQ(ReadFile(folder_ / "photos/rest" / name), original_bytes);
}

TEST_F(SynthFiles, BlurTakesTheEdgesAway) {
  const auto roughness = [](const Image8& image) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 1; x < image.width; ++x)
        sum += std::abs(image.at(x, y)[1] - image.at(x - 1, y)[1]);
    return sum;
  };
  const double sharp = roughness(ReadImage(folder_ / "photos/rest/IMG_0001.jpg", 3));
  EXPECT_LT(roughness(ReadImage(Spoilt(DamageKind::kBlur, "IMG_0001.jpg"), 3)), 0.5 * sharp);
}

/// Share of the pixels that a damage changes by more than noise and compression do.
double ShareDrawnOver(const Image8& before, const Image8& after) {
  double changed = 0;
  for (std::size_t i = 1; i < before.data.size(); i += 3)
    changed += std::abs(before.data[i] - after.data[i]) > 12;
  return 3 * changed / static_cast<double>(before.data.size());
}

TEST_F(SynthFiles, HandToolAndThumbCoverAPartAndLeaveTheRest) {
  const Image8 original = ReadImage(folder_ / "photos/rest/IMG_0003.jpg", 3);
  const auto share = [&](DamageKind kind) {
    return ShareDrawnOver(original, ReadImage(Spoilt(kind, "IMG_0003.jpg"), 3));
  };
  const double hand = share(DamageKind::kHand), tool = share(DamageKind::kTool),
               thumb = share(DamageKind::kThumb);
  EXPECT_GT(hand, 0.05);
  EXPECT_LT(hand, 0.35);
  EXPECT_GT(tool, 0.01);
  EXPECT_LT(tool, 0.08) << "a strip 0.04 to 0.06 of the height wide";
  EXPECT_GT(thumb, 0.02);
  EXPECT_LT(thumb, 0.3);
}

TEST_F(SynthFiles, UnknownDamageAndUnknownPhotographThrow) {
  EXPECT_THROW(DamageKindNamed("melt"), UsageError);
  EXPECT_THROW(
      DamagePhotos(folder_ / "photos/rest", folder_ / "spoilt_x", DamageKind::kDrop, {"none.jpg"}),
      InputError);
}

}  // namespace keypose::synth::damaged_photographs_test
