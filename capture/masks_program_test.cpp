// The program keypose-masks on a ring of photographs of a ball.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>

#include "capture/testing/test_ring.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/testing_folder.h"

namespace keypose::capture {
namespace {
namespace fs = std::filesystem;

class MasksProgram : public testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    ring = MakeTestRing();
    set.folder = root / "images";
    fs::create_directories(set.folder / "masks");
    for (std::size_t i = 0; i < ring.views.size(); ++i) {
      CapturedImage image;
      image.name = ring.views[i].name;
      image.width = kRingWidth, image.height = kRingHeight;
      image.mask = "masks/" + image.name + ".png";
      image.mask_given = i == 4;
      WriteImage(set.folder / image.name, ring.images[i]);
      WriteImage(set.folder / image.mask, ring.masks[i]);
      set.images.push_back(image);
    }
    WriteImageSet(set);
  }
  int Run(const std::string& options = "") const {
    fs::create_directories(root / "model");
    WriteColmapModel(root / "model", Scene{ring.views, {}});
    const std::string command = std::string(KEYPOSE_BIN_DIR) + "/keypose-masks --images " +
                                set.folder.string() + " --model " + (root / "model").string() +
                                " --masked " + (root / "masked").string() + " " + options +
                                " --report " + (root / "report.json").string() + " > " +
                                (root / "log.txt").string() + " 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }

  const fs::path root = path();
  TestRing ring;
  ImageSet set;
};

TEST_F(MasksProgram, WritesAnImagesFolderAndLeavesTheUsersMasks) {
  ring.views.pop_back();  // a photograph without a camera keeps its mask
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  ASSERT_EQ(masked.images.size(), set.images.size());
  EXPECT_GT(Iou(ReadImage(masked.MaskPath(3), 1), ring.truths[3]), 0.97);
  EXPECT_EQ(ReadImage(masked.MaskPath(4), 1).data, ring.masks[4].data);
  EXPECT_EQ(ReadImage(masked.MaskPath(kRingViews - 1), 1).data, ring.masks[kRingViews - 1].data);
  EXPECT_EQ(ReadFile(masked.ImagePath(3)), ReadFile(set.ImagePath(3)));
  EXPECT_THAT(ReadFile(root / "report.json"), testing::HasSubstr("\"agreement_before\""));
}

TEST_F(MasksProgram, SizeAndSmoothnessOfTheSegmentationChangeTheMasks) {
  const auto masks = [&](const std::string& options) {
    EXPECT_EQ(Run("--overwrite " + options), 0) << ReadFile(root / "log.txt");
    std::string all;
    for (int i = 0; i < kRingViews; ++i)
      if (i != 4) all += ReadFile(ReadImageSet(root / "masked").MaskPath(i));
    return all;
  };
  const std::string plain = masks("");
  EXPECT_NE(masks("--mask_px 64"), plain);
  EXPECT_NE(masks("--mask_smoothness 0"), plain);
}

TEST_F(MasksProgram, PhotographOfSomethingElseIsNamedAndNotTrusted) {
  Redraw(ring, 7, 14, -9, 30);
  WriteImage(set.ImagePath(7), ring.images[7]);
  WriteImage(set.MaskPath(7), ring.masks[7]);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (int i = 0; i < kRingViews; ++i) {
    EXPECT_EQ(masked.images[i].trusted, i != 7) << i;
    // view 4 has the user's own mask, which stays, including the lamp
    if (i == 7 || i == 4) continue;
    EXPECT_GT(Iou(ReadImage(masked.MaskPath(i), 1), ring.truths[static_cast<std::size_t>(i)]), 0.97)
        << i;
  }
  EXPECT_THAT(masked.images[7].why,
              testing::HasSubstr("of the figure that the other photographs agree on"));
  const std::string report = ReadFile(root / "report.json");
  EXPECT_THAT(report, testing::HasSubstr("\"distrusted\""));
  EXPECT_THAT(report,
              testing::HasSubstr(ring.views[7].name + " contradicts the other photographs"));
}

TEST_F(MasksProgram, PhotographOfAFigureOfTheSameOutlineAndOtherColoursIsNamed) {
  for (std::size_t p = 0; p < ring.images[7].data.size(); p += 3)
    if (ring.masks[7].data[p / 3]) ring.images[7].data[p] /= 6;  // hardly any red remains
  WriteImage(set.ImagePath(7), ring.images[7]);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (int i = 0; i < kRingViews; ++i)
    EXPECT_EQ(masked.images[static_cast<std::size_t>(i)].trusted, i != 7) << i;
  EXPECT_THAT(masked.images[7].why, testing::HasSubstr("other colours"));
}

TEST_F(MasksProgram, FigureThatWasMovedHalfWayRoundIsAnInputErrorThatSaysWhatToDo) {
  for (std::size_t i = kRingViews / 2; i < kRingViews; ++i) {
    Redraw(ring, i, 25, 0, 39);
    WriteImage(set.ImagePath(static_cast<int>(i)), ring.images[i]);
    WriteImage(set.MaskPath(static_cast<int>(i)), ring.masks[i]);
  }
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), testing::HasSubstr("shoot the rest again"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

TEST_F(MasksProgram, ModelOfOtherPhotographsIsAnInputError) {
  ring.views[2].name = "elsewhere.png";
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), testing::HasSubstr("elsewhere.png"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

}  // namespace
}  // namespace keypose::capture
