#include "bench/view_score.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "core/io/pictures/image_io.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::bench::view_score_test {
namespace fs = std::filesystem;

/// 80 x 60 pixels, 100 pixels per unit at z = 1, camera at the origin.
View TestView() {
  View view;
  view.camera = {.width = 80, .height = 60, .fx = 100, .fy = 100, .cx = 40, .cy = 30};
  return view;
}

/// Two triangles at z = 1 that cover the pixels [x0,x1) x [y0,y1) of TestView, with `color` at all
/// corners.
TexturedMesh Quad(double x0, double y0, double x1, double y1, int color) {
  TexturedMesh quad;
  quad.mesh.points.resize(4, 3);
  quad.mesh.points << x0, y0, 0, x1, y0, 0, x1, y1, 0, x0, y1, 0;
  quad.mesh.points.rowwise() -= Eigen::RowVector3d(40, 30, -100);
  quad.mesh.points /= 100;
  quad.mesh.faces.resize(2, 3);
  quad.mesh.faces << 0, 2, 1, 0, 3, 2;
  quad.mesh.colors = ColorsX3::Constant(4, 3, static_cast<std::uint8_t>(color));
  return quad;
}

Image8 MaskOf(int x0, int y0, int x1, int y1) {
  Image8 mask(80, 60, 1);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) *mask.at(x, y) = 255;
  return mask;
}

/// `inside` where the mask is, `outside` elsewhere.
Image8 PhotographOf(const Image8& mask, int inside, int outside) {
  Image8 photograph(mask.width, mask.height, 3);
  for (std::size_t i = 0; i < photograph.data.size(); ++i)
    photograph.data[i] = static_cast<std::uint8_t>(mask.data[i / 3] >= 128 ? inside : outside);
  return photograph;
}

ColorScore Score(const TexturedMesh& mesh, const Image8& photograph, const Image8& mask) {
  return CompareColors(
      photograph, mask,
      RenderColors(mesh, RayScene(mesh.mesh.points, mesh.mesh.faces), TestView(), 2));
}

Image8 Noise(int width, int height, unsigned seed) {
  std::mt19937 random(seed);
  Image8 image(width, height, 3);
  for (std::uint8_t& value : image.data) value = static_cast<std::uint8_t>(random() % 256);
  return image;
}

/// A literal implementation of the definition, one window at a time.
double LiteralSsim(const Image8& a, const Image8& b, const Image8& mask) {
  const auto luma = [](const std::uint8_t* p) {
    return 0.299 * p[0] + 0.587 * p[1] + 0.114 * p[2];
  };
  double total = 0;
  int count = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      if (*mask.at(x, y) < 128) continue;
      double weight = 0, ma = 0, mb = 0, aa = 0, bb = 0, ab = 0;
      for (int pass = 0; pass < 2; ++pass) {
        for (int dy = -5; dy <= 5; ++dy)
          for (int dx = -5; dx <= 5; ++dx) {
            const int u = x + dx, v = y + dy;
            if (u < 0 || v < 0 || u >= a.width || v >= a.height || *mask.at(u, v) < 128) continue;
            const double w = std::exp(-(dx * dx + dy * dy) / 4.5), la = luma(a.at(u, v)),
                         lb = luma(b.at(u, v));
            if (pass == 0) weight += w, ma += w * la, mb += w * lb;
            if (pass == 1)
              aa += w * (la - ma) * (la - ma), bb += w * (lb - mb) * (lb - mb),
                  ab += w * (la - ma) * (lb - mb);
          }
        if (pass == 0) ma /= weight, mb /= weight;
      }
      total += (2 * ma * mb + 6.5025) * (2 * ab / weight + 58.5225) /
               ((ma * ma + mb * mb + 6.5025) * (aa / weight + bb / weight + 58.5225));
      ++count;
    }
  return total / count;
}

TEST(Silhouette, CountsPixelsOfAKnownOverlap) {
  // 20 x 30 pixels against 20 x 30 pixels shifted by 5 to the right: 15 x 30 in common.
  const TexturedMesh quad = Quad(15, 10, 35, 40, 0);
  const Image8 covered =
      CoveredPixels(quad, RayScene(quad.mesh.points, quad.mesh.faces), TestView());
  const Silhouette s = CompareSilhouettes(MaskOf(10, 10, 30, 40), covered);
  EXPECT_EQ(s.both, 450);
  EXPECT_EQ(s.mask_only, 150);
  EXPECT_EQ(s.mesh_only, 150);
  EXPECT_DOUBLE_EQ(s.Iou(), 0.6);
  EXPECT_DOUBLE_EQ(s.Precision(), 0.75);
  EXPECT_DOUBLE_EQ(s.Recall(), 0.75);
}

