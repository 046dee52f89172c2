#include "core/values/union_find.h"

#include <gtest/gtest.h>

namespace keypose::union_find_test {

TEST(UnionFind, TheLowestMemberNamesASetInAnyOrderOfJoining) {
  UnionFind rising(6), falling(6);
  for (int i = 1; i < 4; ++i) EXPECT_TRUE(rising.Join(i, i + 1));
  for (int i = 3; i > 0; --i) EXPECT_TRUE(falling.Join(i + 1, i));
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(rising.Find(i), i >= 1 && i <= 4 ? 1 : i);
    EXPECT_EQ(falling.Find(i), rising.Find(i));
  }
}

TEST(UnionFind, JoiningWhatIsTogetherChangesNothing) {
  UnionFind sets(3);
  EXPECT_TRUE(sets.Join(2, 0));
  EXPECT_FALSE(sets.Join(0, 2));
  EXPECT_FALSE(sets.Join(1, 1));
  EXPECT_EQ(sets.Find(1), 1);
}

}  // namespace keypose::union_find_test
