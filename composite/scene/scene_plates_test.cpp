#include "composite/scene/scene_plates.h"

#include <OpenImageIO/deepdata.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "composite/scene/layered_exr.h"
#include "composite/scene/testing_exr.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::composite::scene_plates_test {

using OIIO::ImageSpec;
using OIIO::TypeDesc;
using ::testing::HasSubstr;

const std::vector<std::string> kRgb{"R", "G", "B"};

/// Values that 8 bits and 0 to 1 do not hold.
std::vector<float> Values(int count) {
  std::vector<float> values;
  for (int i = 0; i < count; ++i)
    values.push_back(std::ldexp(static_cast<float>(i % 7) - 2.0f, i % 11 - 4));
  return values;
}

class ScenePlatesTest : public ::testing::Test, protected TestingFolder {
 protected:
  template <class Change>
  fs::path Exr(const std::string& name, const Change& change,
               const std::vector<std::string>& channels = kRgb) const {
    const fs::path path = folder_ / name;
    WriteTestingExr(path, 6, 4, channels, Values(24 * static_cast<int>(channels.size())), change);
    return path;
  }
  fs::path Plain(const std::string& name) const {
    return Exr(name, [](ImageSpec&) {});
  }
  static std::string Fault(const fs::path& path) {
    try {
      ScenePlates({}, path).Light(path);
    } catch (const InputError& fault) {
      return fault.what();
    }
    return "none";
  }
};

TEST_F(ScenePlatesTest, LinearLightIsAsStored) {
  const fs::path path = Plain("p.exr");
  EXPECT_EQ(ScenePlates({}, path).Light(path).data, Values(72));
}

TEST_F(ScenePlatesTest, ExposureIsWholeStopsAndWrittenLightIsAsRead) {
  const fs::path path = Plain("p.exr"), out = folder_ / "out.exr";
  ScenePlates plates({}, path);
  plates.ExposeFor(path);
  EXPECT_EQ(plates.exposure(), 1.0f / 256) << "of 24 pixels all but one have 128 at most";
  const ImageF light = plates.Light(path);
  EXPECT_EQ(light.data[5], Values(72)[5] / 256);
  WriteLayers(out, {light, {}, {}, {}, {}}, plates);
  const std::vector<float> green = TestingChannel(out, "G"), values = Values(72);
  for (std::size_t i = 0; i < green.size(); ++i) EXPECT_EQ(green[i], values[3 * i + 1]);
}

TEST_F(ScenePlatesTest, ColoursAreFoundAmongOtherChannels) {
  const fs::path path = Exr("p.exr", [](ImageSpec&) {}, {"A", "B", "G", "R", "Z", "id.X"});
  const ScenePlates plates({}, path);
  EXPECT_EQ(plates.others(), 2);
  const std::vector<float> values = Values(24 * 6);
  const ImageF light = plates.Light(path), alpha = plates.Alpha(path);
  EXPECT_EQ(light.at(2, 1)[0], values[8 * 6 + 3]);
  EXPECT_EQ(light.at(2, 1)[2], values[8 * 6 + 1]);
  EXPECT_EQ(*alpha.at(2, 1), values[8 * 6]);
}

TEST_F(ScenePlatesTest, TheWindowMovesTheCamera) {
  const fs::path path = Exr("p.exr", [](ImageSpec& spec) {
    spec.x = -1, spec.y = 2, spec.full_width = 8, spec.full_height = 9;
  });
  const ScenePlates plates({}, path);
  const Camera camera = plates.OfWindow({8, 9, 10, 10, 4, 4.5});
  EXPECT_EQ(camera.width, 6);
  EXPECT_EQ(camera.height, 4);
  EXPECT_EQ(camera.cx, 5);
  EXPECT_EQ(camera.cy, 2.5);
  EXPECT_THROW(plates.OfWindow({6, 4, 10, 10, 3, 2}), InputError);
  const Image8 whole = plates.ShownWhole(path);
  EXPECT_EQ(whole.width, 8);
  EXPECT_EQ(whole.height, 9);
  Image8 holdout(8, 9, 1);
  *holdout.at(0, 2) = 200;
  const Image8 part = InWindow(holdout, plates.window());
  EXPECT_EQ(*part.at(1, 0), 200);
  EXPECT_EQ(std::count(part.data.begin(), part.data.end(), 200), 1);
}

TEST_F(ScenePlatesTest, WhatIsLookedAtIsSrgbWithSoftHighlights) {
  const ScenePlates plates({}, Plain("p.exr"));
  ImageF light(1, 1, 3);
  light.data = {0.214041f, -1, 1};
  const ImageF shown = plates.Shown(light);
  EXPECT_NEAR(shown.data[0], 127.5, 0.01);
  EXPECT_EQ(shown.data[1], 0);
  EXPECT_NEAR(shown.data[2], 246.57, 0.01) << "0.8 + 0.2 (1 - 1 / e)";
  light.data = {std::numeric_limits<float>::infinity(), std::nanf(""), 1000};
  EXPECT_EQ(plates.Shown(light).data, (std::vector<float>{255, 0, 255}));
}

TEST_F(ScenePlatesTest, WhatIsNotReadIsNamed) {
  EXPECT_THAT(Fault(Exr("a.exr", [](ImageSpec& s) { s.attribute("PixelAspectRatio", 2.0f); })),
              HasSubstr("not square (pixel aspect ratio 2"));
  EXPECT_THAT(Fault(Exr("n.exr", [](ImageSpec& s) { s.set_format(TypeDesc::UINT32); })),
              HasSubstr("whole numbers"));
  EXPECT_THAT(Fault(Exr("y.exr", [](ImageSpec&) {}, {"Y"})), HasSubstr("no channels R, G and B"));
  const fs::path whole = Plain("w.exr"), cut = folder_ / "cut.exr";
  fs::copy_file(whole, cut);
  fs::resize_file(cut, fs::file_size(cut) - 40);
  EXPECT_THAT(Fault(cut), HasSubstr("damaged or cut off"));
  EXPECT_THAT(Fault(Put("text.exr", "no picture")), HasSubstr("neither an OpenEXR nor a DPX"));
}

