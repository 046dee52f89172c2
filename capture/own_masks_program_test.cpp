// keypose-capture with masks as other programs write them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "capture/pictures/own_masks.h"
#include "capture/testing/capture_program.h"
#include "capture/testing/test_images.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"
#include "core/testing/paths.h"

namespace keypose::capture::own_masks_program_test {

using ::testing::HasSubstr;
using ::testing::Not;

Image8 TruthOf(int i) { return MakeTestPhoto(i, 180, 120, TestWall::kDark).truth; }

class OwnMasks : public CaptureProgram {
 protected:
  static std::string Stem(int i) { return "p" + std::to_string(10 + i); }
  /// Eight photographs with a mask each.
  /// @param change  of the true mask, upright as the test draws it
  void Write(const std::function<Image8(Image8)>& change) {
    fs::create_directories(photos / "masks");
    WritePhotos(8);
    for (int i = 0; i < 8; ++i)
      WriteImage(photos / "masks" / (Stem(i) + ".jpg.png"), change(TruthOf(i)));
  }
  /// How a photograph of WriteTurned is stored. Landscapes and portraits are not mixed: capture
  /// turns the fewer of them.
  static int OrientationOf(int i, bool portraits) {
    return portraits ? (i % 2 ? 6 : 8) : (i % 2 ? 3 : 1);
  }
  /// Eight photographs that are stored in two ways, in turn, with a mask each.
  /// @param upright  the masks are turned as the photographs are once EXIF is heeded
  void WriteTurned(bool portraits, bool upright) {
    fs::create_directories(photos / "masks");
    for (int i = 0; i < 8; ++i) {
      ExifToWrite exif;
      exif.orientation = OrientationOf(i, portraits);
      WriteImage(photos / (Stem(i) + ".jpg"), MakeTestPhoto(i, 180, 120, TestWall::kDark).image, 95,
                 &exif);
      WriteImage(photos / "masks" / (Stem(i) + ".jpg.png"),
                 upright ? Oriented(TruthOf(i), exif.orientation) : TruthOf(i));
    }
  }
  /// Expects that each mask written is the true one.
  /// @param orientation  per photograph, as EXIF counts; upright without
  void ExpectTruth(const std::function<int(int)>& orientation = {}, int most_differing = 0) {
    const Outcome outcome = Run();
    ASSERT_EQ(outcome.code, 0) << outcome.output;
    output = outcome.output;
    for (int i = 0; i < 8; ++i) {
      const Image8 mask = ReadImage(images / ("masks/" + Stem(i) + ".jpg.png"), 1),
                   truth = Oriented(TruthOf(i), orientation ? orientation(i) : 1);
      ASSERT_EQ(mask.width, truth.width);
      int differing = 0;
      for (std::size_t p = 0; p < mask.data.size(); ++p) differing += mask.data[p] != truth.data[p];
      EXPECT_LE(differing, most_differing) << i;
    }
  }
  std::string output;
};

TEST_F(OwnMasks, OfLevelsZeroAndOneAreUsed) {
  Write([](Image8 mask) {
    for (std::uint8_t& m : mask.data) m = m ? 1 : 0;
    return mask;
  });
  ExpectTruth();
  EXPECT_THAT(output, Not(HasSubstr("these masks")));
}

TEST_F(OwnMasks, WhiteRoundTheFigureIsTurnedRoundAndSaid) {
  Write(InvertedMatte);
  ExpectTruth();
  EXPECT_THAT(output, HasSubstr("white where the figure is not"));
}

TEST_F(OwnMasks, OfHalfTheSizeAreResizedAndSaid) {
  Write([](const Image8& mask) { return ResizedMask(mask, 90, 60); });
  ExpectTruth({}, 180 * 120 / 100);
  EXPECT_THAT(output, HasSubstr("another size than their photographs, and were resized"));
}

TEST_F(OwnMasks, AsStoredAreTurnedAsExifSays) {
  for (const bool portraits : {false, true}) {
    WriteTurned(portraits, false);
    ExpectTruth([&](int i) { return OrientationOf(i, portraits); });
    EXPECT_THAT(output, HasSubstr("lie as their photographs are stored")) << portraits;
    fs::remove_all(images);
  }
}

TEST_F(OwnMasks, UprightOnesStayForPhotographsThatAreStoredTurned) {
  for (const bool portraits : {false, true}) {
    WriteTurned(portraits, true);
    ExpectTruth([&](int i) { return OrientationOf(i, portraits); });
    EXPECT_THAT(output, Not(HasSubstr("these masks"))) << portraits;
    fs::remove_all(images);
  }
}

TEST_F(OwnMasks, ByOtherProgramsNamesAreFound) {
  Write([](const Image8& mask) { return mask; });
  int i = 0;
  for (const auto& [before, after] : {std::pair{"", ""},
                                      {"", "_mask"},
                                      {"mask_", ""},
                                      {"", ".JPG"},
                                      {"", ".jpg.mask"},
                                      {"", "-matte"},
                                      {"", ".out"}}) {
    const fs::path masks = photos / "masks";
    fs::rename(masks / (Stem(i) + ".jpg.png"), masks / (before + Stem(i) + after + ".png"));
    ++i;
  }
  ExpectTruth();
}

TEST_F(OwnMasks, BlackOnesAmongOthersAreNamedAndNotUsed) {
  Write([](const Image8& mask) { return mask; });
  WriteImage(photos / "masks/p12.jpg.png", Image8(180, 120, 1));
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("these masks are black"));
  EXPECT_THAT(outcome.output, HasSubstr("p12.jpg.png"));
  EXPECT_EQ(SideOf(ReadImage(images / "masks/p12.jpg.png", 1)), MaskSide::kFigure);
}

TEST_F(OwnMasks, LabelsAreRefusedWithEachMaskNamed) {
  Write([](Image8 mask) {
    for (std::size_t p = 0; p < mask.data.size(); ++p)
      mask.data[p] = static_cast<std::uint8_t>(mask.data[p] ? 1 : p % 2 * 2);
    return mask;
  });
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("8 files have a mask that cannot be used"));
  EXPECT_THAT(outcome.output, HasSubstr("p17.jpg.png has the levels 0, 1, 2"));
  EXPECT_FALSE(fs::exists(images));
}

/// Larger photographs that the project has not; the cases above show the same on drawn ones.
class OwnMasksFull : public OwnMasks {};

TEST_F(OwnMasksFull, OfPublicReportsAreTheSameHoweverTheyAreWritten) {
  const fs::path folder = DataFolder() / "reports/25_mask_kinds";
  if (!fs::exists(folder)) GTEST_SKIP() << "the data of public reports is not here";
  const auto masks = [&](const std::string& kind) {
    const fs::path to = root / kind;
    const std::string command = BinFolder() + "/keypose-capture --photos " +
                                (folder / kind).string() + " --images " + to.string() +
                                " > /dev/null 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << kind;
    std::vector<std::vector<std::uint8_t>> read;
    for (int i = 0; i < 10; ++i)
      read.push_back(ReadImage(to / ("masks/IMG_" + std::to_string(i) + ".JPG.png"), 1).data);
    return read;
  };
  const auto plain = masks("plain_names");
  EXPECT_EQ(masks("inverted"), plain);
  EXPECT_EQ(masks("levels_0_and_1"), plain);
}

}  // namespace keypose::capture::own_masks_program_test
