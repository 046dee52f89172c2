#include "reconstruct/refinement/photo_profile.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "reconstruct/refinement/testing/wavy_surface.h"

namespace keypose::reconstruct::photo_profile_test {

TEST(CostProfiles, TheLeastCostIsAtTheTrueSurface) {
  const std::vector<PreparedView> views = Views(Painted());
  const Mesh mesh = Wavy(Painted(), 0);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const std::vector<VertexViews> chosen =
      ChooseViews(mesh.points, views, AllSights(mesh, normals, views));
  const Profiles profiles =
      CostProfiles(mesh.points, normals, chosen, views, 0, 8, 0.5 * Painted().footprint);
  int compared = 0, central = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const float* row = profiles.Row(v);
    const int least = static_cast<int>(std::min_element(row, row + profiles.count()) - row);
    if (row[least] >= 0.3f) continue;
    ++compared, central += std::abs(least - profiles.steps) <= 1;
  }
  EXPECT_GT(compared, mesh.vertex_count() / 2);
  EXPECT_GT(central, 0.95 * compared);
}

TEST(CostProfiles, VectorCodeMeasuresWhatPlainLoopsMeasure) {
  const std::vector<PreparedView> views = Views(Painted());
  const Mesh mesh = Wavy(Painted(), 1);
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const std::vector<VertexViews> chosen =
      ChooseViews(mesh.points, views, AllSights(mesh, normals, views));
  const Profiles fast =
      CostProfiles(mesh.points, normals, chosen, views, 1, 3, Painted().footprint);
  const Profiles plain =
      CostProfilesPlain(mesh.points, normals, chosen, views, 1, 3, Painted().footprint);
  float largest = 0;
  for (std::size_t i = 0; i < fast.cost.size(); ++i)
    largest = std::max(largest, std::abs(fast.cost[i] - plain.cost[i]));
  EXPECT_LT(largest, 1e-4f);
}

}  // namespace keypose::reconstruct::photo_profile_test
