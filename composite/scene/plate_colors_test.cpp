#include "composite/scene/plate_colors.h"

#include <gmock/gmock.h>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::composite::plate_colors_test {

using ::testing::HasSubstr;

LightFile Exr() {
  LightFile file;
  file.exr = true;
  return file;
}

LightFile Dpx(const std::string& transfer) {
  LightFile file;
  file.transfer = transfer, file.bits = 10;
  return file;
}

/// Light of a grey value.
std::array<float, 3> LightOf(const PlateColors& colors, float value) {
  ImageF picture(1, 1, 3, value);
  colors.Decode(&picture);
  return {picture.data[0], picture.data[1], picture.data[2]};
}

void ExpectGrey(const std::string& name, double code, double light, double within) {
  const auto found = LightOf(PlateColors({name, {}}, "p.exr", Exr()), static_cast<float>(code));
  for (const float value : found) EXPECT_NEAR(value, light, within) << name;
}

std::string FaultOf(const StatedColors& stated) {
  try {
    PlateColors(stated, "p.exr", Exr());
  } catch (const Error& fault) {
    return fault.what();
  }
  return "none";
}

TEST(Primaries, MatricesAreThePublishedOnes) {
  // Academy, S-2014-004, and OpenColorIO's ACES configuration: AP0 to Rec.709, by Bradford.
  Eigen::Matrix3d ap0;
  ap0 << 2.52169, -1.13413, -0.38756, -0.27648, 1.37272, -0.09624, -0.01538, -0.15298, 1.16835;
  EXPECT_LT((LightFrom(kRec709, kAcesAp0) - ap0).cwiseAbs().maxCoeff(), 2e-5);
  Eigen::Matrix3d ap1;
  ap1 << 1.70505, -0.62179, -0.08326, -0.13026, 1.14080, -0.01055, -0.02400, -0.12897, 1.15297;
  EXPECT_LT((LightFrom(kRec709, kAcesAp1) - ap1).cwiseAbs().maxCoeff(), 2e-5);
  const std::array<float, 8> on_one_line{0, 0, 1, 1, 2, 2, 0.3f, 0.3f};
  EXPECT_FALSE(PrimariesOf(on_one_line));
}

TEST(Primaries, AMatrixThatDoesNotAdaptHasAWhiteOfItsOwn) {
  const Eigen::Matrix3d twice_red = Eigen::Vector3d(2, 1, 1).asDiagonal();
  const Primaries found = PrimariesOf(twice_red);
  EXPECT_LT((found.red - kRec709.red).norm(), 1e-9);
  EXPECT_LT((found.blue - kRec709.blue).norm(), 1e-9);
  // Half of Rec.709's red with its green and blue: XYZ 0.74426, 0.89368, 1.07939.
  EXPECT_NEAR(found.white.x(), 0.273894, 1e-5);
  EXPECT_NEAR(found.white.y(), 0.328881, 1e-5);
  const Primaries adapted{{0.68, 0.32}, {0.265, 0.69}, {0.15, 0.06}, {0.314, 0.351}};
  const Primaries of_light = PrimariesOf(LightFrom(adapted, kRec709));
  EXPECT_LT((of_light.white - kRec709.white).norm(), 1e-9) << "Rec.709's white is white";
}

TEST(PlateColors, LogsGiveTheirMakersGrey) {
  ExpectGrey("arri-logc3", 400 / 1023.0, 0.18, 3e-4);
  ExpectGrey("sony-slog3", 420 / 1023.0, 0.18, 3e-4);
  ExpectGrey("S-Log3", 420 / 1023.0, 0.18, 3e-4);
  ExpectGrey("panasonic-vlog", 433 / 1023.0, 0.18, 3e-4);
  ExpectGrey("red-log3g10", 1 / 3.0, 0.18, 3e-4);
  ExpectGrey("canon-clog3", 351 / 1023.0, 0.18, 1e-3);
  ExpectGrey("ACEScct", 0.4135884, 0.18, 3e-4);
  ExpectGrey("ARRI_ALEXA-LOGC-EI800-AWG_to_ACES2065-1", 400 / 1023.0, 0.18, 3e-4);
  ExpectGrey("cineon", 685 / 1023.0, 1, 1e-5);
  ExpectGrey("cineon", 95 / 1023.0, 0, 1e-6);
  ExpectGrey("cineon", 445 / 1023.0, 0.149303, 1e-5);
  ExpectGrey("srgb", 0.5, 0.214041, 1e-5);
  EXPECT_GT(LightOf(PlateColors({"arri-logc3", {}}, "p.exr", Exr()), 0.9f)[0], 20)
      << "highlights are not clipped";
  EXPECT_EQ(PlateColors({"arri-logc3", {}}, "p.exr", Exr()).primaries().green, kAcesAp0.green);
  EXPECT_THROW(PlateColors({"arri-logc4", {}}, "p.exr", Exr()), UsageError);
}

TEST(PlateColors, AShortNameThatSeveralLogsHaveIsRefused) {
  EXPECT_THAT(PlateColors({"C-Log3", {}}, "p.exr", Exr()).meaning(), HasSubstr("CANON_CLOG3"));
  EXPECT_THAT(PlateColors({"cine-venice", {}}, "p.exr", Exr()).meaning(),
              HasSubstr("SGAMUT3.CINE-VENICE"));
  EXPECT_THROW(PlateColors({"Log3", {}}, "p.exr", Exr()), UsageError);
  EXPECT_THAT(FaultOf({"Log3", {}}), HasSubstr("'Log3' may be sony-slog3 or canon-clog3;"));
  EXPECT_THAT(FaultOf({"venice", {}}), HasSubstr("sony-slog3-venice or sony-slog3-cine-venice;"));
}

