#include "core/io/meshes/polygon_fan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/surfaces/geometry.h"

namespace keypose::polygon_fan_test {

namespace fs = std::filesystem;

TEST_F(HostileMesh, ObjPolygonOf300CornersKeepsAllOfThem) {
  constexpr int kCorners = 300;
  std::string text, polygon = "f";
  for (int k = 0; k < kCorners; ++k) {
    text += "v " + std::to_string(std::cos(2 * M_PI * k / kCorners)) + " " +
            std::to_string(std::sin(2 * M_PI * k / kCorners)) + " 0\n";
    polygon += " " + std::to_string(kCorners - k);
  }
  text += "v 0 0 1\n" + polygon + "\n";
  for (int k = 0; k < kCorners; ++k)
    text += "f " + std::to_string(k + 1) + " " + std::to_string((k + 1) % kCorners + 1) + " " +
            std::to_string(kCorners + 1) + "\n";
  const Mesh cone = ReadMesh(Put("cone.obj", text));
  EXPECT_EQ(cone.face_count(), kCorners - 2 + kCorners);
  EXPECT_TRUE(CheckClosed(cone).closed());
  EXPECT_NEAR(SignedVolume(cone.points, cone.faces), M_PI / 3, 1e-3);
}

}  // namespace keypose::polygon_fan_test
