// `keypose synth photos` with mishaps: each changes only what it should, in the right photographs
// only.
#include "synth/photographs/mishaps.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "synth/commands/photos_command.h"
#include "synth/photographs/truth_files.h"

namespace keypose::synth::mishaps_test {

namespace fs = std::filesystem;

constexpr int kViews = 8;

PhotosCommand CommandTo(const fs::path& folder) {
  PhotosCommand command;
  command.output = folder;
  command.poses = {"rest"};
  command.world.spacing_m = 0.006;
  command.photographer.views = kViews;
  command.photographer.elevations_deg = {20};
  command.photographer.width = 200, command.photographer.height = 150;
  return command;
}

std::string Name(int i) { return "IMG_000" + std::to_string(i + 1) + ".jpg"; }

/// Photographs with mishaps, and the same photographs without.
class MishapsAtTheSet : public ::testing::Test, public TestingFolder {
 protected:
  static void SetUpTestSuite() {
    own_ = std::make_unique<TestingFolder>();
    clean_ = CommandTo(own_->path());
    RunPhotos(clean_, nullptr);
  }
  static void TearDownTestSuite() { own_.reset(); }

  void Spoil(const Mishaps& mishaps) {
    spoilt_ = CommandTo(folder_);
    spoilt_.photographer.mishaps = mishaps;
    EXPECT_EQ(RunPhotos(spoilt_, nullptr), kViews);
  }
  bool SameBytes(int i) const {
    const fs::path photograph = fs::path("photos/rest") / Name(i);
    return ReadFile(clean_.output / photograph) == ReadFile(spoilt_.output / photograph);
  }
  Image8 Mask(const PhotosCommand& of, int i) const {
    return ReadImage(of.output / "truth/rest/masks" / (Name(i) + ".png"), 1);
  }
  Image8 Photograph(const PhotosCommand& of, int i) const {
    return ReadImage(of.output / "photos/rest" / Name(i), 3);
  }
  nlohmann::json World() const {
    return nlohmann::json::parse(ReadFile(spoilt_.output / "truth/rest/world.json")).at("mishaps");
  }

