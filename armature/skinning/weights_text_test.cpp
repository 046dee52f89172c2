#include "armature/skinning/weights_text.h"

#include <gtest/gtest.h>

#include "armature/skinning/skin.h"
#include "core/values/errors.h"

namespace keypose::armature::weights_text_test {

std::string FaultOf(const std::string& text) {
  try {
    ParseWeights(text, "w", {"a", "b"}, {0, 1}, 2);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseWeights, ReadsJsonAndDmat) {
  const SkinWeights json = ParseWeights(R"({"weights": {"a": [[0, 2], [1, 1]], "b": [[1, 3]]}})",
                                        "w", {"a", "b"}, {0, 1}, 2);
  EXPECT_EQ(json.weights[0][0], 1);
  EXPECT_EQ(json.bones[1][0], 1);
  EXPECT_NEAR(json.weights[1][0], 0.75, 1e-15);
  const SkinWeights dmat = ParseWeights("2 2\n2 1\n0 3\n", "w", {"a", "b"}, {0, 1}, 2);
  EXPECT_EQ(dmat.weights, json.weights);
  EXPECT_EQ(dmat.bones[1], json.bones[1]);
}

TEST(ParseWeights, SaysWhatIsWrong) {
  EXPECT_NE(FaultOf("{").find("armature: w is not JSON"), std::string::npos);
  EXPECT_NE(FaultOf(R"({"weights": {"a": [[0, 1]]}})").find("vertex 1"), std::string::npos);
  EXPECT_NE(FaultOf("2 2 1 0 1 0").find("vertex 1"), std::string::npos);
}

}  // namespace keypose::armature::weights_text_test
