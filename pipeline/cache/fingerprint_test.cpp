#include "pipeline/cache/fingerprint.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace keypose::pipeline::fingerprint_test {

Recipe Example() {
  Recipe recipe;
  recipe.stage = "mesh";
  recipe.version = "3";
  recipe.tools = {{"colmap", "3.9"}};
  recipe.options = {{"depth", "9"}, {"trim", "0.1"}};
  recipe.inputs = {{"cloud", "dense/bent.cloud", {"aa", {}}},
                   {"images", "photos/bent", FolderContent({{"a.jpg", "11"}, {"b.jpg", "22"}})}};
  return recipe;
}

TEST(Recipe, EverythingThatDeterminesTheResultChangesTheFingerprint) {
  const std::string before = Example().Fingerprint();
  EXPECT_EQ(before.size(), 64u);
  EXPECT_EQ(before, Example().Fingerprint());
  Recipe changed[5] = {Example(), Example(), Example(), Example(), Example()};
  changed[0].version = "4";
  changed[1].tools["colmap"] = "3.10";
  changed[2].options["depth"] = "10";
  changed[3].inputs[0].content.hash = "ab";
  changed[4].inputs[1].content = FolderContent({{"a.jpg", "11"}, {"c.jpg", "22"}});
  for (const Recipe& recipe : changed) {
    EXPECT_NE(recipe.Fingerprint(), before);
    EXPECT_FALSE(Differences(Example(), recipe).empty());
  }
}

TEST(Recipe, WhereAnInputComesFromDoesNotCount) {
  Recipe moved = Example();
  moved.inputs[0].origin = "elsewhere";
  EXPECT_EQ(moved.Fingerprint(), Example().Fingerprint());
}

TEST(Recipe, ComesBackFromJson) {
  const Recipe back = RecipeFromJson(ToJson(Example()));
  EXPECT_EQ(back.Fingerprint(), Example().Fingerprint());
  EXPECT_TRUE(Differences(Example(), back).empty());
}

TEST(Differences, NamesTheOptionAndThePhotograph) {
  Recipe now = Example();
  now.options["depth"] = "10";
  EXPECT_EQ(Differences(Example(), now), std::vector<std::string>{"option depth: 9 -> 10"});
  now = Example();
  now.inputs[1].content = FolderContent({{"a.jpg", "11"}, {"b.jpg", "33"}});
  EXPECT_EQ(Differences(Example(), now), std::vector<std::string>{"photos/bent/b.jpg changed"});
}

}  // namespace keypose::pipeline::fingerprint_test
