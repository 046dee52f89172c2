// Concave and bent polygons, as triangles.
#include "core/io/meshes/polygon_cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/obj_file.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/testing/folder.h"

namespace keypose::polygon_cut_test {

using ::testing::IsEmpty;
using ::testing::SizeIs;

PointsX3 Points(const std::vector<std::array<double, 3>>& rows) {
  PointsX3 points(std::ssize(rows), 3);
  for (std::size_t i = 0; i < rows.size(); ++i)
    points.row(static_cast<Eigen::Index>(i)) << rows[i][0], rows[i][1], rows[i][2];
  return points;
}

LocalTriangles CutOf(const PointsX3& points) {
  std::vector<int> corners(static_cast<std::size_t>(points.rows()));
  std::iota(corners.begin(), corners.end(), 0);
  return CutOfPolygon(points, corners.data(), corners.size());
}

Eigen::Vector3d AreaOf(const PointsX3& points, const std::array<int, 3>& t) {
  const Eigen::Vector3d a = points.row(t[1]) - points.row(t[0]),
                        b = points.row(t[2]) - points.row(t[0]);
  return a.cross(b) / 2;
}

/// Every triangle faces up, and together they have the polygon's area.
void ExpectCovers(const PointsX3& points, const LocalTriangles& cut, double area) {
  ASSERT_THAT(cut, SizeIs(points.rows() - 2));
  double sum = 0;
  for (const auto& triangle : cut) {
    const double z = AreaOf(points, triangle).z();
    EXPECT_GT(z, 1e-9);
    sum += z;
  }
  EXPECT_NEAR(sum, area, 1e-12 * area);
}

TEST(CutOfPolygon, ConvexPolygonsAreFans) {
  EXPECT_THAT(CutOf(Points({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}})), IsEmpty());
  EXPECT_THAT(CutOf(Points({{0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {1, 3, 0}, {-1, 1, 0}})), IsEmpty());
  EXPECT_THAT(CutOf(Points({{0, 0, 0}, {1, 0, 0.4}, {1, 1, 0}, {0, 1, 0.4}})), IsEmpty())
      << "bent, but not folded over";
}

TEST(CutOfPolygon, AQuadWithADentIsCutThroughIt) {
  // Corner 1 lies inside of the triangle of the others: the fan from 0 would fold over.
  const PointsX3 dart = Points({{0, 0, 0}, {1, 1, 0}, {4, 0, 0}, {1, 4, 0}});
  const LocalTriangles cut = CutOf(dart);
  ExpectCovers(dart, cut, 0.5 * (4 * 4 - 4 * 1));
  for (const auto& triangle : cut)
    EXPECT_EQ(std::count(triangle.begin(), triangle.end(), 1), 1) << "the dent is in both";
}

TEST(CutOfPolygon, TheLettersLAndEAndASpiralAreCovered) {
  const PointsX3 l = Points({{1, 1, 0}, {1, 3, 0}, {0, 3, 0}, {0, 0, 0}, {3, 0, 0}, {3, 1, 0}});
  ExpectCovers(Points({{0, 3, 0}, {0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}}),
               CutOf(Points({{0, 3, 0}, {0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}})),
               5);
  EXPECT_THAT(CutOf(l), IsEmpty()) << "from its inner corner even an L is a fan";
  const PointsX3 e = Points({{0, 0, 0},
                             {3, 0, 0},
                             {3, 1, 0},
                             {1, 1, 0},
                             {1, 2, 0},
                             {2, 2, 0},
                             {2, 3, 0},
                             {1, 3, 0},
                             {1, 4, 0},
                             {3, 4, 0},
                             {3, 5, 0},
                             {0, 5, 0}});
  ExpectCovers(e, CutOf(e), 5 + 2 + 1 + 2);
  std::vector<std::array<double, 3>> spiral;
  for (int side = 0; side < 2; ++side)
    for (int i = 0; i < 100; ++i) {
      const double turn = 0.1 * (side == 0 ? i : 99 - i),
                   r = 1 + 0.2 * turn + (side == 0 ? 0.5 : 0);
      spiral.push_back({r * std::cos(turn), r * std::sin(turn), 0});
    }
  const PointsX3 points = Points(spiral);
  double area = 0;
  for (Eigen::Index i = 0, n = points.rows(); i < n; ++i)
    area += (points(i, 0) * points((i + 1) % n, 1) - points(i, 1) * points((i + 1) % n, 0)) / 2;
  ExpectCovers(points, CutOf(points), area);
}

TEST(CutOfPolygon, StarsOfAnyFormAreCovered) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> share(0, 1);
  int fans = 0;
  for (int round = 0; round < 500; ++round) {
    const int count = 4 + round % 37;
    std::vector<std::array<double, 3>> star;
    double area = 0;
    for (int i = 0; i < count; ++i) {
      const double turn = 2 * M_PI * (i + 0.6 * share(random)) / count, r = 0.1 + share(random);
      star.push_back({r * std::cos(turn), r * std::sin(turn), 0});
    }
    for (int i = 0; i < count; ++i) {
      const auto &a = star[i], &b = star[(i + 1) % count];
      area += (a[0] * b[1] - a[1] * b[0]) / 2;
    }
    const PointsX3 points = Points(star);
    const LocalTriangles cut = CutOf(points);
    fans += cut.empty();
    if (cut.empty()) continue;
    ASSERT_THAT(cut, SizeIs(count - 2));
    double sum = 0;
    for (const auto& triangle : cut) {
      ASSERT_GT(AreaOf(points, triangle).z(), 0) << round;
      sum += AreaOf(points, triangle).z();
    }
    ASSERT_NEAR(sum, area, 1e-12) << round;
  }
  EXPECT_LT(fans, 150) << "most are concave";
}

