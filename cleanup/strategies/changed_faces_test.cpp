#include "cleanup/strategies/changed_faces.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"

namespace keypose::cleanup::changed_faces_test {

TEST(ChangedFaces, AreThoseThatOnlyOneHas) {
  const Mesh sphere = MakeIcosphere(2);
  Mesh other = sphere;
  for (int f = 0; f < other.face_count(); ++f)
    other.faces.row(f) << sphere.faces(f, 1), sphere.faces(f, 2), sphere.faces(f, 0);
  EXPECT_EQ(ChangedFaces(sphere, other).face_count(), 0);
  other.points(sphere.faces(0, 0), 0) += 0.01;
  int fan = 0;
  for (int f = 0; f < sphere.face_count(); ++f)
    for (int k = 0; k < 3; ++k) fan += sphere.faces(f, k) == sphere.faces(0, 0);
  EXPECT_EQ(ChangedFaces(sphere, other).face_count(), 2 * fan);
  EXPECT_EQ(ChangedFaces(sphere, Mesh()).face_count(), sphere.face_count());
}

}  // namespace keypose::cleanup::changed_faces_test
