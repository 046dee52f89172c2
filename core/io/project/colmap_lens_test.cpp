#include "core/io/project/colmap_lens.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "core/io/project/colmap_io.h"
#include "core/io/project/lens_use.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::colmap_lens_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Numbers for every model, and where COLMAP's formulas put the point (0.3, -0.2, 1), by hand.
struct Case {
  std::string name;
  std::vector<double> parameters;
  Vector2d plane;  ///< before the focal length
};

constexpr double kU = 0.3, kV = -0.2, kR2 = 0.13;

Vector2d Scaled(double factor) { return {kU * factor, kV * factor}; }

std::vector<Case> Cases() {
  const double r = std::sqrt(kR2), t = std::atan(r), t2 = t * t, r4 = kR2 * kR2, r6 = r4 * kR2;
  const double pu = 2 * 1e-3 * kU * kV + -2e-3 * (kR2 + 2 * kU * kU),
               pv = 2 * -2e-3 * kU * kV + 1e-3 * (kR2 + 2 * kV * kV);
  const double a = kU * t / r, b = kV * t / r;  // on the fisheye's plane
  const double radial4 =
      1 + 0.1 * t2 + 0.02 * t2 * t2 + 0.01 * std::pow(t2, 3) + 5e-3 * std::pow(t2, 4);
  const Vector2d thin(a * radial4 + 2 * 1e-3 * a * b - 2e-3 * (t2 + 2 * a * a) + 3e-3 * t2,
                      b * radial4 - 2 * 2e-3 * a * b + 1e-3 * (t2 + 2 * b * b) - 4e-3 * t2);
  const double radial6 = radial4 + 1e-3 * std::pow(t2, 5) - 1e-3 * std::pow(t2, 6);
  const double x = a * radial6, y = b * radial6, q = x * x + y * y;
  const Vector2d aria(x + 2 * 2e-3 * x * y + 1e-3 * (q + 2 * x * x) + 3e-3 * q + 4e-3 * q * q,
                      y + 2 * 1e-3 * x * y + 2e-3 * (q + 2 * y * y) - 3e-3 * q - 4e-3 * q * q);
  const double division = 2 / (1 + std::sqrt(1 + 4 * 0.1 * kR2));
  const double enhanced = 0.6 * std::sqrt(1.1 * kR2 + 1) + 0.4;
  return {
      {"SIMPLE_PINHOLE", {500, 320, 240}, Scaled(1)},
      {"PINHOLE", {500, 500, 320, 240}, Scaled(1)},
      {"SIMPLE_RADIAL", {500, 320, 240, 0.1}, Scaled(1 + 0.1 * kR2)},
      {"RADIAL", {500, 320, 240, 0.1, 0.02}, Scaled(1 + 0.1 * kR2 + 0.02 * r4)},
      {"OPENCV",
       {500, 500, 320, 240, 0.1, 0.02, 1e-3, -2e-3},
       Scaled(1 + 0.1 * kR2 + 0.02 * r4) + Vector2d(pu, pv)},
      {"OPENCV_FISHEYE", {500, 500, 320, 240, 0.1, 0.02, 0.01, 5e-3}, Vector2d(a, b) * radial4},
      {"FULL_OPENCV",
       {500, 500, 320, 240, 0.1, 0.02, 1e-3, -2e-3, 0.03, 0.2, 0.04, 0.05},
       Scaled((1 + 0.1 * kR2 + 0.02 * r4 + 0.03 * r6) / (1 + 0.2 * kR2 + 0.04 * r4 + 0.05 * r6)) +
           Vector2d(pu, pv)},
      {"FOV", {500, 500, 320, 240, 0.9}, Scaled(std::atan(2 * r * std::tan(0.45)) / (0.9 * r))},
      {"SIMPLE_RADIAL_FISHEYE", {500, 320, 240, 0.1}, Vector2d(a, b) * (1 + 0.1 * t2)},
      {"RADIAL_FISHEYE",
       {500, 320, 240, 0.1, 0.02},
       Vector2d(a, b) * (1 + 0.1 * t2 + 0.02 * t2 * t2)},
      {"THIN_PRISM_FISHEYE",
       {500, 500, 320, 240, 0.1, 0.02, 1e-3, -2e-3, 0.01, 5e-3, 3e-3, -4e-3},
       thin},
      {"RAD_TAN_THIN_PRISM_FISHEYE",
       {500, 500, 320, 240, 0.1, 0.02, 0.01, 5e-3, 1e-3, -1e-3, 1e-3, 2e-3, 3e-3, 4e-3, -3e-3,
        -4e-3},
       aria},
      {"SIMPLE_DIVISION", {500, 320, 240, -0.1}, Scaled(division)},
      {"DIVISION", {500, 500, 320, 240, -0.1}, Scaled(division)},
      {"SIMPLE_FISHEYE", {500, 320, 240}, {a, b}},
      {"FISHEYE", {500, 500, 320, 240}, {a, b}},
      {"EUCM", {500, 500, 320, 240, 0.6, 1.1}, Scaled(1 / enhanced)},
      {"BROWN_CONRADY",
       {500, 320, 240, 0.1, 0.02, 0.03, 1e-3, -2e-3},
       Scaled(1 + 0.1 * kR2 + 0.02 * r4 + 0.03 * r6) + Vector2d(pu, pv)},
  };
}

