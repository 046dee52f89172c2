// Films that do not run together are refused before anything is made of them.
#include "views/shot/sync_check.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "core/values/errors.h"

namespace keypose::together_test {

using ::testing::AllOf;
using ::testing::HasSubstr;

ShotCamera Numbered(const std::string& name, const std::vector<int>& numbers) {
  ShotCamera camera;
  camera.name = name;
  for (const int number : numbers)
    camera.pictures.pictures.emplace_back(fmt::format("take2_{:04}.jpg", number));
  camera.pictures.frames = static_cast<int>(numbers.size());
  return camera;
}

std::vector<int> Range(int first, int count, int step, int left_out = -1) {
  std::vector<int> numbers;
  for (int i = 0; i < count; ++i)
    if (i != left_out) numbers.push_back(first + i * step);
  return numbers;
}

std::string Fault(const std::vector<ShotCamera>& cameras) {
  try {
    RequireSameGaps(cameras);
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Together, ACameraThatLostAPictureIsNamed) {
  const ShotCamera whole = Numbered("left", Range(1001, 40, 1));
  EXPECT_THAT(Fault({whole, Numbered("right", Range(1, 40, 1, 17))}),
              AllOf(HasSubstr("camera right has no picture between take2_0017.jpg and "
                              "take2_0019.jpg, where left has one"),
                    HasSubstr("a copy of take2_0017.jpg")));
  EXPECT_THAT(Fault({Numbered("right", Range(1, 40, 1, 17)), whole}),
              HasSubstr("camera right has no picture between take2_0017.jpg"));
}

TEST(Together, FilmsOnTwosOtherStartsAndOtherLengthsRunTogether) {
  EXPECT_EQ(Fault({Numbered("a", Range(0, 40, 2)), Numbered("b", Range(7, 33, 1))}), "");
  EXPECT_EQ(Fault({Numbered("a", Range(0, 40, 1, 9)), Numbered("b", Range(100, 30, 1, 9))}), "")
      << "left out of both";
}

TEST(Together, PicturesThatAllCamerasLackAreSaid) {
  std::vector<int> numbers = Range(0, 40, 2, 9);
  numbers.erase(numbers.begin() + 20, numbers.begin() + 22);
  EXPECT_THAT(WordsOnGaps(Numbered("a", numbers)),
              HasSubstr("camera a: by their numbers 3 pictures are missing, first between "
                        "take2_0016.jpg and take2_0020.jpg"));
  EXPECT_EQ(WordsOnGaps(Numbered("a", Range(7, 33, 1))), "");
  EXPECT_EQ(WordsOnGaps(Numbered("a", {12, 45, 79, 112, 145})), "") << "times";
}

TEST(Together, NumbersThatAreTimesSayNothing) {
  EXPECT_EQ(Fault({Numbered("a", {12, 45, 79, 112, 145}), Numbered("b", {13, 46, 80, 112, 147})}),
            "");
}

}  // namespace keypose::together_test
