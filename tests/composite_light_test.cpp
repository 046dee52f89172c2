// The program keypose-composite on plates of film studios: OpenEXR and DPX.
#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "composite/scene/primaries.h"
#include "composite/scene/testing_exr.h"
#include "core/io/pictures/image_levels.h"
#include "core/pictures/srgb.h"
#include "tests/generated_shot.h"

namespace keypose::tests::composite_light_test {

using composite::TestingChannel;
using OIIO::ImageSpec;
using OIIO::TypeDesc;
using ::testing::HasSubstr;

constexpr int kWidth = 384, kHeight = 216;
const std::vector<std::string> kRgb{"R", "G", "B"};
using Light = std::vector<float>;

class LightPlates : public GeneratedShot {
 protected:
  /// The clean plate as light, with values that other pictures do not hold.
  static Light PlateLight() {
    const ImageF levels = ReadLevels(folder_ / "plate.png");
    Light light;
    for (const float level : levels.data)
      light.push_back(static_cast<float>(LinearFromSrgb(level / 255)));
    for (int x = 0; x < 3 * 40; ++x) {
      light[static_cast<std::size_t>(x)] = -0.25f - static_cast<float>(x);
      light[static_cast<std::size_t>(3 * kWidth + x)] = 12.5f * static_cast<float>(x);
    }
    light[3 * 50] = std::numeric_limits<float>::infinity();
    return light;
  }
  template <class Change>
  static void Exr(const std::string& name, const Light& light, const Change& change) {
    fs::create_directories((folder_ / name).parent_path());
    composite::WriteTestingExr(folder_ / name, kWidth, kHeight, kRgb, light, change);
  }
  static void Exr(const std::string& name, const Light& light) {
    Exr(name, light, [](ImageSpec&) {});
  }
  static RunResult OverPlate(const std::string& output, const std::string& plate,
                             std::map<std::string, std::string> other = {}) {
    other["plate"] = plate;
    other.try_emplace("filmed", "");
    return Composite(output, other);
  }
  static Light Channel(const std::string& picture, const std::string& name) {
    return TestingChannel(folder_ / picture, name);
  }
  /// Pixels that neither the character nor its shadow touch, whose light is not the plate's.
  static std::pair<int, int> Untouched(const std::string& picture, const std::string& plate) {
    const Light mask = Channel(picture, "mask.A"), shadow = Channel(picture, "shadow.A");
    int untouched = 0, other = 0;
    for (const std::string& channel : kRgb) {
      const Light light = Channel(picture, channel), before = Channel(plate, channel);
      for (std::size_t i = 0; i < light.size(); ++i) {
        if (mask[i] > 0 || shadow[i] > 0) continue;
        ++untouched;
        other += light[i] != before[i];
      }
    }
    return {untouched, other};
  }
  /// The largest difference, in steps of half, of a picture from its layers over the plate.
  static double FromLayers(const std::string& picture, const std::string& plate) {
    const Light mask = Channel(picture, "mask.A"), shadow = Channel(picture, "shadow.A");
    double most = 0;
    for (const std::string& channel : kRgb) {
      const Light light = Channel(picture, channel), set = Channel(plate, channel),
                  alone = Channel(picture, "character." + channel);
      for (std::size_t i = 0; i < light.size(); ++i) {
        if (!std::isfinite(set[i])) continue;
        const double behind = 1.0 * (1 - mask[i]) * (1 - shadow[i]) * set[i];
        const double size = std::abs(behind) + std::abs(alone[i]) + 1e-3;
        most = std::max(most, std::abs(light[i] - alone[i] - behind) / size * 1024);
      }
    }
    return most;
  }
};

TEST_F(LightPlates, WhatNothingTouchesStaysToTheBit) {
  const auto aces = composite::ChromaticitiesOf(composite::kAcesAp0);
  Exr("aces.exr", PlateLight(), [&](ImageSpec& spec) {
    spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), aces.data());
  });
  Exr("plain.exr", PlateLight());
  for (const std::string name : {"aces", "plain"}) {
    const RunResult result = OverPlate("over_" + name, name + ".exr", {{"lamp", "0.5"}});
    ASSERT_EQ(result.exit_code, 0) << result.output;
    const std::string picture = "over_" + name + "/0002.exr";
    const auto [untouched, other] = Untouched(picture, name + ".exr");
    EXPECT_GT(untouched, kWidth * kHeight);
    EXPECT_EQ(other, 0);
    EXPECT_LT(FromLayers(picture, name + ".exr"), 4) << "each layer is rounded to half";
  }
  // The character's light is the same in either primaries.
  const Eigen::Matrix3d to_aces = composite::LightFrom(composite::kAcesAp0, composite::kRec709);
  std::vector<Light> in_aces, in_plain;
  for (const std::string& c : kRgb) {
    in_aces.push_back(Channel("over_aces/0002.exr", "character." + c));
    in_plain.push_back(Channel("over_plain/0002.exr", "character." + c));
  }
  for (std::size_t i = 0; i < in_aces[0].size(); i += 7) {
    const Eigen::Vector3d expected =
        to_aces * Eigen::Vector3d(in_plain[0][i], in_plain[1][i], in_plain[2][i]);
    for (int c = 0; c < 3; ++c)
      ASSERT_NEAR(in_aces[static_cast<std::size_t>(c)][i], expected[c], 2e-3);
  }
}

