#include "composite/composing/lessons.h"

#include <gtest/gtest.h>

namespace keypose::composite::lessons_test {

TEST(Looks, TexturesAreMixedByTheirWeights) {
  Looks looks;
  looks.textures = {ImageF(2, 2, 3, 0.2f), ImageF(2, 2, 3, 0.6f)};
  EXPECT_FLOAT_EQ(looks.At(1).texture.data[3], 0.2f);
  looks.weights = {{1, 0}, {0.25, 0.75}};
  EXPECT_FLOAT_EQ(looks.At(0).texture.data[3], 0.2f);
  EXPECT_FLOAT_EQ(looks.At(1).texture.data[3], 0.5f);
}

}  // namespace keypose::composite::lessons_test
