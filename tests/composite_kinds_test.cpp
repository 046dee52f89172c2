// The program keypose-composite on films that are stored as studios store them: 16 bits, TIFF,
// colour profiles, keyed frames, numbers that are missing.
#include <gmock/gmock.h>

#include "core/io/pictures/image_levels.h"
#include "tests/generated_shot.h"

namespace keypose::tests::composite_kinds_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// A profile that libpng takes: a header for an RGB monitor, and one tag.
std::string SmallProfile() {
  std::string profile(300, '\0');
  const auto put = [&](std::size_t at, const std::string& bytes) {
    profile.replace(at, bytes.size(), bytes);
  };
  put(2, "\1\x2c"), put(8, "\x02"), put(12, "mntrRGB XYZ "), put(36, "acsp");
  put(68, std::string("\0\0\xf6\xd6\0\1\0\0\0\0\xd3\x2d", 12));
  put(131, "\1"), put(132, "cprt"), put(139, "\x90"), put(143, "\x9c");
  put(144, "text");
  for (int i = 152; i < 299; ++i)
    profile[i] = static_cast<char>(33 + i * i % 89);  // is not packed small
  return profile;
}

class FilmKinds : public GeneratedShot {
 protected:
  /// The film with levels between those of 8 bits.
  static void FilmOf16Bits(const std::string& folder, const std::string& ending) {
    fs::create_directories(folder_ / folder);
    for (const FilmPicture& picture : FilmPictures(folder_ / "film"))
      Deepen(picture.path, folder_ / folder / (picture.path.stem().string() + ending));
  }
  static void Deepen(const fs::path& from, const fs::path& to) {
    ImageF levels = ReadLevels(from);
    for (std::size_t i = 0; i < levels.data.size(); ++i)
      levels.data[i] += static_cast<float>(i * 37 % 257) / 257 - 0.5f;
    WriteLevels(to, levels, 16, SmallProfile());
  }
  /// Of all values, those that 8 bits cannot hold.
  static double Between8Bits(const fs::path& path, int channels = 3) {
    const ImageF levels = ReadLevels(path, channels);
    const auto count = std::count_if(levels.data.begin(), levels.data.end(), [](float level) {
      return std::abs(level - std::round(level)) > 1e-3;
    });
    return static_cast<double>(count) / static_cast<double>(levels.data.size());
  }
};

TEST_F(FilmKinds, SixteenBitsStaySixteen) {
  FilmOf16Bits("deep", ".png");
  Deepen(folder_ / "plate.png", folder_ / "deep_plate.png");
  for (const std::string plate : {"deep", "deep_plate.png"}) {
    const std::map<std::string, std::string> flags{
        {"plate", plate}, {"filmed", "deep"}, {"grain", "false"}, {"report", "deep.json"}};
    const RunResult result = Composite("of_deep", flags);
    ASSERT_EQ(result.exit_code, 0) << result.output;
    for (const char* name : {"0001.png", "layers/0001.png", "plate.png"}) {
      const StoredLevels stored = StoredLevelsOf(folder_ / "of_deep" / name);
      EXPECT_EQ(stored.bits, 16) << name;
      EXPECT_EQ(stored.profile, SmallProfile()) << name;
    }
    EXPECT_GT(Between8Bits(folder_ / "of_deep/0001.png"), 0.9);
    EXPECT_GT(Between8Bits(folder_ / "of_deep/plate.png"), 0.9);
    EXPECT_GT(PsnrOf("of_deep", 1), 28);
    EXPECT_EQ(ReadFile(folder_ / "of_deep/0002.png"), ReadFile(folder_ / "deep/0001.png"));
    const json measured = json::parse(ReadFile(folder_ / "deep.json"))["measurements"];
    EXPECT_EQ(measured["filmed_unchanged"], 3);
    EXPECT_EQ(measured["bits"], 16);
    fs::remove_all(folder_ / "of_deep");
  }
  const RunResult shallow = Composite("of_shallow", {{"plate", "plate.png"}, {"filmed", "deep"}});
  EXPECT_THAT(shallow.output, HasSubstr("the plate plate.png has 8"));
}

TEST_F(FilmKinds, EightBitsStayEight) {
  const RunResult result = Composite("eight", {});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(StoredLevelsOf(folder_ / "eight/0001.png").bits, 8);
  EXPECT_THAT(result.output, AllOf(Not(HasSubstr("have no picture")), Not(HasSubstr("stay ."))));
}

TEST_F(FilmKinds, TiffsMakeASequenceOfTiffs) {
  FilmOf16Bits("tiffs", ".TIF");
  const std::map<std::string, std::string> flags{{"plate", "tiffs"}, {"filmed", "tiffs"}};
  const RunResult result = Composite("of_tiffs", flags);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (int n = 0; n < kPictures; ++n)
    EXPECT_TRUE(fs::exists(folder_ / fmt::format("of_tiffs/{:04}.tif", n))) << n;
  EXPECT_EQ(StoredLevelsOf(folder_ / "of_tiffs/0001.tif").bits, 16);
  std::map<std::string, std::string> png = flags;
  png["format"] = "png";
  const RunResult mixed = Composite("as_png", png);
  EXPECT_TRUE(fs::exists(folder_ / "as_png/0001.png"));
  EXPECT_THAT(mixed.output, HasSubstr("stay .tif and rendered ones are .png"));
}