TEST_F(LightPlates, TheCharacterIsAsOverAPlateOf8Bits) {
  Exr("plain.exr", PlateLight());
  ASSERT_EQ(OverPlate("as_light", "plain.exr").exit_code, 0);
  ASSERT_EQ(OverPlate("as_levels", "plate.png").exit_code, 0);
  const Image8 levels = ReadImage(folder_ / "as_levels/0002.png", 3);
  int compared = 0;
  for (int c = 0; c < 3; ++c) {
    const Light light = Channel("as_light/0002.exr", kRgb[static_cast<std::size_t>(c)]);
    for (std::size_t i = 3 * kWidth; i < light.size(); ++i, ++compared)
      ASSERT_NEAR(255 * SrgbFromLinear(light[i]), levels.data[3 * i + static_cast<std::size_t>(c)],
                  0.62)
          << i;
  }
  EXPECT_GT(compared, 200000);
}

TEST_F(LightPlates, TheDepthIsTheNearestVertexs) {
  Exr("plain.exr", PlateLight());
  ASSERT_EQ(OverPlate("deep", "plain.exr").exit_code, 0);
  const FilmedShot shot = ReadShot(folder_ / "shot.json");
  const Mesh mesh = ReadMesh(folder_ / "frames/frame_0000.ply");
  double nearest = 1e9;
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Eigen::Vector3d at = mesh.points.row(v);
    nearest = std::min(nearest, (shot.frames[0].camera_from_world * at).z());
  }
  const Light depth = Channel("deep/0000.exr", "depth.Z"),
              mask = Channel("deep/0000.exr", "mask.A");
  const float least = *std::min_element(depth.begin(), depth.end());
  EXPECT_GE(least, nearest - 1e-6);
  EXPECT_LT(least, nearest + 0.002) << "vertices are 4 mm apart";
  for (std::size_t i = 0; i < depth.size(); ++i) ASSERT_EQ(mask[i] > 0, depth[i] < 1e9f) << i;
}

TEST_F(LightPlates, EachPictureHasItsOwnPlateAndNumber) {
  Light light = PlateLight();
  for (int n = 0; n < kPictures + 1; ++n) {
    light[3 * 100] = static_cast<float>(n);
    Exr(fmt::format("set/take3.{}.exr", 1001 + n), light);
  }
  FilmedShot shot = ReadShot(folder_ / "shot.json");
  shot.fps = 24, shot.frames[1].frame = 4;
  WriteFile(folder_ / "shot24.json", ShotText(shot));
  const RunResult result = OverPlate("each", "set", {{"shot", "shot24.json"}, {"blender", "true"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("1 plates lie outside"));
  for (int n = 0; n < kPictures; ++n) {
    const std::string picture = fmt::format("each/{}.exr", 1001 + n);
    ASSERT_TRUE(fs::exists(folder_ / picture)) << picture;
    EXPECT_EQ(Channel(picture, "R")[100], n);
    EXPECT_EQ(Untouched(picture, fmt::format("set/take3.{}.exr", 1001 + n)).second, 0);
  }
  const fs::path scene = folder_ / "each/blender";
  EXPECT_TRUE(fs::exists(scene / "film_0000.jpg")) << "Blender's frame 0";
  EXPECT_FALSE(fs::exists(scene / "film_1001.jpg"));
  EXPECT_EQ(json::parse(ReadFile(scene / "shot.json"))["film"], "film_0000.jpg");
  fs::remove(folder_ / "set/take3.1003.exr");
  const RunResult lacking = OverPlate("lacking", "set", {{"shot", "shot24.json"}});
  EXPECT_EQ(lacking.exit_code, 3);
  EXPECT_THAT(lacking.output, HasSubstr("frame 2 of the animation has no plate"));
}

TEST_F(LightPlates, OverscanMovesThePictureAndKeepsItsWindow) {
  constexpr int kMore = 16;
  Exr("plain.exr", PlateLight());
  const Light light(static_cast<std::size_t>(3 * (kWidth + 2 * kMore) * (kHeight + 2 * kMore)),
                    0.25f);
  composite::WriteTestingExr(folder_ / "overscan.exr", kWidth + 2 * kMore, kHeight + 2 * kMore,
                             kRgb, light, [](ImageSpec& spec) {
                               spec.x = spec.y = -kMore;
                               spec.full_width = kWidth, spec.full_height = kHeight;
                             });
  ASSERT_EQ(OverPlate("whole", "plain.exr").exit_code, 0);
  const RunResult result = OverPlate("wide", "overscan.exr");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const Light whole = Channel("whole/0000.exr", "mask.A"),
              wide = Channel("wide/0000.exr", "mask.A");
  double most = 0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      most = std::max(
          most,
          std::abs(1.0 * whole[static_cast<std::size_t>(y * kWidth + x)] -
                   wide[static_cast<std::size_t>((y + kMore) * (kWidth + 2 * kMore) + x + kMore)]));
  EXPECT_LE(most, 0.35) << "a ray or two of nine, by rounding";
  const auto input = OIIO::ImageInput::open((folder_ / "wide/0000.exr").string());
  EXPECT_EQ(input->spec().x, -kMore);
  EXPECT_EQ(input->spec().width, kWidth + 2 * kMore);
  EXPECT_EQ(input->spec().full_width, kWidth);
}

TEST_F(LightPlates, ADpxOfLogIsLight) {
  ImageSpec spec(kWidth, kHeight, 3, TypeDesc::UINT16);
  spec.attribute("oiio:BitsPerSample", 10);
  spec.attribute("dpx:Transfer", "Logarithmic");
  const Light codes(static_cast<std::size_t>(3 * kWidth * kHeight), 800 / 1023.f);
  const std::string path = (folder_ / "log.dpx").string();
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output->open(path, spec) && output->write_image(TypeDesc::FLOAT, codes.data()) &&
              output->close());
  const RunResult result = OverPlate("of_log", "log.dpx");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("'Logarithmic', as its header states"));
  EXPECT_NEAR(Channel("of_log/0000.exr", "G")[10], 2.43279, 2e-3) << "10^((800 - 685) / 300)";
  ASSERT_EQ(OverPlate("stated", "log.dpx", {{"plate_colorspace", "arri-logc3"}}).exit_code, 0);
  EXPECT_NEAR(Channel("stated/0000.exr", "G")[10], 7.22174, 1e-2)
      << "10^((0.78201 - 0.385537) / 0.24719), less 0.052272, over 5.555556";
}