  static inline std::unique_ptr<TestingFolder> own_;
  static inline PhotosCommand clean_, spoilt_;
};

int Count(const Image8& mask) {
  return static_cast<int>(std::count(mask.data.begin(), mask.data.end(), 255));
}

TEST_F(MishapsAtTheSet, StrayPhotographShowsAnotherFigureAndHasNoTrueCamera) {
  Mishaps mishaps;
  mishaps.strays = 1;
  Spoil(mishaps);
  const std::vector<int> strays = StrayViews(mishaps, kViews);
  ASSERT_EQ(strays.size(), 1u);
  for (int i = 0; i < kViews; ++i) EXPECT_EQ(SameBytes(i), i != strays[0]) << i;
  EXPECT_EQ(Count(Mask(spoilt_, strays[0])), 0);
  EXPECT_EQ(ReadTruth(spoilt_.output / "truth/rest").cameras.views.size(), kViews - 1u);
  EXPECT_EQ(World().at("stray").at("photographs"), nlohmann::json::array({Name(strays[0])}));
  EXPECT_EQ(World().at("stray").at("seed"), 2);
}

TEST_F(MishapsAtTheSet, HandCoversPartOfTheFigureAndLeavesTheRestAlone) {
  Mishaps mishaps;
  mishaps.hands = 2;
  Spoil(mishaps);
  const std::vector<int> hands = HandViews(mishaps, kViews);
  ASSERT_EQ(hands.size(), 2u);
  for (int i = 0; i < kViews; ++i) {
    const bool held = i == hands[0] || i == hands[1];
    EXPECT_EQ(SameBytes(i), !held);
    const Image8 before = Mask(clean_, i), after = Mask(spoilt_, i);
    const double left = static_cast<double>(Count(after)) / Count(before);
    if (!held) continue;
    EXPECT_GT(left, 0.5);
    EXPECT_LT(left, 0.97);
    for (std::size_t p = 0; p < before.data.size(); ++p) EXPECT_LE(after.data[p], before.data[p]);
  }
}

TEST_F(MishapsAtTheSet, MovedFigureIsSeenWhereItsTrueCamerasSayAndPhotographsBeforeAreTheSame) {
  Mishaps mishaps;
  ReadMove("0.5:8mm,15deg", &mishaps);
  Spoil(mishaps);
  const Truth truth = ReadTruth(spoilt_.output / "truth/rest");
  const RayScene scene(truth.surface.points, truth.surface.faces);
  for (int i = 0; i < kViews; ++i) {
    EXPECT_EQ(SameBytes(i), i < kViews / 2);
    const Image8 mask = Mask(spoilt_, i);
    const Raster raster = Rasterize(truth.surface, scene, truth.cameras.views[i]);
    int both = 0, either = 0;
    for (std::size_t p = 0; p < mask.data.size(); ++p) {
      const bool seen = raster.face.data[p] >= 0, masked = mask.data[p] > 127;
      both += seen && masked, either += seen || masked;
    }
    EXPECT_GT(both, 0.97 * either)
        << Name(i);  // "half of the pixel covered" and "centre covered" differ at the edge
  }
  EXPECT_NEAR(World().at("moved").at("deg").get<double>(), 15, 1e-9);
  EXPECT_EQ(World().at("moved").at("photographs").size(), 4u);
}

TEST_F(MishapsAtTheSet, FigureBumpedIntoAnotherPoseShowsThatPose) {
  Mishaps mishaps;
  ReadMove("0.75:bow", &mishaps);
  Spoil(mishaps);
  for (int i = 0; i < kViews; ++i) EXPECT_EQ(SameBytes(i), i < 6);
  EXPECT_NE(Mask(clean_, 7).data, Mask(spoilt_, 7).data);
  EXPECT_EQ(World().at("moved").at("pose"), "bow");
}

TEST_F(MishapsAtTheSet, FallenLampShadesAnewAndMovesNothing) {
  Mishaps mishaps;
  mishaps.lamp_falls_after = 0.5;
  Spoil(mishaps);
  for (int i = 0; i < kViews; ++i) {
    EXPECT_EQ(SameBytes(i), i < kViews / 2);
    EXPECT_EQ(Mask(clean_, i).data, Mask(spoilt_, i).data);
    if (i < kViews / 2) continue;
    // The lamp fell to the right: now the figure is lit on the right and no longer on the left.
    const Image8 before = Photograph(clean_, i), after = Photograph(spoilt_, i),
                 mask = Mask(clean_, i);
    double left[2] = {0, 0}, right[2] = {0, 0};
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        if (*mask.at(x, y) < 128) continue;
        double* sums = x < mask.width / 2 ? left : right;
        sums[0] += before.at(x, y)[1], sums[1] += after.at(x, y)[1];
      }
    EXPECT_GT(right[1] / left[1], 1.2 * right[0] / left[0]);
  }
}

TEST(Mishaps, StrayAndHeldPhotographsAreSpreadAndNeverTheSame) {
  Mishaps mishaps;
  mishaps.strays = 3;
  mishaps.hands = 5;
  const std::vector<int> strays = StrayViews(mishaps, 24), hands = HandViews(mishaps, 24);
  EXPECT_EQ(strays, (std::vector<int>{3, 11, 19}));
  ASSERT_EQ(hands.size(), 5u);
  for (std::size_t k = 1; k < hands.size(); ++k) EXPECT_GE(hands[k] - hands[k - 1], 3);
  for (const int i : hands) EXPECT_FALSE(std::binary_search(strays.begin(), strays.end(), i));
}

TEST(Mishaps, MovesAreReadAndOtherFormsAreRefused) {
  Mishaps mishaps;
  ReadMove("0.25:-5mm,7.5deg", &mishaps);
  EXPECT_DOUBLE_EQ(mishaps.moved_from, 0.25);
  EXPECT_DOUBLE_EQ(mishaps.moved_m, -0.005);
  EXPECT_NEAR(mishaps.moved_rad, 0.1308996938995747, 1e-15);
  ReadMove("0.5:bow", &mishaps);
  EXPECT_EQ(mishaps.moved_pose, "bow");
  for (const char* bad :
       {"", "0.5", "0.5:", "half:5mm", "0.5:5", "0.5:5cm", "0.5:5mm,", "0.5:5mm;7deg"}) {
    Mishaps none;
    EXPECT_THROW(ReadMove(bad, &none), UsageError) << bad;
  }
}

TEST(Mishaps, ImpossibleOnesAreNamed) {
  Mishaps mishaps;
  mishaps.strays = 5, mishaps.hands = 4;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
  mishaps = {};
  mishaps.lamp_falls_after = 1.5;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
  mishaps = {};
  mishaps.moved_m = 5;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
}

}  // namespace keypose::synth::mishaps_test