TEST_F(ScenePlatesTest, PartsAndDeepPixelsAreNamed) {
  ImageSpec spec(6, 4, 3, TypeDesc::HALF);
  const std::string parts = (folder_ / "parts.exr").string(), deep = (folder_ / "d.exr").string();
  const std::vector<ImageSpec> specs{spec, spec};
  const auto output = OIIO::ImageOutput::create(parts);
  ASSERT_TRUE(output->open(parts, 2, specs.data()));
  for (int part = 0; part < 2; ++part) {
    if (part > 0) {
      ASSERT_TRUE(output->open(parts, spec, OIIO::ImageOutput::AppendSubimage));
    }
    ASSERT_TRUE(output->write_image(TypeDesc::FLOAT, Values(72).data()));
  }
  ASSERT_TRUE(output->close());
  EXPECT_THAT(Fault(parts), HasSubstr("several parts"));
  spec.nchannels = 4, spec.channelnames = {"R", "G", "B", "A"}, spec.deep = true;
  OIIO::DeepData data;
  data.init(spec);
  for (int i = 0; i < 24; ++i) data.set_samples(i, 1);
  const auto writer = OIIO::ImageOutput::create(deep);
  ASSERT_TRUE(writer->open(deep, spec) && writer->write_deep_image(data) && writer->close())
      << writer->geterror();
  EXPECT_THAT(Fault(deep), HasSubstr("deep pixels"));
}

TEST_F(ScenePlatesTest, AllPicturesAreOfOneKind) {
  const ScenePlates plates({}, Plain("p.exr"));
  const auto fault = [&](const fs::path& path) -> std::string {
    try {
      plates.Light(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  };
  EXPECT_THAT(fault(Exr("w.exr", [](ImageSpec& s) { s.x = 1; })), HasSubstr("one window"));
  const auto aces = ChromaticitiesOf(kAcesAp0);
  EXPECT_THAT(fault(Exr("c.exr",
                        [&](ImageSpec& s) {
                          s.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), aces.data());
                        })),
              HasSubstr("states other colours"));
}

TEST_F(ScenePlatesTest, ADpxOfTenBitsGivesItsCodeValues) {
  const fs::path path = folder_ / "p.dpx";
  ImageSpec spec(8, 2, 3, TypeDesc::UINT16);
  spec.attribute("oiio:BitsPerSample", 10);
  spec.attribute("dpx:Transfer", "Logarithmic");
  std::vector<float> codes;
  for (int i = 0; i < 48; ++i) codes.push_back(static_cast<float>(21 * i + 3) / 1023);
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output->open(path.string(), spec) &&
              output->write_image(TypeDesc::FLOAT, codes.data()) && output->close());
  const ScenePlates plates({}, path);
  const ImageF light = plates.Light(path);
  const double black = std::pow(10, -590 * 0.002 / 0.6);
  for (int i = 0; i < 48; ++i) {
    const double code = 21 * i + 3,
                 expected = (std::pow(10, (code - 685) * 0.002 / 0.6) - black) / (1 - black);
    EXPECT_NEAR(light.data[static_cast<std::size_t>(i)], expected, 2e-4 * std::abs(expected) + 1e-6)
        << code;
  }
}

TEST_F(ScenePlatesTest, LayersAreWrittenWithTheirNamesAndTheWindow) {
  const auto aces = ChromaticitiesOf(kAcesAp0);
  const fs::path path = Exr("p.exr", [&](ImageSpec& spec) {
    spec.x = -1, spec.full_width = 4, spec.full_height = 4;
    spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), aces.data());
  });
  const ScenePlates plates({}, path);
  SceneLayers layers{
      plates.Light(path), {}, ImageF(6, 4, 4, 0.5f), ImageF(6, 4, 1, 0.25f), ImageF(6, 4, 1, 0.1f)};
  const fs::path out = folder_ / "out.exr";
  WriteLayers(out, layers, plates);
  const auto input = OIIO::ImageInput::open(out.string());
  const ImageSpec spec = input->spec();
  EXPECT_EQ(spec.channelnames, (std::vector<std::string>{
                                   "R", "G", "B", "A", "character.R", "character.G", "character.B",
                                   "character.A", "depth.Z", "mask.A", "shadow.A"}));
  EXPECT_EQ(spec.channelformat(0), TypeDesc::HALF);
  EXPECT_EQ(spec.channelformat(8), TypeDesc::FLOAT);
  EXPECT_EQ(spec.x, -1);
  EXPECT_EQ(spec.full_width, 4);
  std::array<float, 8> stated{};
  ASSERT_TRUE(spec.getattribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), stated.data()));
  EXPECT_EQ(stated, aces);
  const std::vector<float> red = TestingChannel(out, "R"), values = Values(72);
  for (std::size_t i = 0; i < red.size(); ++i) EXPECT_EQ(red[i], values[3 * i]);
  EXPECT_EQ(TestingChannel(out, "A")[5], 1);
  EXPECT_EQ(TestingChannel(out, "depth.Z")[5], 0.1f) << "which half does not hold";
}

}  // namespace keypose::composite::scene_plates_test
