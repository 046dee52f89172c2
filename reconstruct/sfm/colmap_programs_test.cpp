#include "reconstruct/sfm/colmap_programs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <random>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/png_io.h"
#include "core/testing/folder.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/testing/reported_stage.h"

namespace keypose::reconstruct::colmap_programs_test {

constexpr int kWidth = 320, kHeight = 240;

class ColmapProgramsTest : public ::testing::Test, public TestingFolder {
 protected:
  /// One photograph of blots, all of it in its mask.
  void SetUp() override {
    Image8 photo(kWidth, kHeight, 1);
    const Image8 mask(kWidth, kHeight, 1, 255);
    constexpr int kBlot = 5;
    std::mt19937 random(1);
    std::vector<std::uint8_t> blots(kWidth * kHeight / kBlot);
    for (std::uint8_t& blot : blots) blot = static_cast<std::uint8_t>(random() % 256);
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x)
        *photo.at(x, y) = blots[y / kBlot * (kWidth / kBlot) + x / kBlot];
    WriteImage(path() / "a.png", photo);
    WriteGreyMaskPng(path() / "a_mask.png", mask);
    CapturedImage image;
    image.name = "a.png";
    image.mask = "a_mask.png";
    image.width = kWidth, image.height = kHeight;
    set.folder = path();
    set.images = {image};
  }

  Features Extract(const FeatureKind& kind) {
    const SfmFiles files{path(), path(), path() / "d.db"};
    Camera camera;
    camera.width = kWidth, camera.height = kHeight;
    camera.fx = camera.fy = kWidth;
    camera.cx = kWidth / 2.0, camera.cy = kHeight / 2.0;
    std::filesystem::remove(files.database);
    ColmapDatabase database =
        ColmapDatabase::Create(files.database, {camera}, true, {"a.png"}, {0});
    ReportedStage stage;
    ExtractFeatures(stage, set, files, SfmOptions{}, kind);
    return database.ReadFeatures(0);
  }

  ImageSet set;
};

/// The least distance from the right and lower sides, in scales.
double ScalesToEnd(const Features& features) {
  double least = kWidth;
  for (int f = 0; f < features.count(); ++f)
    least = std::min<double>(
        least, std::min(kWidth - features.positions(f, 0), kHeight - features.positions(f, 1)) /
                   features.scales(f));
  return least;
}

// COLMAP leaves descriptors in an octave's last row unset: they changed from run to run, also those
// of masks that a photograph's lower side cuts.
TEST_F(ColmapProgramsTest, FeaturesWithoutADescriptorAreLeftOutInMasksAsInWholePhotographs) {
  const Features whole = Extract({.whole = true});
  EXPECT_GT(whole.count(), 100);
  EXPECT_GE(ScalesToEnd(whole), 2);
  // Half of these were found at twice the height, where a scale is larger.
  const Features region = Extract({.region = true, .on_table = true});
  EXPECT_GT(region.count(), 100);
  EXPECT_GE(ScalesToEnd(region), 1.4);
}

TEST_F(ColmapProgramsTest, FeaturesThatAdaptReachTheLowerSide) {
  EXPECT_LT(ScalesToEnd(Extract({.fine = true})), 1.4);
}

}  // namespace keypose::reconstruct::colmap_programs_test
