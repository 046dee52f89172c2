// The program keypose-masks on a ring of photographs of a ball.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "capture/testing/test_ring.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::capture::masks_program_test {
namespace fs = std::filesystem;

class MasksProgram : public ::testing::Test, public TestingFolder {
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
    WriteColmapModel(root / "model", Scene{ring.views, points});
    const std::string command = first + BinFolder() + "/keypose-masks --images " +
                                set.folder.string() + " --model " + (root / "model").string() +
                                " --masked " + (root / "masked").string() + " " + options +
                                " --report " + (root / "report.json").string() + " > " +
                                (root / "log.txt").string() + " 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  }

  const fs::path root = path();
  /// Points of a room around the ball, in no mask.
  void AddRoom() {
    const int views = static_cast<int>(ring.views.size());
    for (int k = 0; k < 60; ++k) {
      SparsePoint point;
      const double angle = 0.4 * k;
      point.position = {3 * std::cos(angle), 3 * std::sin(angle), 0.5 + 0.02 * k};
      point.color.setConstant(128);
      point.views = {k % views, (k + 1) % views};
      std::sort(point.views.begin(), point.views.end());
      points.push_back(point);
    }
  }

  TestRing ring;
  ImageSet set;
  std::vector<SparsePoint> points;
  std::string first;  // shell text before the program's name
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
  EXPECT_THAT(ReadFile(root / "report.json"), ::testing::HasSubstr("\"agreement_before\""));
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
              ::testing::HasSubstr("of the figure that the other photographs agree on"));
  const std::string report = ReadFile(root / "report.json");
  EXPECT_THAT(report, ::testing::HasSubstr("\"distrusted\""));
  EXPECT_THAT(report,
              ::testing::HasSubstr(ring.views[7].name + " contradicts the other photographs"));
}

TEST_F(MasksProgram, PhotographOfAFigureOfTheSameOutlineAndOtherColoursIsNamed) {
  for (std::size_t p = 0; p < ring.images[7].data.size(); p += 3)
    if (ring.masks[7].data[p / 3]) ring.images[7].data[p] /= 6;  // hardly any red remains
  WriteImage(set.ImagePath(7), ring.images[7]);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (int i = 0; i < kRingViews; ++i)
    EXPECT_EQ(masked.images[static_cast<std::size_t>(i)].trusted, i != 7) << i;
  EXPECT_THAT(masked.images[7].why, ::testing::HasSubstr("other colours"));
}

TEST_F(MasksProgram, FigureThatWasMovedHalfWayRoundIsAnInputErrorThatSaysWhatToDo) {
  for (std::size_t i = kRingViews / 2; i < kRingViews; ++i) {
    Redraw(ring, i, 25, 0, 39);
    WriteImage(set.ImagePath(static_cast<int>(i)), ring.images[i]);
    WriteImage(set.MaskPath(static_cast<int>(i)), ring.masks[i]);
  }
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), ::testing::HasSubstr("shoot the rest again"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

TEST_F(MasksProgram, RefusedRoomLeavesASheetOfWhatWasTakenForTheFigure) {
  AddRoom();
  first = "KEYPOSE_ISNET_ONNX=" + (root / "none").string() + " ";  // nothing tells what it is
  const std::vector<Image8> right = ring.masks;
  const auto write_masks = [&](const std::vector<Image8>& masks) {
    for (int i = 0; i < kRingViews; ++i)
      WriteImage(set.MaskPath(i), masks[static_cast<std::size_t>(i)]);
  };
  for (std::size_t i = 0; i < kRingViews; ++i)
    for (int y = 0; y < kRingHeight; ++y)
      for (int x = 0; x < kRingWidth; ++x)
        *ring.masks[i].at(x, y) = (i % 2 == 0 ? x < 60 : x > 140) && y < 60 ? 255 : 0;
  write_masks(ring.masks);
  EXPECT_EQ(Run(), 3) << ReadFile(root / "log.txt");
  EXPECT_FALSE(fs::exists(root / "masked"));
  const fs::path sheet = root / "masked.failed.jpg";
  EXPECT_THAT(ReadFile(root / "log.txt"),
              ::testing::AllOf(::testing::HasSubstr("it cannot be told what the figure is"),
                             ::testing::HasSubstr(sheet.string())));
  ASSERT_TRUE(fs::exists(sheet));
  const Image8 shown = ReadImage(sheet, 3);
  EXPECT_GE(shown.width * shown.height, kRingViews * 240 * 180);  // a cell for each photograph

  write_masks(right);
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  EXPECT_TRUE(fs::exists(root / "masked"));
  EXPECT_FALSE(fs::exists(sheet));
}

TEST_F(MasksProgram, InARoomAPhotographWithoutACameraIsNotTrusted) {
  ring.views.pop_back();
  AddRoom();
  first = "KEYPOSE_ISNET_ONNX=" + (root / "none").string() + " ";
  ASSERT_EQ(Run(), 0) << ReadFile(root / "log.txt");
  const ImageSet masked = ReadImageSet(root / "masked");
  for (std::size_t i = 0; i < kRingViews; ++i)
    EXPECT_EQ(masked.images[i].trusted, i + 1 < kRingViews) << i;
  EXPECT_THAT(masked.images.back().why, ::testing::HasSubstr("no camera"));
}

TEST_F(MasksProgram, ModelOfOtherPhotographsIsAnInputError) {
  ring.views[2].name = "elsewhere.png";
  EXPECT_EQ(Run(), 3);
  EXPECT_THAT(ReadFile(root / "log.txt"), ::testing::HasSubstr("elsewhere.png"));
  EXPECT_FALSE(fs::exists(root / "masked"));
}

}  // namespace keypose::capture::masks_program_test
