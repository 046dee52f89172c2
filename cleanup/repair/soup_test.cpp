#include "cleanup/repair/soup.h"

#include <gtest/gtest.h>

#include "cleanup/repair/components.h"

namespace keypose::cleanup::soup_test {

TEST(OrientedManifold, NonManifoldEdgeIsCut) {
  Mesh book;  // three pages on one spine
  book.points.resize(5, 3);
  book.points << 0, 0, 0, 0, 0, 1, 1, 0, 0, 0, 1, 0, -1, -1, 0;
  book.faces.resize(3, 3);
  book.faces << 0, 1, 2, 0, 1, 3, 0, 1, 4;
  const Mesh cut = OrientedManifold(book, 1e-9).mesh;
  EXPECT_EQ(cut.face_count(), 3);
  EXPECT_GT(FindPieces(cut).list.size(), 1u);
}

}  // namespace keypose::cleanup::soup_test
