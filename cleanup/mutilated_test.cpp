// The guarantee: any damaged mesh becomes closed, oriented and free of self-intersections, or is
// refused with the reason.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "cleanup/repair/intersections.h"
#include "cleanup/strategies/cleanup.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::cleanup::mutilated_test {

constexpr int kMeshes = 1000;
constexpr int kFaces = 1500;

bool Finite(const Mesh& mesh) { return mesh.points.allFinite(); }

TEST(MakeClosedManifold, MutilatedMeshesComeOutClosedOrAreRefused) {
  std::map<std::string, int> outcomes;
  int slivers = 0, handles = 0;
  CleanupOptions options;
  options.faces = kFaces;
  for (int i = 0; i < kMeshes; i += KEYPOSE_MUTILATED_STEP) {
    const DamagedMesh mutilated = MakeDamagedMesh(i);
    SCOPED_TRACE(std::to_string(i) + " " + mutilated.description);
    try {
      const CleanupResult once = MakeClosedManifold(mutilated.mesh, options);
      ++outcomes[once.strategy];
      EXPECT_TRUE(Finite(mutilated.mesh));
      EXPECT_TRUE(CheckClosed(once.mesh).closed());
      EXPECT_EQ(CheckClosed(once.mesh).components, 1);
      EXPECT_FALSE(SelfIntersects(once.mesh));
      EXPECT_LE(once.mesh.face_count(), 1.01 * kFaces);
      slivers += once.min_angle_deg < 2;
      handles += once.genus > 0;
      const CleanupResult twice = MakeClosedManifold(once.mesh, options);
      EXPECT_TRUE(twice.mesh.faces.rows() == once.mesh.faces.rows() &&
                  twice.mesh.faces == once.mesh.faces);
      EXPECT_TRUE(twice.mesh.points.rows() == once.mesh.points.rows() &&
                  twice.mesh.points == once.mesh.points);
    } catch (const InputError& error) {
      ++outcomes["refused"];
      EXPECT_FALSE(Finite(mutilated.mesh)) << error.what();
      EXPECT_NE(std::string(error.what()).find("not finite"), std::string::npos) << error.what();
    }
  }
  for (const auto& [name, count] : outcomes) std::printf("%5d %s\n", count, name.c_str());
  std::printf("%5d with an angle below 2 degrees, %d with a handle left\n", slivers, handles);
  EXPECT_LE(slivers, kMeshes / KEYPOSE_MUTILATED_STEP / 100);
  EXPECT_LE(handles, kMeshes / KEYPOSE_MUTILATED_STEP / 100);
}

}  // namespace keypose::cleanup::mutilated_test