TEST(Silhouette, EmptyMaskAndMesh) {
  const Image8 none(80, 60, 1);
  EXPECT_EQ(CompareSilhouettes(none, none).Iou(), 1);
  EXPECT_EQ(CompareSilhouettes(MaskOf(0, 0, 5, 5), none).Precision(), 0);
  EXPECT_EQ(CompareSilhouettes(none, MaskOf(0, 0, 5, 5)).Recall(), 0);
  EXPECT_THROW(CompareSilhouettes(none, Image8(79, 60, 1)), InputError);
}

TEST(Silhouette, FollowsTheLensDistortion) {
  View view = TestView();
  view.camera.k1 = -0.4;
  // Covers the right half of the picture and more. Its left edge is the middle column, which
  // distortion does not move.
  const TexturedMesh quad = Quad(40, -10, 100, 70, 0), edge = Quad(70, -10, 100, 70, 0);
  const Image8 half = CoveredPixels(quad, RayScene(quad.mesh.points, quad.mesh.faces), view);
  EXPECT_EQ(CompareSilhouettes(MaskOf(40, 0, 80, 60), half).Iou(), 1);
  // In the middle row, an edge at 0.3 of the focal length is imaged at 40 + 30 (1 - 0.4 * 0.09)
  // = 68.9.
  const Image8 right = CoveredPixels(edge, RayScene(edge.mesh.points, edge.mesh.faces), view);
  EXPECT_EQ(*right.at(68, 29), 0);
  EXPECT_EQ(*right.at(69, 29), 255);
}

TEST(CompareColors, SameColourIsPerfect) {
  const Image8 mask = MaskOf(10, 10, 50, 40);
  const ColorScore score = Score(Quad(10, 10, 50, 40, 120), PhotographOf(mask, 120, 7), mask);
  EXPECT_EQ(score.pixels, 1200);
  EXPECT_EQ(score.psnr_db, 99);
  EXPECT_NEAR(score.ssim, 1, 1e-12);
  EXPECT_NEAR(score.gain[0], 1, 1e-6);
}

TEST(CompareColors, KnownDifferenceAndItsGain) {
  const Image8 mask = MaskOf(10, 10, 50, 40);
  const ColorScore score = Score(Quad(10, 10, 50, 40, 100), PhotographOf(mask, 110, 7), mask);
  EXPECT_NEAR(score.psnr_db, 20 * std::log10(255.0 / 10), 1e-9);
  EXPECT_NEAR(score.gain[1], 1.1, 1e-6);
  EXPECT_EQ(score.gained_psnr_db, 99);
  // Without variance, only the term of the means remains.
  EXPECT_NEAR(score.ssim, (2 * 100. * 110 + 6.5025) / (100. * 100 + 110. * 110 + 6.5025), 1e-9);
}

TEST(CompareColors, WhatTheMeshLeavesOpenCountsAsBackground) {
  const Image8 mask = MaskOf(10, 10, 50, 40);
  // Half of the mask shows 30 (the photograph's background) instead of 90, and does not affect the
  // gain.
  const ColorScore score = Score(Quad(10, 10, 30, 40, 45), PhotographOf(mask, 90, 30), mask);
  EXPECT_NEAR(score.psnr_db, 10 * std::log10(255. * 255 / (0.5 * 45 * 45 + 0.5 * 60 * 60)), 1e-9);
  EXPECT_NEAR(score.gain[2], 2, 1e-6);
  EXPECT_NEAR(score.gained_psnr_db, 10 * std::log10(255. * 255 / (0.5 * 60 * 60)), 1e-9);
  EXPECT_EQ(score.filled_psnr_db, 99);
}

TEST(CompareColors, MeshOutsideTheMaskDoesNotCount) {
  const Image8 mask = MaskOf(10, 10, 50, 40);
  EXPECT_EQ(Score(Quad(0, 0, 80, 60, 120), PhotographOf(mask, 120, 7), mask).psnr_db, 99);
}

