#include "texture/bake/labels.h"

#include <gtest/gtest.h>

#include "texture/bake/testing_spheres.h"

namespace keypose::texture::labels_test {

TEST(ChooseLabels, OneViewThatIsNearlyTheBestEverywhereTakesAll) {
  const Mesh mesh = PatchSphere(6);
  std::vector<std::vector<LabelCandidate>> candidates(mesh.face_count());
  const Vector3f grey = Vector3f::Constant(0.5f);
  // View 5 is 5 % worse than whichever of nine others is best; but on one patch it is a thousandth
  // as good.
  for (int f = 0; f < mesh.face_count(); ++f) {
    candidates[f].push_back({f % 5, 1.0, grey, grey, 1, 1});
    candidates[f].push_back({5, f < 72 ? 0.001 : 0.95, grey, grey, 1, 1});
  }
  const std::vector<int> labels = ChooseLabels(mesh, candidates);
  for (int f = 0; f < mesh.face_count(); ++f) EXPECT_EQ(labels[f], f >= 72 ? 5 : f % 5) << f;
  candidates[100].clear();
  EXPECT_EQ(ChooseLabels(mesh, candidates)[100], -1);
}

}  // namespace keypose::texture::labels_test
