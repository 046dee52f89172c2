#include "core/io/text/pose_yaml.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/yaml_edit.h"

namespace keypose::pose_yaml_test {

using ::testing::ElementsAre;

constexpr char kFile[] =
    "# our hero\nposes:\n  # asleep\n  rest: photos/rest   # first\n  wave:\n    photos: "
    "photos/wave\n    method: fit\n\n  # at the end\n  \"bow\": {photos: b}\ntemplate: rest   # "
    "most "
    "open\n";

TEST(PoseYaml, APoseOfFewPhotographsSaysHowItIsFound) {
  EXPECT_EQ(WithPose("poses:\n  rest: photos/rest\ntemplate: rest\n", "wave", true),
            "poses:\n  rest: photos/rest\n  wave: {photos: photos/wave, method: fit}\n"
            "template: rest\ntimeline: [rest, wave]\n");
  EXPECT_EQ(WithPose("name: fox\n", "rest", false),
            "name: fox\nposes: {rest: photos/rest}\ntemplate: rest\n");
  EXPECT_THROW(WithPose("poses: {a: b}\n", "a", false), YamlEditError);
}

TEST(PoseYaml, ANewNameIsTakenOverEverywhere) {
  EXPECT_EQ(
      WithPoseRenamed("poses: {rest: photos/rest, 'wave': w}\ntemplate: \"rest\"   # t\n"
                      "timeline:\n  keys:\n    - {pose: rest, at: 0}   # calm\n    - {pose: wave, "
                      "at: 1}\n    - {pose: rest, at: 2}\nshot: {film: f, shows: {0: rest, 4: "
                      "wave}}\n",
                      "rest", "sits"),
      "poses: {sits: photos/rest, 'wave': w}\ntemplate: sits   # t\n"
      "timeline:\n  keys:\n    - {pose: sits, at: 0}   # calm\n    - {pose: wave, "
      "at: 1}\n    - {pose: sits, at: 2}\nshot: {film: f, shows: {0: sits, 4: wave}}\n");
  EXPECT_EQ(WithPoseRenamed("poses:\n  a: p\n  b: q\ntimeline: [a, b, a]\n", "a", "no"),
            "poses:\n  \"no\": p\n  b: q\ntimeline: [\"no\", b, \"no\"]\n");
  EXPECT_THROW(WithPoseRenamed(kFile, "rest", "wave"), YamlEditError);
  EXPECT_THROW(WithPoseRenamed(kFile, "none", "x"), YamlEditError);
}

TEST(PoseYaml, AnotherOrderTakesTheCommentsAlong) {
  EXPECT_EQ(WithPoseOrder(kFile, {"bow", "wave", "rest"}),
            "# our hero\nposes:\n\n  # at the end\n  \"bow\": {photos: b}\n  wave:\n    photos: "
            "photos/wave\n    method: fit\n  # asleep\n  rest: photos/rest   # first\ntemplate: "
            "rest   # most open\n");
  EXPECT_EQ(
      WithPoseOrder("poses: {a: 1, b: {c: 2},  d: 3}  # x\ntimeline: [a, b, d]\n", {"d", "a", "b"}),
      "poses: {d: 3, a: 1,  b: {c: 2}}  # x\ntimeline: [d, a, b]\n");
  EXPECT_EQ(WithPoseOrder("timeline: [a, b, a]\nposes:\n  a: 1\n  b: 2", {"b", "a"}),
            "timeline: [a, b, a]\nposes:\n  b: 2\n  a: 1\n");
  EXPECT_THROW(WithPoseOrder(kFile, {"bow", "rest"}), YamlEditError);
}

TEST(PoseYaml, WithoutAPoseItsKeysAreGone) {
  EXPECT_EQ(WithoutPose("poses: {a: 1, b: 2, c: 3}\ntimeline: [a, b, c]\n", "b"),
            "poses: {a: 1, c: 3}\ntimeline: [a, c]\n");
  EXPECT_EQ(WithoutPose("poses: {a: 1, b: 2}\ntimeline: [a, b]\n", "b"), "poses: {a: 1}\n");
  EXPECT_EQ(WithoutPose("poses:\n  a: 1\n  b: 2\ntimeline:\n  keys:\n    - {pose: a, at: 0}   # x\n"
                        "    - {pose: b, at: 1}\n    - {pose: a, at: 2}\n",
                        "b"),
            "poses:\n  a: 1\ntimeline:\n  keys:\n    - {pose: a, at: 0}   # x\n"
            "    - {pose: a, at: 2}\n");
  EXPECT_EQ(WithoutPose("poses: {a: 1, b: 2}\nshot: {film: f, shows: {0: a, 4: b}}\n", "b"),
            "poses: {a: 1}\nshot: {film: f, shows: {0: a}}\n");
}

TEST(PoseYaml, APoseThatComesBackHasItsKeysAgain) {
  const std::string before =
      "poses:\n  a: 1\n  b: 2   # bent\n  c: 3\ntimeline:\n  loop: true\n  keys:\n"
      "    - {pose: a, at: 0}\n    - {pose: b, at: 0.5, hold: 0.2}   # x\n    - {pose: c, at: 2}\n";
  const std::string left = WithoutPose(before, "b");
  EXPECT_EQ(WithPoseBack(left, "b", before), before) << "comments and order, too";
  EXPECT_EQ(WithPoseBack(left + "fps: 12\n", "b", before),
            "poses:\n  a: 1\n  c: 3\n  b: 2\ntimeline:\n  loop: true\n  keys:\n"
            "    - {pose: a, at: 0}\n    - {pose: b, at: 0.5, hold: 0.2}\n    - {pose: c, at: 2}\n"
            "fps: 12\n");
  const std::string moved = WithValue(left, {"timeline", "keys"}, "[{pose: a, at: 1}]");
  EXPECT_THAT(WithPoseBack(moved, "b", before), testing::HasSubstr("keys: [{pose: a, at: 1}]\n"))
      << "a timeline that was changed since stays as it is";
  EXPECT_EQ(
      WithPoseBack("poses: {a: 1}\nfps: 12\n", "b", "poses: {a: 1, b: 2}\ntimeline: [b, a, b]\n"),
      "poses: {a: 1, b: 2}\nfps: 12\n");
  EXPECT_EQ(WithPoseBack("poses: {a: 1}\nfps: 12\ntimeline: [a]\n", "b",
                         "poses: {a: 1, b: 2}\ntimeline: [b, a, b]\n"),
            "poses: {a: 1, b: 2}\nfps: 12\ntimeline: [b, a, b]\n");
  EXPECT_EQ(WithPoseBack("poses: {a: 1}\nshot: {film: f, shows: {0: a}}\nfps: 12\n", "b",
                         "poses: {a: 1, b: 2}\nshot: {film: f, shows: {0: a, 4: b}}\n"),
            "poses: {a: 1, b: 2}\nshot: {film: f, shows: {0: a, 4: b}}\nfps: 12\n");
  EXPECT_THROW(WithPoseBack("poses: {a: 1, b: 2, c: 3}\n", "b", before), YamlEditError);
}

TEST(PoseYaml, TheWayToFindAPoseIsChanged) {
  EXPECT_EQ(TemplateIn("poses: {a: 1, b: 2}\n"), "a");
  EXPECT_EQ(TemplateIn("poses: {a: 1, b: 2}\ntemplate: b\n"), "b");
  EXPECT_EQ(MethodIn(kFile, "wave"), "fit");
  EXPECT_EQ(MethodIn(kFile, "rest"), "");
  EXPECT_EQ(WithMethod("poses:\n  a: x/y   # c\n  b:\n", "a", "fit"),
            "poses:\n  a: {photos: x/y, method: fit}   # c\n  b:\n");
  EXPECT_EQ(WithMethod("poses:\n  b:\n", "b", "fit"),
            "poses:\n  b: {photos: photos/b, method: fit}\n");
  EXPECT_EQ(WithMethod("poses: {b: {method: fit, photos: p}}\n", "b", ""),
            "poses: {b: {photos: p}}\n");
}

TEST(PoseYaml, AValueComesBackInOneLine) {
  const std::string value = PoseValue(kFile, "wave");
  EXPECT_EQ(value, "{photos: photos/wave, method: fit}");
  EXPECT_EQ(PoseValue("poses: {a: {options: {x: \"24\", z: 24}}}", "a"),
            "{options: {x: \"24\", z: 24}}");
  EXPECT_THAT(PosesIn(WithValue(WithoutPose(kFile, "wave"), {"poses", "wave"}, value)),
              ElementsAre("rest", "bow", "wave"));
}

}  // namespace keypose::pose_yaml_test