TEST(ColmapLens, EveryModelMapsAsItsFormulaOrIsRefusedByName) {
  std::vector<std::string> tried{"EQUIRECTANGULAR"};
  for (const Case& c : Cases()) {
    const auto model = FindColmapModel(c.name);
    ASSERT_TRUE(model) << c.name;
    if (model->id >= 0) {
      EXPECT_EQ(FindColmapModel(model->id)->name, c.name);
    }
    const Lens lens = ColmapLens(*model, c.parameters, "here");
    EXPECT_EQ(lens.model, c.name);
    const Vector2d pixel = *lens.Project({kU, kV, 1});
    EXPECT_LT((pixel - Vector2d(320, 240) - 500 * c.plane).norm(), 1e-9) << c.name;
    EXPECT_LT((*lens.Ray(pixel) - Vector3d(kU, kV, 1).normalized()).norm(), 1e-11) << c.name;
    tried.push_back(c.name);
  }
  for (const ColmapLensModel& model : ColmapLensModels())
    EXPECT_EQ(std::count(tried.begin(), tried.end(), model.name), 1) << model.name;
  try {
    ColmapLens(*FindColmapModel("EQUIRECTANGULAR"), {640, 480}, "cameras.bin: camera 1");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(
        std::string(error.what()).find("cameras.bin: camera 1: the lens model EQUIRECTANGULAR"),
        std::string::npos);
  }
}

TEST(ColmapLens, NumbersAreThoseOfColmap) {
  const std::vector<std::string> in_order{"SIMPLE_PINHOLE",
                                          "PINHOLE",
                                          "SIMPLE_RADIAL",
                                          "RADIAL",
                                          "OPENCV",
                                          "OPENCV_FISHEYE",
                                          "FULL_OPENCV",
                                          "FOV",
                                          "SIMPLE_RADIAL_FISHEYE",
                                          "RADIAL_FISHEYE",
                                          "THIN_PRISM_FISHEYE",
                                          "RAD_TAN_THIN_PRISM_FISHEYE",
                                          "SIMPLE_DIVISION",
                                          "DIVISION",
                                          "SIMPLE_FISHEYE",
                                          "FISHEYE",
                                          "EUCM",
                                          "EQUIRECTANGULAR"};
  for (int id = 0; id < static_cast<int>(in_order.size()); ++id)
    EXPECT_EQ(FindColmapModel(id)->name, in_order[static_cast<std::size_t>(id)]);
  EXPECT_FALSE(FindColmapModel(-1));
  EXPECT_FALSE(FindColmapModel(99));
  EXPECT_FALSE(FindColmapModel("opencv"));
  EXPECT_THROW(ColmapLens(*FindColmapModel("PINHOLE"), {500, 320, 240}, "here"), InputError);
}

TEST(ColmapLens, TheProgramItselfPutsPointsWhereTheLensDoes) {
  if (std::system("command -v colmap > /dev/null") != 0) GTEST_SKIP() << "colmap is not there";
  // A point seen by two cameras of each model at pixels of ours: the program finds the error of its
  // own projections, which is that of our formulas.
  const TestingFolder in, out;
  std::string cameras, images, points;
  int id = 0;
  for (const Case& c : Cases()) {
    const int number = FindColmapModel(c.name)->id;
    if (number < 0 || number > 10) continue;  // those that 3.8 knows
    const Lens lens = ColmapLens(*FindColmapModel(c.name), c.parameters, "here");
    ++id;
    cameras += std::to_string(id) + " " + c.name + " 640 480";
    for (const double p : c.parameters) cameras += " " + std::to_string(p);
    cameras += "\n";
    const std::string point = std::to_string(id);
    for (const double shift : {0.0, 0.4}) {
      const Vector2d pixel = *lens.Project({kU + shift, kV, 1});
      const std::string image = std::to_string(2 * id + (shift > 0));
      images += image + " 1 0 0 0 " + std::to_string(shift) + " 0 0 " + point + " i" + image +
                ".jpg\n" + std::to_string(pixel.x()) + " " + std::to_string(pixel.y()) + " " +
                point + "\n";
    }
    points += point + " 0.3 -0.2 1 9 9 9 0 " + std::to_string(2 * id) + " 0 " +
              std::to_string(2 * id + 1) + " 0\n";
  }
  in.Put("cameras.txt", cameras);
  in.Put("images.txt", images);
  in.Put("points3D.txt", points);
  const std::string run =
      "colmap point_filtering --max_reproj_error 0.01 --min_track_len 2 --min_tri_angle 0.1 "
      "--input_path " +
      in.path().string() + " --output_path " + out.path().string() + " > /dev/null 2>&1";
  ASSERT_EQ(std::system(run.c_str()), 0);
  EXPECT_EQ(ReadColmapLenses(out.path()).size(), 22u);
  // points whose error was above a hundredth of a pixel are gone
  std::uint64_t count = 0;
  std::ifstream(out.path() / "points3D.bin", std::ios::binary)
      .read(reinterpret_cast<char*>(&count), 8);
  EXPECT_EQ(count, 11u);
}

}  // namespace keypose::colmap_lens_test
