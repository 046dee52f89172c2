#include "core/io/text/yaml_edit.h"

#include <gtest/gtest.h>

namespace keypose::yaml_edit_test {

const std::string kFile = R"(# our hero
name: hero   # shown
poses:
  rest: photos/rest
  bent: {photos: photos/bent, options: {dense: {levels: 4}}}   # the hard one
# how long
timeline: [rest, bent]

options:
  cleanup: {faces: 12000}  # for the game
  mesh:
    # fuller than usual
    trim: 7
    depth: 9
)";

TEST(YamlEdit, AValueIsReplacedAndEverythingElseStays) {
  std::string expected = kFile;
  expected.replace(expected.find("12000"), 5, "8000");
  EXPECT_EQ(WithValue(kFile, {"options", "cleanup", "faces"}, "8000"), expected);
}

TEST(YamlEdit, AValueInABlockIsReplaced) {
  std::string expected = kFile;
  expected.replace(expected.find("trim: 7"), 7, "trim: 8");
  EXPECT_EQ(WithValue(kFile, {"options", "mesh", "trim"}, "8"), expected);
}

TEST(YamlEdit, ANewOptionJoinsAFlowMap) {
  std::string expected = kFile;
  expected.replace(expected.find("12000}"), 6, "12000, close: true}");
  EXPECT_EQ(WithValue(kFile, {"options", "cleanup", "close"}, "true"), expected);
}

TEST(YamlEdit, ANewStepJoinsABlockMapAtItsEnd) {
  EXPECT_EQ(WithValue(kFile, {"options", "dense", "levels"}, "3"),
            kFile + "  dense: {levels: 3}\n");
}

TEST(YamlEdit, ANewRootKeyIsAddedAtTheEnd) {
  EXPECT_EQ(WithValue(kFile,
                      {
                          "fps",
                      },
                      "25"),
            kFile + "fps: 25\n");
  EXPECT_EQ(WithValue("", {"options", "dense", "levels"}, "3"), "options: {dense: {levels: 3}}\n");
  EXPECT_EQ(WithValue("a: 1", {"b"}, "2"), "a: 1\nb: 2\n");
}

TEST(YamlEdit, WhatIsNoMapIsRefused) {
  for (const char* text : {"hero", "- rest\n- bent\n", "[1, 2]"}) {
    EXPECT_THROW(WithValue(text, {"fps"}, "25"), YamlEditError) << text;
    EXPECT_THROW(WithoutValue(text, {"fps"}), YamlEditError) << text;
  }
}

TEST(YamlEdit, OtherBytesThanUtf8StayAsTheyAre) {
  EXPECT_EQ(WithValue("name: J\xFCrgen\nfps: 24\n", {"fps"}, "25"), "name: J\xFCrgen\nfps: 25\n");
}

TEST(YamlEdit, SpacesAtTheVeryEndDoNoHarm) {
  EXPECT_EQ(WithValue("a:\n  b: 1\n  ", {"a", "c"}, "2"), "a:\n  b: 1\n  c: 2\n  ");
}

TEST(YamlEdit, APosesOptionIsReplaced) {
  std::string expected = kFile;
  expected.replace(expected.find("levels: 4"), 9, "levels: 5");
  EXPECT_EQ(WithValue(kFile, {"poses", "bent", "options", "dense", "levels"}, "5"), expected);
}

TEST(YamlEdit, AScalarOnTheWayIsAnError) {
  EXPECT_THROW(WithValue(kFile, {"poses", "rest", "options", "dense", "levels"}, "5"),
               YamlEditError);
}

TEST(YamlEdit, ARemovedValueTakesItsEmptyMapsAlong) {
  std::string expected = kFile;
  expected.erase(expected.find("  cleanup"),
                 std::string("  cleanup: {faces: 12000}  # for the game\n").size());
  EXPECT_EQ(WithoutValue(kFile, {"options", "cleanup", "faces"}), expected);
  expected = kFile;
  expected.erase(expected.find(", options"), std::string(", options: {dense: {levels: 4}}").size());
  EXPECT_EQ(WithoutValue(kFile, {"poses", "bent", "options", "dense", "levels"}), expected);
}

TEST(YamlEdit, RemovingWhatIsNotThereChangesNothing) {
  EXPECT_EQ(WithoutValue(kFile, {"options", "bake", "size"}), kFile);
}

TEST(YamlEdit, EveryOptionThatIsSetAndRemovedLeavesTheFileAsItWas) {
  for (const YamlPath& path : {YamlPath{"options", "bake", "size"}, YamlPath{"fps"},
                               YamlPath{"options", "cleanup", "close"},
                               YamlPath{"poses", "bent", "options", "bake", "size"}})
    EXPECT_EQ(WithoutValue(WithValue(kFile, path, "5"), path), kFile) << path.back();
}

