#include "armature/example/theropod_body.h"

#include <gtest/gtest.h>

#include "armature/example/theropod.h"
#include "core/surfaces/geometry.h"

namespace keypose::armature::theropod_body_test {

TEST(MakeTheropodBody, IsOfClosedSurfacesAndALittleMoreThanTheAskedVertices) {
  for (const int vertices : {1000, 4000}) {
    const Mesh body = MakeTheropodBody(vertices);
    EXPECT_GE(body.points.rows(), vertices);
    EXPECT_LT(body.points.rows(), 1.3 * vertices);
    EXPECT_EQ(body.colors.rows(), body.points.rows());
    EXPECT_TRUE(CheckClosed(body).closed());
    EXPECT_GT(SignedVolume(body.points, body.faces), 0);  // normals point outwards
  }
}

TEST(MakeTheropodBody, ItsBoxHoldsTheSkeletonsTrunk) {
  const Mesh body = MakeTheropodBody(1000);
  const auto frames = JointFrames(MakeTheropodSkeleton(), 0);
  const MotionClip skeleton = MakeTheropodSkeleton();
  for (const char* name : {"Hips", "Neck1", "Tail1"}) {
    const int joint = skeleton.Find(name);
    ASSERT_GE(joint, 0) << name;
    const Eigen::Vector3d at = frames[static_cast<std::size_t>(joint)].translation;
    EXPECT_TRUE((at.transpose().array() > body.points.colwise().minCoeff().array()).all()) << name;
    EXPECT_TRUE((at.transpose().array() < body.points.colwise().maxCoeff().array()).all()) << name;
  }
}

}  // namespace keypose::armature::theropod_body_test