TEST(CutOfPolygon, ACornerOnAStraightEdgeIsNoTriangleOfItsOwn) {
  const PointsX3 points = Points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {2, 2, 0}, {0, 2, 0}});
  ExpectCovers(points, CutOf(points), 4);
}

TEST(CutOfPolygon, AnyPlaneAndSizeAndABendAreTheSame) {
  PointsX3 dart = Points({{0, 0, 0}, {1, 1, 0.1}, {4, 0, 0}, {1, 4, 0.1}});
  const LocalTriangles cut = CutOf(dart);
  ASSERT_THAT(cut, SizeIs(2));
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2, Eigen::Vector3d(1, -2, 3).normalized()).toRotationMatrix();
  for (const double scale : {1e-9, 1.0, 1e9}) {
    const PointsX3 other = scale * (dart * turn.transpose());
    EXPECT_EQ(CutOf(other), cut) << scale;
  }
}

TEST(CutOfPolygon, WhatNoCutMakesBetterStaysAFan) {
  EXPECT_THAT(CutOf(Points({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}})), IsEmpty()) << "a line";
  EXPECT_THAT(CutOf(Points({{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}})), IsEmpty()) << "a point";
  const LocalTriangles crossed = CutOf(Points({{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 3, 0}}));
  EXPECT_TRUE(crossed.empty() || crossed.size() == 2u);
}

class ConcaveFiles : public ::testing::Test, public TestingFolder {};

/// A prism over the letter U, one corner of which makes a fan that folds over, closed.
constexpr const char* kU = "0 0|3 0|3 3|2 3|2 1|1 1|1 3|0 3";

std::string PrismLines(const char* vertex) {
  std::string text;
  for (const char* z : {" 0\n", " 1\n"}) {
    std::string all = kU;
    for (std::size_t at = 0; at < all.size();) {
      const std::size_t end = std::min(all.find('|', at), all.size());
      text += vertex + all.substr(at, end - at) + z;
      at = end + 1;
    }
  }
  return text;
}

/// Faces of the prism, from `base`.
std::string PrismFaces(const std::string& word, int base, bool with_count) {
  const auto count = [&](int n) { return with_count ? std::to_string(n) : word; };
  std::string text = count(8), top = count(8);
  for (int k = 0; k < 8; ++k) {
    text += " " + std::to_string(base + 7 - k);
    top += " " + std::to_string(base + 8 + k);
  }
  text += "\n" + top + "\n";
  for (int k = 0; k < 8; ++k) {
    const int next = (k + 1) % 8;
    text += count(4);
    for (const int v : {k, next, next + 8, k + 8}) text += " " + std::to_string(base + v);
    text += "\n";
  }
  return text;
}

TEST_F(ConcaveFiles, OfAllFormatsHaveTheRightVolumeAndNoFlippedFace) {
  WriteFile(folder_ / "u.obj", PrismLines("v ") + PrismFaces("f", 1, false));
  WriteFile(folder_ / "u.off", "OFF\n16 10 0\n" + PrismLines("") + PrismFaces("", 0, true));
  WriteFile(folder_ / "u.ply",
            "ply\nformat ascii 1.0\nelement vertex 16\nproperty float x\nproperty "
            "float y\nproperty float z\nelement face 10\nproperty list uchar int "
            "vertex_indices\nend_header\n" +
                PrismLines("") + PrismFaces("", 0, true));
  const FacesX3 faces = ReadMesh(folder_ / "u.obj").faces;
  for (const char* name : {"u.obj", "u.off", "u.ply"}) {
    const Mesh mesh = ReadMesh(folder_ / name);
    ASSERT_EQ(mesh.face_count(), 6 + 6 + 16);
    EXPECT_EQ(mesh.faces, faces) << name;
    EXPECT_TRUE(CheckClosed(mesh).closed());
    EXPECT_NEAR(SignedVolume(mesh.points, mesh.faces), 7, 1e-12);
    double area = 0;
    for (int f = 0; f < mesh.face_count(); ++f) {
      const std::array<int, 3> t = {mesh.faces(f, 0), mesh.faces(f, 1), mesh.faces(f, 2)};
      const Eigen::Vector3d normal = AreaOf(mesh.points, t);
      if (f < 12) {
        EXPECT_GT(f < 6 ? -normal.z() : normal.z(), 0.4) << name << " " << f;
      }
      area += normal.norm();
    }
    EXPECT_NEAR(area, 2 * 7 + 16, 1e-12) << "a flipped face would count twice";
  }
}

TEST_F(ConcaveFiles, TextureCoordinatesAreCutAsTheirVertices) {
  std::string uvs, face = "f";
  for (int k = 0; k < 8; ++k) {
    uvs += "vt " + std::to_string(k) + " 0\n";
    face += " " + std::to_string(k + 1) + "/" + std::to_string(8 - k);
  }
  WriteFile(folder_ / "u.obj", PrismLines("v ") + uvs + "f 1/8 2/7 10/1\n" + face + "\n");
  const ObjFile file = ReadObj(folder_ / "u.obj");
  EXPECT_THAT(file.polygons.sizes, ::testing::ElementsAre(3, 8));
  EXPECT_THAT(file.polygons.corners, ::testing::ElementsAre(0, 1, 9, 0, 1, 2, 3, 4, 5, 6, 7));
  ASSERT_EQ(file.mesh.face_count(), 7);
  for (int f = 1; f < 7; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(file.mesh.uvs(file.mesh.uv_faces(f, k), 0), 7 - file.mesh.faces(f, k));
}

}  // namespace keypose::polygon_cut_test