TEST(PlateColors, AnExrIsByItsChromaticities) {
  LightFile file = Exr();
  const PlateColors plain({}, "p.exr", file);
  EXPECT_TRUE(plain.light_from_rec709().isIdentity());
  file.chromaticities = ChromaticitiesOf(kAcesAp1);
  const PlateColors aces({}, "p.exr", file);
  EXPECT_THAT(aces.meaning(), HasSubstr("ACEScg"));
  ImageF white(1, 1, 3, 1.0f), red(1, 1, 3);
  red.data[0] = 1;
  aces.TakeFromRec709(&white), aces.TakeFromRec709(&red);
  for (const float value : white.data) EXPECT_NEAR(value, 1, 1e-5) << "white is white";
  EXPECT_NEAR(red.data[0], 0.613097, 1e-4);
  EXPECT_NEAR(red.data[1], 0.070194, 1e-4);
  const auto light = LightOf(aces, -3.5f);
  EXPECT_EQ(light[1], -3.5f) << "linear light stays as it is";
}

TEST(PlateColors, ADpxIsAsItsHeaderStates) {
  EXPECT_NEAR(LightOf(PlateColors({}, "p.dpx", Dpx("Logarithmic")), 685 / 1023.f)[0], 1, 1e-5);
  EXPECT_NEAR(LightOf(PlateColors({}, "p.dpx", Dpx("Printing density")), 95 / 1023.f)[0], 0, 1e-6);
  EXPECT_EQ(LightOf(PlateColors({}, "p.dpx", Dpx("Linear")), 0.25f)[0], 0.25f);
  EXPECT_NEAR(LightOf(PlateColors({}, "p.dpx", Dpx("ITU-R 709-4")), 0.5f)[0], 0.259589, 1e-5);
  const PlateColors unsaid({}, "p.dpx", Dpx("Undefined"));
  EXPECT_NEAR(LightOf(unsaid, 685 / 1023.f)[0], 1, 1e-5);
  EXPECT_THAT(unsaid.doubt(), HasSubstr("does not state"));
  LightFile of_ffmpeg = Dpx("Linear");
  of_ffmpeg.writer = "Lavc59.37.100";
  EXPECT_THAT(PlateColors({}, "p.dpx", of_ffmpeg).doubt(), HasSubstr("ffmpeg"));
  EXPECT_THROW(PlateColors({}, "p.dpx", Dpx("Z depth linear")), InputError);
}

constexpr const char* kConfig = R"(ocio_profile_version: 2
search_path: ""
strictparsing: true
luma: [0.2126, 0.7152, 0.0722]
roles:
  %ROLE%
  scene_linear: ACEScg
  default: Raw
displays:
  d:
    - !<View> {name: v, colorspace: Raw}
active_displays: []
active_views: []
colorspaces:
  - !<ColorSpace>
    name: AP0
  - !<ColorSpace>
    name: ACEScg
    to_reference: !<BuiltinTransform> {style: ACEScg_to_ACES2065-1}
  - !<ColorSpace>
    name: Show log
    to_reference: !<BuiltinTransform> {style: ACEScct_to_ACES2065-1}
  - !<ColorSpace>
    name: Raw
    isdata: true
)";

std::string ConfigWith(const std::string& role) {
  std::string text = kConfig;
  return text.replace(text.find("%ROLE%"), 6, role);
}

TEST(PlateColors, APersonsConfigurationSaysWhatIsWhat) {
  const TestingFolder folder;
  const fs::path config = folder.Put("show.ocio", ConfigWith("aces_interchange: AP0"));
  const PlateColors log({"Show log", config}, "p.exr", Exr());
  EXPECT_NEAR(LightOf(log, 0.4135884f)[1], 0.18, 3e-4);
  EXPECT_EQ(log.primaries().green, kAcesAp1.green) << "its scene_linear";
  const PlateColors linear({"AP0", config}, "p.exr", Exr());
  EXPECT_EQ(linear.primaries().blue, kAcesAp0.blue) << "linear spaces stay what they are";
  EXPECT_EQ(LightOf(linear, 1234.5f)[2], 1234.5f);
  EXPECT_THAT(FaultOf({"Show lgo", config}), HasSubstr("did you mean 'Show log'"));
  EXPECT_THAT(FaultOf({"", config}), HasSubstr("'Raw' of"));
  const fs::path alone = folder.Put("alone.ocio", ConfigWith("rendering: ACEScg"));
  EXPECT_THAT(FaultOf({"Show log", alone}), HasSubstr("aces_interchange"));
  const fs::path broken = folder.Put("broken.ocio", "ocio_profile_version: 7\n");
  EXPECT_THAT(FaultOf({"Show log", broken}), HasSubstr("no OpenColorIO configuration"));
}

TEST(PlateColors, AFaultInAConfigurationsMathIsNamed) {
  const TestingFolder folder;
  std::string text = ConfigWith("aces_interchange: AP0");
  text += R"(  - !<ColorSpace>
    name: Flat
    from_reference: !<CDLTransform> {slope: [0, 0, 0]}
)";
  const fs::path config = folder.Put("flat.ocio", text);
  EXPECT_THROW(PlateColors({"Flat", config}, "p.exr", Exr()), InputError);
  EXPECT_THAT(FaultOf({"Flat", config}), HasSubstr("flat.ocio: Singular Matrix"));
}

}  // namespace keypose::composite::plate_colors_test
