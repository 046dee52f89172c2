// Photographs of two cameras, which have two sizes, in one pose.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "capture/testing/capture_program.h"
#include "core/io/pictures/image_set.h"

namespace keypose::capture::several_cameras_test {

using ::testing::HasSubstr;
using ::testing::Not;

/// Turn by turn a photograph of a larger camera, `large` and `small` px wide, both 3 : 2.
class SeveralCameras : public CaptureProgram {
 protected:
  void Write(int count, int large, int small) {
    for (int i = 0; i < count; ++i) {
      const int width = i % 2 == 0 ? large : small;
      const TestPhoto photo = MakeTestPhoto(i, width, width * 2 / 3, TestWall::kLight);
      WriteImage(photos / Name(i), photo.image, 95);
      truths.push_back(photo.truth);
    }
  }
  static std::string Name(int i) { return "p" + std::to_string(10 + i) + ".jpg"; }

  /// The least share of a photograph's figure, in the mask or the truth, that is in both.
  double LeastShared() const {
    double least = 1;
    for (std::size_t i = 0; i < truths.size(); ++i) {
      const Image8 mask = ReadImage(images / "masks" / (Name(static_cast<int>(i)) + ".png"), 1);
      if (mask.data.size() != truths[i].data.size()) return 0;
      double both = 0, either = 0;
      for (std::size_t p = 0; p < mask.data.size(); ++p)
        both += mask.data[p] && truths[i].data[p], either += mask.data[p] || truths[i].data[p];
      least = std::min(least, both / either);
    }
    return least;
  }

  std::vector<Image8> truths;
};

TEST_F(SeveralCameras, AllAreMaskedAtTheirOwnSize) {
  Write(16, 240, 144);
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(LeastShared(), 0.9);
  const ImageSet set = ReadImageSet(images);
  EXPECT_EQ(set.images[0].width, 240);
  EXPECT_EQ(set.images[1].width, 144);
  const auto report = nlohmann::json::parse(Report())["measurements"];
  EXPECT_EQ(report["sizes"], 2);
  EXPECT_EQ(report["images_by_size"][1]["photographs"], 8);
  EXPECT_THAT(Report(), Not(HasSubstr("different sizes")));  // a note, and no warning
  EXPECT_THAT(outcome.output, HasSubstr("8 are 144 x 96"));
}

TEST_F(SeveralCameras, LargeOnesAreReducedAndTheOthersAreNot) {
  Write(8, 240, 144);
  const Outcome outcome = Run("--max_size 180");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  EXPECT_EQ(set.images[0].width, 180);
  EXPECT_EQ(set.images[0].photograph_width, 240);
  EXPECT_EQ(set.images[1].width, 144);
  EXPECT_EQ(set.images[1].photograph_width, 0);
}

TEST_F(SeveralCameras, CleanPlateIsOfTheCameraThatHasItsSize) {
  Write(16, 240, 144);
  WriteImage(photos / "background.png", MakeTestWall(240, 160, TestWall::kLight));
  const Outcome outcome = Run();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(LeastShared(), 0.9);
  EXPECT_THAT(Report(), HasSubstr("masked without it: p11.jpg, p13.jpg"));
}

TEST_F(SeveralCameras, CleanPlateOfNoneIsAnInputError) {
  Write(8, 240, 144);
  WriteImage(photos / "background.png", MakeTestWall(200, 160, TestWall::kLight));
  const Outcome outcome = Run();
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("clean plate"));
}

}  // namespace keypose::capture::several_cameras_test
