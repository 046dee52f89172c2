#include "motion/reconstruct/face_fans.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "core/surfaces/shapes.h"

namespace keypose::motion::face_fans_test {

using Corners = std::array<int, 3>;

/// From the lowest corner on, so that a face is the same from whichever corner it is read.
Corners Canonical(Corners face) {
  std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

std::vector<Corners> FacesOf(const FaceFans& fans) {
  std::vector<Corners> faces;
  for (int f = 0; f < fans.count(); ++f)
    for (int k = fans.begin[f]; k + 1 < fans.begin[f + 1]; ++k)
      if (fans.chain[k] != fans.centre[f] && fans.chain[k + 1] != fans.centre[f])
        faces.push_back(Canonical({fans.centre[f], fans.chain[k], fans.chain[k + 1]}));
  std::sort(faces.begin(), faces.end());
  return faces;
}

std::vector<Corners> Repeated(const FacesX3& faces, int times) {
  std::vector<Corners> repeated;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    repeated.insert(repeated.end(), times, Canonical({faces(f, 0), faces(f, 1), faces(f, 2)}));
  std::sort(repeated.begin(), repeated.end());
  return repeated;
}

std::vector<int> AllVertices(int count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return all;
}

TEST(FaceFans, HoldEachFaceAtAllCornersOrAtOne) {
  const Mesh ball = MakeIcosphere(2);
  const std::vector<int> all = AllVertices(ball.vertex_count());
  const FaceFans around = FansOfVertices(ball.faces, ball.vertex_count(), all),
                 once = FansOfFaces(ball.faces, ball.vertex_count(), all);
  EXPECT_EQ(FacesOf(around), Repeated(ball.faces, 3));
  EXPECT_EQ(FacesOf(once), Repeated(ball.faces, 1));
  // Closed rings: a neighbour for each face, and the first again.
  EXPECT_EQ(around.chain.size(), 3 * ball.faces.rows() + ball.vertex_count());
  EXPECT_LT(once.chain.size(), 2 * ball.faces.rows());
}

TEST(FaceFans, ChainsOfOneVertexAreJoinedByIt) {
  // Two faces that share no more than vertex 0.
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 0, 3, 4;
  const FaceFans fans = FansOfVertices(faces, 5, {0});
  EXPECT_EQ(fans.chain, (std::vector<int>{1, 2, 0, 3, 4}));
  EXPECT_EQ(FacesOf(fans), Repeated(faces, 1));
}

TEST(FaceFans, VerticesThatAreNotListedHaveNone) {
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 3, 4, 5;
  EXPECT_EQ(FacesOf(FansOfFaces(faces, 6, {3, 4, 5})), (std::vector<Corners>{{3, 4, 5}}));
}

}  // namespace keypose::motion::face_fans_test