TEST(YamlEdit, ItemsThatStayKeepTheirLineAndComment) {
  const std::string text =
      "timeline:\n  loop: true\n  keys:\n    - {pose: rest, at: 0}   # calm\n"
      "    # the jump\n    - {pose: bent, at: 0.5}\n    - rest\nfps: 24\n";
  EXPECT_EQ(WithItems(text, {"timeline", "keys"},
                      {"{pose: rest, at: 0}", "{pose: bent, at: 0.75}", "rest"}),
            "timeline:\n  loop: true\n  keys:\n    - {pose: rest, at: 0}   # calm\n"
            "    # the jump\n    - {pose: bent, at: 0.75}\n    - rest\nfps: 24\n");
  EXPECT_EQ(WithItems(text, {"timeline", "keys"}, {"{pose: rest, at: 0}", "rest"}),
            "timeline:\n  loop: true\n  keys:\n    - {pose: rest, at: 0}   # calm\n"
            "    - rest\nfps: 24\n");
  EXPECT_EQ(WithItems(kFile, {"timeline"}, {"bent", "rest"}).find("timeline: [bent, rest]") !=
                std::string::npos,
            true);
}

TEST(YamlEdit, ItemsThatMoveBesideNewOnesKeepTheirComments) {
  const std::string text =
      "keys:\n  - {pose: rest, at: 0, hold: 0.5}   # she listens\n"
      "  # the jump\n  - {pose: bent, at: 1}\n  - {pose: rest, at: 2}   # back\n";
  EXPECT_EQ(WithItems(text, {"keys"},
                      {"{pose: rest, at: 0, hold: 0.25}", "{pose: wave, at: 0.25}",
                       "{pose: bent, at: 1.5}", "{pose: rest, at: 2.5}"}),
            "keys:\n  - {pose: rest, at: 0, hold: 0.25}   # she listens\n"
            "  - {pose: wave, at: 0.25}\n"
            "  # the jump\n  - {pose: bent, at: 1.5}\n  - {pose: rest, at: 2.5}   # back\n");
}

TEST(YamlEdit, ItemsOfSeveralLinesKeepThem) {
  const std::string text =
      "timeline:\n  keys:\n  # asleep\n  - pose: rest\n    at: 0        # the first frame\n"
      "    ease: in\n\n  - pose: bent   # awake\n    at: 1\nfps: 24\n";
  EXPECT_EQ(
      WithItems(text, {"timeline", "keys"},
                {"{pose: rest, at: 0, hold: 2}", "{pose: bent, at: 3}", "{pose: rest, at: 4}"}),
      "timeline:\n  keys:\n  # asleep\n  - pose: rest\n    at: 0        # the first frame\n"
      "    hold: 2\n\n  - pose: bent   # awake\n    at: 3\n  - {pose: rest, at: 4}\nfps: 24\n");
}

TEST(YamlEdit, AListBecomesAMapInItsPlaceWithItsComments) {
  EXPECT_EQ(WithListUnder("a: 1\n# how long\ntimeline:   # of the film\n  # asleep\n  - rest\n"
                          "  - bent   # awake\nfps: 24\n",
                          {"timeline"}, "keys"),
            "a: 1\n# how long\ntimeline:   # of the film\n  keys:\n    # asleep\n    - rest\n"
            "    - bent   # awake\nfps: 24\n");
  EXPECT_EQ(WithListUnder("timeline:\n- rest\n- bent\nfps: 24\n", {"timeline"}, "keys"),
            "timeline:\n  keys:\n  - rest\n  - bent\nfps: 24\n");
  EXPECT_EQ(WithListUnder("timeline: [rest, {pose: bent, at: 1}]  # two\n\nfps: 24\n", {"timeline"},
                          "keys"),
            "timeline:  # two\n  keys:\n    - rest\n    - {pose: bent, at: 1}\n\nfps: 24\n");
  EXPECT_EQ(WithListUnder("timeline: [rest, bent]", {"timeline"}, "keys"),
            "timeline:\n  keys:\n    - rest\n    - bent\n");
  EXPECT_THROW(WithListUnder("timeline: {keys: [a]}\n", {"timeline"}, "keys"), YamlEditError);
  EXPECT_THROW(WithListUnder("a: 1\n", {"timeline"}, "keys"), YamlEditError);
}

TEST(YamlEdit, TextsAreQuotedWhereYamlWouldReadSomethingElse) {
  EXPECT_EQ(YamlScalar("photos/rest"), "photos/rest");
  EXPECT_EQ(YamlScalar("-0.5"), "-0.5");
  EXPECT_EQ(YamlScalar("a: b"), "\"a: b\"");
  EXPECT_EQ(YamlScalar("off"), "\"off\"");
  EXPECT_EQ(YamlScalar("[x]"), "\"[x]\"");
  EXPECT_EQ(YamlScalar(""), "\"\"");
  EXPECT_EQ(YamlScalar("--- evil"), "\"--- evil\"");
}

TEST(YamlEdit, UnusualFormsAreRefusedNotDamaged) {
  EXPECT_THROW(WithValue("a: &x {b: 1}\nc: *x\n", {"c", "b"}, "2"), YamlEditError);
  EXPECT_THROW(WithValue("---\na: 1\n", {"a"}, "2"), YamlEditError);
  EXPECT_THROW(WithValue("a: [1, 2\n", {"b"}, "2"), YamlEditError);
}

TEST(YamlEdit, LineEndsOfWindowsAndMissingLastLineEndAreKept) {
  EXPECT_EQ(WithValue("a: 1\r\nb: 2\r\n", {"a"}, "3"), "a: 3\r\nb: 2\r\n");
  EXPECT_EQ(WithValue("a: {b: 1}", {"a", "b"}, "3"), "a: {b: 3}");
}

}  // namespace keypose::yaml_edit_test
