// Weights of bones, from JSON and matrices, and what is said of faults.
#include "core/io/meshes/bone_weights.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::bone_weights_test {

using ::testing::HasSubstr;

const std::vector<std::string> kNames = {"arm", "hand"};

std::string FaultOf(const std::string& text) {
  try {
    ParseBoneWeights(text, "animate: w.mhw", kNames, 2);
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("animate: w.mhw"));
    return error.what();
  }
  ADD_FAILURE() << text << " was read";
  return "";
}

TEST(ParseBoneWeights, JsonAndMatrixSayTheSame) {
  const BoneWeights json = ParseBoneWeights(
      R"({"weights": {"hand": [[1, 3], [0, 0]], "arm": [[0, 2], [1, 1]]}})", "w", kNames, 2);
  EXPECT_EQ(json, (BoneWeights{{{0, 2}}, {{0, 1}, {1, 3}}}));
  EXPECT_EQ(ParseBoneWeights("2 2\n2 1\n0 3\n", "w", kNames, 2), json);
}

TEST(ParseBoneWeights, RoundedZerosAreLeftOut) {
  EXPECT_EQ(ParseBoneWeights("2 2  1 1  -1e-9 0", "w", kNames, 2),
            (BoneWeights{{{0, 1}}, {{0, 1}}}));
}

TEST(ParseBoneWeights, FaultsAreNamed) {
  EXPECT_THAT(FaultOf("{"), HasSubstr("is not JSON with an object `weights`"));
  EXPECT_THAT(FaultOf(R"({"weights": []})"), HasSubstr("is not JSON with an object `weights`"));
  EXPECT_THAT(FaultOf("{" + std::string(200, '[')), HasSubstr("animate"));
  EXPECT_THAT(FaultOf(R"({"weights": {"hamd": []}})"),
              HasSubstr("'hamd' are those of no bone of the skeleton; did you mean 'hand'?"));
  EXPECT_THAT(FaultOf(R"({"weights": {"arm": 3}})"), HasSubstr("are not a list"));
  for (const char* pair : {"[2,1]", "[-1,1]", "[0,-1.0]", "[0]", "[0.5,1]", "[0,\"1\"]"})
    EXPECT_THAT(FaultOf(std::string(R"({"weights": {"arm": [)") + pair + "]}}"),
                HasSubstr(std::string("hold ") + pair));
  EXPECT_THAT(FaultOf("3 2 1 1 1 1 1 1"), HasSubstr("3 columns and 2 rows"));
  EXPECT_THAT(FaultOf("2 2 1 1 1"), HasSubstr("column 1, row 1"));
  EXPECT_THAT(FaultOf("2 2 1 1 -1 1"), HasSubstr("column 1, row 0"));
  EXPECT_THAT(FaultOf("2 2 1 nan 1 1"), HasSubstr("column 0, row 1"));
  EXPECT_THAT(FaultOf(""), HasSubstr("0 columns"));
}

}  // namespace keypose::bone_weights_test
