#include "core/io/project/opencv_lens.h"

#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::opencv_lens_test {

const std::vector<double> kMatrix{900, 890, 639.5, 359.5};

std::vector<double> Numbers(std::size_t count) {
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i) numbers.push_back(0.001 * static_cast<double>(i + 1));
  return numbers;
}

TEST(OpenCvLens, PixelsCountFromTheCentreOfTheFirst) {
  const Lens lens = OpenCvLens("", kMatrix, {}, "here");
  EXPECT_EQ(lens.cx, 640);
  EXPECT_EQ(lens.cy, 360);
  EXPECT_EQ(*lens.Project({0.1, 0.1, 1}), Eigen::Vector2d(730, 449));
}

// The order of OpenCV's coefficients; the tests of Lens compare the mapping with OpenCV's own.
TEST(OpenCvLens, CoefficientsHaveOpenCvsOrder) {
  const std::vector<double> n = Numbers(14);
  const Lens lens = OpenCvLens("", kMatrix, n, "here");
  EXPECT_EQ(lens.radial, (std::array<double, 6>{0.001, 0.002, 0.005, 0, 0, 0}));
  EXPECT_EQ(lens.p1, 0.003);
  EXPECT_EQ(lens.p2, 0.004);
  EXPECT_EQ(lens.divisor, (std::array<double, 3>{0.006, 0.007, 0.008}));
  EXPECT_EQ(lens.prism, (std::array<double, 4>{n[8], n[9], n[10], n[11]}));
  EXPECT_EQ(lens.tilt, (std::array<double, 2>{n[12], n[13]}));
}

TEST(OpenCvLens, EveryModelIsReadOrRefusedByName) {
  struct Case {
    const char* name;
    std::vector<std::size_t> counts;  ///< that it takes
    LensProjection projection;
  };
  using enum LensProjection;
  const std::vector<std::size_t> all{0, 2, 4, 5, 8, 12, 14};
  for (const Case& c : std::vector<Case>{{"", all, kPerspective},
                                         {"plumb_bob", all, kPerspective},
                                         {"radtan", all, kPerspective},
                                         {"Plumb Bob", all, kPerspective},
                                         {"OPENCV", all, kPerspective},
                                         {"rational_polynomial", {5, 8}, kPerspective},
                                         {"thin_prism", {8, 12, 14}, kPerspective},
                                         {"tilted", {8, 12, 14}, kPerspective},
                                         {"equidistant", {0, 1, 2, 3, 4}, kEquidistant},
                                         {"fisheye", {0, 1, 2, 3, 4}, kEquidistant},
                                         {"kannala_brandt", {0, 1, 2, 3, 4}, kEquidistant},
                                         {"fov", {1}, kFieldOfView},
                                         {"none", {0}, kPerspective}})
    for (std::size_t count = 0; count < 16; ++count) {
      const bool taken = std::count(c.counts.begin(), c.counts.end(), count) > 0;
      if (taken)
        EXPECT_EQ(OpenCvLens(c.name, kMatrix, Numbers(count), "here").projection, c.projection);
      else
        EXPECT_THROW(OpenCvLens(c.name, kMatrix, Numbers(count), "here"), InputError)
            << c.name << " " << count;
    }
  EXPECT_EQ(OpenCvLens("equidistant", kMatrix, {0.1, 0.2, 0.3, 0.4, 0}, "here").radial[3], 0.4);
  for (const char* unknown : {"omnidirectional", "scaramuzza", "cylindrical", "mei"}) try {
      OpenCvLens(unknown, kMatrix, Numbers(4), "rig.yml, cam1");
      FAIL() << unknown;
    } catch (const InputError& error) {
      EXPECT_NE(
          std::string(error.what()).find(std::string("rig.yml, cam1: the lens model ") + unknown),
          std::string::npos);
    }
}

TEST(OpenCvLens, ProductsAreNoLensModels) {
  for (const char* name : {"fisheye", "Kannala-Brandt", "pinhole", "omnidirectional", "mei"})
    EXPECT_TRUE(IsLensModelName(name)) << name;
  for (const char* name : {"D435", "GoPro HERO9", "acA1920"})
    EXPECT_FALSE(IsLensModelName(name)) << name;
}

TEST(OpenCvLens, ACountThatOpenCvDoesNotHaveIsToldTheOrder) {
  try {
    OpenCvLens("", kMatrix, Numbers(3), "rig.yml, cam0");
    FAIL() << "three are none of OpenCV's";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "rig.yml, cam0: its distortion has 3 coefficients, but OpenCV's has 4, 5, 8, 12 or "
              "14, in the order k1 k2 p1 p2 k3 and on; put 0 for those that it lacks");
  }
}

}  // namespace keypose::opencv_lens_test
