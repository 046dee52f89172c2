#include "report/evidence/distortion_tables.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/values/errors.h"
#include "report/testing/minimal_report.h"

namespace keypose::report::distortion_tables_test {

using ::testing::HasSubstr;

TEST(ParseDistortion, RatiosAndRelativeValuesGiveTheSameTables) {
  const std::string ratios = R"({"key_frames": [0, 3], "frames": [
    {"t": 0, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1}, {"t": 0.3, "area": 1.01, "volume": 1.02, "linear_area": 0.9, "linear_volume": 0.8},
    {"t": 0.6, "area": 1.03, "volume": 1.02, "linear_area": 0.8, "linear_volume": 0.6}, {"t": 1, "area": 1.5, "volume": 1.5, "linear_area": 1.5, "linear_volume": 1.5}]})";
  const std::string relative = R"({"frames": [
    {"t": 0, "area": 0, "volume": 0, "linear_area": 0, "linear_volume": 0}, {"t": 0.3, "area": 0.01, "volume": 0.02, "linear_area": -0.1, "linear_volume": -0.2},
    {"t": 0.6, "area": 0.03, "volume": 0.02, "linear_area": -0.2, "linear_volume": -0.4}, {"t": 1, "area": 0.5, "volume": 0.5, "linear_area": 0.5, "linear_volume": 0.5}]})";
  for (const std::string& text : {ratios, relative}) {
    const std::vector<FrameDistortion> frames = ParseDistortion(text);
    const DistortionRow area = AreaRow(frames), volume = VolumeRow(frames);
    EXPECT_EQ(area.frames, 2);  // without the keys
    EXPECT_NEAR(area.mean, 0.02, 1e-12);
    EXPECT_NEAR(area.deviation, 0.01, 1e-12);
    EXPECT_NEAR(area.linear_mean, -0.15, 1e-12);
    EXPECT_NEAR(volume.linear_deviation, 0.1, 1e-12);
    EXPECT_NEAR(volume.deviation, 0, 1e-12);
  }
}

TEST(ParseDistortion, ReadsThePathAndCountsAHeldKeyAsNoInBetween) {
  const std::string text = R"({"key_frames": [0, 3], "frames": [
    {"t": 0, "time": 2, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1, "volume_path": 1},
    {"t": 0, "time": 2.1, "area": 1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1, "volume_path": null, "same_as": 0},
    {"t": 0.5, "time": 2.2, "area": 1.1, "volume": 1, "linear_area": 1, "linear_volume": 1, "area_path": 1.2, "volume_path": 1},
    {"t": 1, "time": 2.3, "area": 1.4, "volume": 1, "linear_area": 1, "linear_volume": 1}]})";
  const std::vector<FrameDistortion> frames = ParseDistortion(text);
  EXPECT_EQ(AreaRow(frames).frames, 1);
  EXPECT_NEAR(AreaRow(frames).mean, 0.1, 1e-12);
  EXPECT_EQ(frames[2].time_s, 2.2);
  EXPECT_NEAR(frames[2].area_path, 0.2, 1e-12);
  EXPECT_TRUE(std::isnan(frames[1].volume_path));
  EXPECT_TRUE(std::isnan(frames[3].area_path));
}

TEST(PlayAt, FramesFollowOneAnotherAtTheRateOfTheExport) {
  std::vector<FrameDistortion> frames(3);
  frames[0].time_s = 2, frames[1].time_s = 2.04, frames[2].time_s = 2.08;
  PlayAt(12.5, &frames);
  EXPECT_EQ(frames[0].time_s, 2);
  EXPECT_DOUBLE_EQ(frames[1].time_s, 2.08);
  EXPECT_DOUBLE_EQ(frames[2].time_s, 2.16);
}

TEST(ParseDistortion, NamesTheFrameThatIsNotFinite) {
  const char* text =
      R"({"frames": [{"t": 0, "area": 0, "volume": 0, "linear_area": 0, "linear_volume": 0}, {"t": 1, "area": null}]})";
  try {
    ParseDistortion(text);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("frame 1"));
  }
  EXPECT_THROW(ParseDistortion(R"({"frames": []})"), InputError);
  EXPECT_THROW(ParseDistortion("nothing"), InputError);
}

TEST(PerFace, UniformScalingChangesEveryFaceByItsSquareAndCube) {
  const Mesh small = Tetrahedron(1), large = Tetrahedron(2);
  const FaceDistortion d =
      PerFace(small.points, 1.1 * small.points, large.points, small.faces, 0.5);
  ASSERT_EQ(d.area.size(), 4u);
  for (const double a : d.area) EXPECT_NEAR(a, 0.21, 1e-12);
  for (const double v : d.volume) EXPECT_NEAR(v, 0.331, 1e-12);
  for (const double a : d.linear_area)
    EXPECT_NEAR(a, 1.25, 1e-12);  // half-way to twice the size: 1.5^2 - 1
}

TEST(Histogram, SharesSumToOneAndTheEndsHoldWhatIsBeyond) {
  const std::vector<double> shares = Histogram({-9, -0.9, 0.1, 0.2, 7}, -1, 1, 4);
  EXPECT_EQ(shares, (std::vector<double>{0.4, 0, 0.4, 0.2}));
}

}  // namespace keypose::report::distortion_tables_test