TEST(CompareColors, EmptyMaskHasNoPixels) {
  EXPECT_EQ(Score(Quad(0, 0, 9, 9, 1), Image8(80, 60, 3), Image8(80, 60, 1)).pixels, 0);
}

TEST(Ssim, EqualsItsDefinition) {
  const Image8 a = Noise(37, 23, 1);
  Image8 b = Noise(37, 23, 2);
  for (std::size_t i = 0; i < b.data.size(); ++i)
    b.data[i] = static_cast<std::uint8_t>((3 * a.data[i] + b.data[i]) / 4);
  Image8 mask = Noise(37, 23, 3);
  mask.channels = 1;
  mask.data.resize(37 * 23);
  const Image8 full(37, 23, 1, 255);
  EXPECT_NEAR(Ssim(a, b, full), LiteralSsim(a, b, full), 1e-9);
  EXPECT_NEAR(Ssim(a, b, mask), LiteralSsim(a, b, mask), 1e-9);
  EXPECT_LT(Ssim(a, b, full), 0.99);
  EXPECT_EQ(Ssim(a, a, mask), 1);
}

TEST(Ssim, FollowsTheFormulaForAConstantShift) {
  const double c1 = 2.55 * 2.55;
  EXPECT_NEAR(Ssim(Image8(40, 30, 3, 100), Image8(40, 30, 3, 130), Image8(40, 30, 1, 255)),
              (2 * 100 * 130 + c1) / (100 * 100 + 130 * 130 + c1), 1e-9);
}

TEST(Ssim, NothingOutsideTheMaskEnters) {
  const Image8 a = Noise(80, 60, 1), mask = MaskOf(20, 20, 40, 40);
  Image8 b = Noise(80, 60, 2);
  for (int y = 20; y < 40; ++y) std::copy_n(a.at(20, y), 60, b.at(20, y));
  EXPECT_NEAR(Ssim(a, b, mask), 1, 1e-9);
}

class TexturedObj : public ::testing::Test, public TestingFolder {
 protected:
  TexturedObj() {
    WriteImage(folder_ / "red page.png", PhotographOf(MaskOf(0, 0, 80, 60), 200, 0));
    WriteImage(folder_ / "dark.png", PhotographOf(MaskOf(0, 0, 80, 60), 20, 0));
    std::ofstream(folder_ / "two.mtl") << "newmtl one\nKd 1 1 1\nmap_Kd red page.png\nnewmtl "
                                          "two\nmap_Kd dark.png\nnewmtl bare\nKd 1 1 1\n";
  }
  TexturedMesh Read(const std::string& faces) const {
    std::ofstream(folder_ / "mesh.obj")
        << "mtllib two.mtl\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        << faces;
    return ReadTexturedMesh(folder_ / "mesh.obj");
  }
};

TEST_F(TexturedObj, EachFaceTakesItsMaterialsPage) {
  const TexturedMesh mesh = Read("usemtl two\nf 1/1 2/2 3/3\nusemtl one\nf 1/1 2/2 3/3 4/4\n");
  ASSERT_EQ(mesh.mesh.face_count(), 3);
  EXPECT_EQ(mesh.ColorAt(0, 0.3, 0.3), Eigen::Vector3d::Constant(20));
  EXPECT_EQ(mesh.ColorAt(1, 0.3, 0.3), Eigen::Vector3d::Constant(200));
  EXPECT_EQ(mesh.ColorAt(2, 0.3, 0.3), Eigen::Vector3d::Constant(200));
}

TEST_F(TexturedObj, FaultsAreTold) {
  EXPECT_THROW(Read("usemtl bare\nf 1/1 2/2 3/3\n"), InputError);
  EXPECT_THROW(Read("f 1/1 2/2 3/3\nusemtl one\nf 1/1 3/3 4/4\n"), InputError);
  Read("f 1 2 3\n");
  EXPECT_THROW(ReadTexturedMesh(folder_ / "mesh.obj", folder_ / "dark.png"), InputError);
  fs::remove(folder_ / "dark.png");
  EXPECT_THROW(Read("usemtl two\nf 1/1 2/2 3/3\n"), DiskError);
}

}  // namespace keypose::bench::view_score_test
