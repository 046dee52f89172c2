#include "texture/bake/seam_levelling.h"

#include <gtest/gtest.h>

#include "texture/bake/labels.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::seam_levelling_test {

TEST(LevelSeams, ViewsThatDifferByAConstantMeetHalfWay) {
  const Mesh mesh = PatchSphere(6);
  std::vector<FaceViews> faces(mesh.face_count());
  std::vector<int> labels(mesh.face_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    labels[f] = mesh.points(mesh.faces(f, 0), 2) + mesh.points(mesh.faces(f, 1), 2) +
                    mesh.points(mesh.faces(f, 2), 2) >
                0;
    faces[f].mean = Vector3f(0.4f, 0.4f, 0.4f);
    for (const int view : {0, 1}) {
      const Vector3f color = Vector3f::Constant(view ? 0.6f : 0.3f);
      faces[f].candidates.push_back({view, 1, color.cwiseSqrt(), color, 1, 1});
    }
  }
  const auto shares = VertexShares(mesh, labels);
  for (const double to_mean : {0.0, 1000.0})
    for (const auto& list : LevelSeams(mesh, faces, labels, shares, to_mean)) {
      if (list.size() < 2) continue;
      // At the border both have one colour; with a large weight, the mean.
      EXPECT_NEAR(0.3 + list[0].color[1], 0.6 + list[1].color[1], 0.02);
      if (to_mean > 0) {
        EXPECT_NEAR(0.3 + list[0].color[1], 0.4, 1e-3);
      }
    }
}

}  // namespace keypose::texture::seam_levelling_test