TEST_F(LightPlates, AFilmOfLightTeachesAndItsFramesStay) {
  fs::create_directories(folder_ / "film_of_light");
  int number = 1001;
  for (const FilmPicture& picture : FilmPictures(folder_ / "film")) {
    Light light;
    for (const float level : ReadLevels(picture.path).data)
      light.push_back(4 * static_cast<float>(LinearFromSrgb(level / 255)));  // far above white
    Exr(fmt::format("film_of_light/{}.exr", number++), light);
  }
  const RunResult result = Composite(
      "taught",
      {{"plate", "film_of_light"}, {"filmed", "film_of_light"}, {"report", "taught.json"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(ReadFile(folder_ / "taught/1003.exr"), ReadFile(folder_ / "film_of_light/1002.exr"));
  const json measured = json::parse(ReadFile(folder_ / "taught.json"))["measurements"];
  EXPECT_EQ(measured["filmed_unchanged"], 3);
  EXPECT_EQ(measured["bits"], 16);
  EXPECT_GT(measured["worst_join_psnr_db"], 28);
  // The in-between is as the film is: four times the light of the truth.
  const ImageF truth = ReadLevels(folder_ / "truth/shot/frames/0001.png");
  const Light green = Channel("taught/1002.exr", "G");
  double sum = 0, sum_truth = 0;
  for (std::size_t i = 0; i < green.size(); ++i) {
    sum += green[i];
    sum_truth += 4 * LinearFromSrgb(truth.data[3 * i + 1] / 255);
  }
  EXPECT_NEAR(sum / sum_truth, 1, 0.02);
}

TEST_F(LightPlates, WhatDoesNotGoTogetherIsNamed) {
  Exr("plain.exr", PlateLight());
  const RunResult mixed = Composite("mixed", {{"plate", "plain.exr"}, {"filmed", "film"}});
  EXPECT_EQ(mixed.exit_code, 3);
  EXPECT_THAT(mixed.output, HasSubstr("one of plate and film is OpenEXR or DPX"));
  const RunResult png = OverPlate("png", "plain.exr", {{"format", "png"}});
  EXPECT_EQ(png.exit_code, 2);
  EXPECT_THAT(png.output, HasSubstr("leave `format` out"));
  const RunResult space = OverPlate("space", "plate.png", {{"plate_colorspace", "ACEScg"}});
  EXPECT_EQ(space.exit_code, 2);
  EXPECT_THAT(space.output, HasSubstr("are for OpenEXR and DPX plates"));
}

}  // namespace keypose::tests::composite_light_test