TEST_F(FilmKinds, AKeyedFilmHasKeyedInBetweens) {
  // What is not the character was keyed out; its colours are still below.
  fs::create_directories(folder_ / "keyed");
  for (const FilmPicture& picture : FilmPictures(folder_ / "film")) {
    const ImageF levels = ReadLevels(picture.path);
    const Image8 matte = ReadImage(folder_ / "truth/shot/mattes" / picture.path.filename(), 1);
    ImageF keyed(levels.width, levels.height, 4);
    for (std::size_t i = 0; i < matte.data.size(); ++i) {
      std::copy_n(&levels.data[3 * i], 3, &keyed.data[4 * i]);
      keyed.data[4 * i + 3] = matte.data[i];
    }
    WriteLevels(folder_ / "keyed" / picture.path.filename(), keyed, 8);
  }
  const RunResult result = Composite("of_keyed", {{"plate", "keyed"}, {"filmed", "keyed"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("3 of 3 filmed frames are transparent in part"));
  const Image8 alpha = ReadAlpha(folder_ / "of_keyed/0001.png"),
               truth = ReadImage(folder_ / "truth/shot/between/0001.png", 1);
  ASSERT_FALSE(alpha.empty());
  int beside = 0, inside = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i)
    if (truth.data[i] == 255) inside += alpha.data[i] < 128;
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < alpha.width; ++x) beside += *alpha.at(x, y) > 0;
  EXPECT_EQ(beside, 0) << "the set was keyed out";
  const auto there = [](std::uint8_t level) { return level > 0; };
  EXPECT_LT(std::count_if(alpha.data.begin(), alpha.data.end(), there),
            1.15 * std::count_if(truth.data.begin(), truth.data.end(), there))
      << "and the shadow with it";
  EXPECT_LT(inside, 0.01 * std::count(truth.data.begin(), truth.data.end(), 255));
  // Colours are as stored: where the character is, they are the truth's.
  const Image8 picture = ReadImage(folder_ / "of_keyed/0001.png", 3),
               frame = ReadImage(folder_ / "truth/shot/frames/0001.png", 3);
  double error = 0, count = 0;
  for (std::size_t i = 0; i < truth.data.size(); ++i)
    if (truth.data[i] == 255 && alpha.data[i] == 255)
      error += std::abs(1.0 * picture.data[3 * i + 1] - frame.data[3 * i + 1]), ++count;
  EXPECT_LT(error / count, 8);
}

TEST_F(FilmKinds, APictureThatIsLostOrRenumberedIsToldOf) {
  fs::create_directories(folder_ / "gap");
  for (int i : {0, 1, 2, 3, 5})
    fs::copy_file(folder_ / fmt::format("film/{:04}.png", std::min(i, 2)),
                  folder_ / fmt::format("gap/take_{}.png", 1001 + i));
  const RunResult result =
      Composite("of_gap", {{"plate", "plate.png"}, {"filmed", "gap"}, {"samples", "1"}});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_THAT(result.output, HasSubstr("1 of the film's numbers have no picture (first after "
                                       "take_1004.png)"));
  EXPECT_THAT(result.output, HasSubstr("located in 0000.png, but frame 0 of this film is "
                                       "take_1001.png"));
}

TEST_F(FilmKinds, AHoldoutsAlphaTellsWhereThePropIs) {
  // A roto with the picture in its colours, as compositing programs write it.
  const ImageF film = ReadLevels(folder_ / "film/0001.png");
  ImageF roto(film.width, film.height, 4);
  for (int y = 0; y < film.height; ++y)
    for (int x = 0; x < film.width; ++x) {
      std::copy_n(film.at(x, y), 3, roto.at(x, y));
      roto.at(x, y)[3] = x >= 150 && x < 200 && y >= 100 ? 255 : 0;
    }
  WriteLevels(folder_ / "roto.png", roto, 8);
  Image8 mask(film.width, film.height, 1);
  for (int y = 100; y < film.height; ++y) std::fill_n(mask.at(150, y), 50, 255);
  WritePng(folder_ / "mask.png", mask);
  std::map<std::string, std::string> flags{{"holdout", "roto.png"}, {"samples", "1"}};
  ASSERT_EQ(Composite("by_roto", flags).exit_code, 0);
  flags["holdout"] = "mask.png";
  ASSERT_EQ(Composite("by_mask", flags).exit_code, 0);
  EXPECT_EQ(ReadFile(folder_ / "by_roto/0001.png"), ReadFile(folder_ / "by_mask/0001.png"));
  for (std::uint8_t& value : mask.data) value = value ? 1 : 0;
  WritePng(folder_ / "ones.png", mask);
  flags["holdout"] = "ones.png";
  const RunResult ones = Composite("by_ones", flags);
  ASSERT_EQ(ones.exit_code, 0);
  EXPECT_NE(ones.output.find("not black and white"), std::string::npos) << ones.output;
  EXPECT_EQ(ReadFile(folder_ / "by_ones/0001.png"), ReadFile(folder_ / "by_mask/0001.png"));
  WritePng(folder_ / "black.png", Image8(film.width, film.height, 1));
  flags["holdout"] = "black.png";
  const RunResult black = Composite("by_black", flags);
  ASSERT_EQ(black.exit_code, 0);
  EXPECT_NE(black.output.find("the holdout is black all over"), std::string::npos) << black.output;
}

}  // namespace keypose::tests::composite_kinds_test
