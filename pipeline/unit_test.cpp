// Tests of the runner's parts: option values, stage descriptions, hashes, differences, estimates,
// the real disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "pipeline/cache/fingerprint.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/graph/pipeline_file.h"
#include "pipeline/graph/pipeline_overlay.h"
#include "pipeline/graph/stage_info.h"
#include "pipeline/run/results_folder.h"
#include "pipeline/run/work_size.h"
#include "pipeline/testing/memory_disk.h"
#include "pipeline/testing/message_of.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline::unit_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

OptionInfo NumberOption(const std::string& type) {
  OptionInfo option;
  option.name = "size";
  option.type = type;
  option.unit = "px";
  option.min = 1;
  option.max = 10;
  return option;
}

TEST(Sha256, KnownAnswers) {
  EXPECT_EQ(Sha256Of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(Sha256Of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(CanonicalOption, OneTextForAllSpellingsOfAValue) {
  EXPECT_EQ(CanonicalOption(NumberOption("double"), "2.50"), "2.5");
  EXPECT_EQ(CanonicalOption(NumberOption("double"), "+25e-1"), "2.5");
  EXPECT_EQ(CanonicalOption(NumberOption("double"), "3"), "3");
  EXPECT_EQ(CanonicalOption(NumberOption("int"), "007"), "7");
  OptionInfo flag;
  flag.name = "flag";
  flag.type = "bool";
  for (const char* text : {"true", "True", "yes", "on", "1"})
    EXPECT_EQ(CanonicalOption(flag, text), "true");
  for (const char* text : {"false", "No", "off", "0"})
    EXPECT_EQ(CanonicalOption(flag, text), "false");
}

TEST(CanonicalOption, FaultsSayWhatIsAllowed) {
  EXPECT_EQ(MessageOf<UsageError>([] { CanonicalOption(NumberOption("int"), "11"); }),
            "option 'size' is 11, but it must be between 1 and 10 px");
  EXPECT_THAT(MessageOf<UsageError>([] { CanonicalOption(NumberOption("int"), "2.5"); }),
              HasSubstr("must be a whole number"));
  EXPECT_THAT(MessageOf<UsageError>([] { CanonicalOption(NumberOption("double"), "nan"); }),
              HasSubstr("must be a number"));
  EXPECT_THAT(MessageOf<UsageError>([] { CanonicalOption(NumberOption("double"), ""); }),
              HasSubstr("must be a number"));
  OptionInfo choice;
  choice.name = "method";
  choice.type = "string";
  choice.choices = {"arap", "linear"};
  EXPECT_EQ(MessageOf<UsageError>([&] { CanonicalOption(choice, "arp"); }),
            "option 'method' is 'arp', but it must be one of arap, linear");
}

TEST(ParseStageInfo, TitleAndMeasurementsAreOptional) {
  const std::string head = R"({"schema":1,"stage":"polish","version":1,"inputs":[],"outputs":[])";
  const StageInfo plain = ParseStageInfo(head + "}", "p");
  EXPECT_EQ(plain.title, "polish");
  EXPECT_TRUE(plain.measurements.empty());
  const StageInfo told = ParseStageInfo(
      head + R"(,"title":"Polish","measurements":[{"key":"shine","unit":"dB","good":{"min":20}}]})",
      "p");
  EXPECT_EQ(told.title, "Polish");
  ASSERT_EQ(told.measurements.size(), 1u);
  EXPECT_EQ(told.measurements[0].label, "shine");
  EXPECT_EQ(told.measurements[0].good_min, 20);
  EXPECT_EQ(told.measurements[0].good_max, std::nullopt);
}

TEST(ParseStageInfo, BrokenDescriptionsNameTheProgramAndTheField) {
  EXPECT_THAT(MessageOf<ToolError>([] { ParseStageInfo("hello", "/x/keypose-y"); }),
              HasSubstr("/x/keypose-y"));
  EXPECT_THAT(MessageOf<ToolError>([] { ParseStageInfo("{}", "p"); }), HasSubstr("schema"));
  const std::string head = R"({"schema":1,"stage":"s","version":"1","inputs":[],"outputs":[)";
  EXPECT_THAT(
      MessageOf<ToolError>([&] { ParseStageInfo(head + R"({"name":"a","kind":"thing"}]})", "p"); }),
      HasSubstr("kind 'thing'"));
  EXPECT_THAT(
      MessageOf<ToolError>([&] { ParseStageInfo(head + R"({"name":"a","file":"../x"}]})", "p"); }),
      HasSubstr("plain name"));
  EXPECT_THAT(MessageOf<ToolError>([&] {
                ParseStageInfo(head + R"({"name":"a","file":"x"},{"name":"b","file":"x"}]})", "p");
              }),
              HasSubstr("two outputs have the file 'x'"));
  EXPECT_THAT(MessageOf<ToolError>([&] {
                ParseStageInfo(head + R"(],"options":[{"name":"o","type":"int","default":"x"}]})",
                               "p");
              }),
              HasSubstr("whole number"));
}

Recipe SomeRecipe() {
  Recipe recipe{"mesh", "1", {{"colmap", "3.8"}}, {{"depth", "9"}}, {}};
  recipe.inputs.push_back({"cloud", "dense/rest.cloud", {"aaaa", {}}});
  recipe.inputs.push_back(
      {"images", "photos/rest", FolderContent({{"a.jpg", "1"}, {"b.jpg", "2"}})});
  return recipe;
}

TEST(Recipe, FingerprintFollowsContentAndNotOrigin) {
  const std::string before = SomeRecipe().Fingerprint();
  EXPECT_EQ(before.size(), 64u);
  Recipe moved = SomeRecipe();
  moved.inputs[0].origin = "elsewhere";
  EXPECT_EQ(moved.Fingerprint(), before);
  std::vector<Recipe> changed(6, SomeRecipe());
  changed[0].stage = "mush";
  changed[1].version = "2";
  changed[2].tools["colmap"] = "3.9";
  changed[3].options["depth"] = "10";
  changed[4].inputs[0].content.hash = "aaab";
  changed[5].inputs[0].port = "clouds";
  for (const Recipe& recipe : changed) EXPECT_NE(recipe.Fingerprint(), before);
}

TEST(Recipe, NoTwoFieldListsRunTogether) {
  Recipe a{"s", "1", {}, {{"x", "1"}, {"y", "2"}}, {}}, b{"s", "1", {{"x", "1"}}, {{"y", "2"}}, {}},
      c{"s1", "", {}, {{"x", "1"}, {"y", "2"}}, {}};
  EXPECT_NE(a.Fingerprint(), b.Fingerprint());
  EXPECT_NE(a.Fingerprint(), c.Fingerprint());
}

TEST(Differences, EachInPlainWords) {
  EXPECT_TRUE(Differences(SomeRecipe(), SomeRecipe()).empty());
  Recipe now = SomeRecipe();
  now.version = "2";
  now.tools["colmap"] = "3.9";
  now.options = {{"depth", "10"}, {"trim", "7"}};
  now.inputs[0].content.hash = "bbbb";
  now.inputs[1].content = FolderContent({{"a.jpg", "9"}, {"c.jpg", "3"}});
  EXPECT_THAT(Differences(SomeRecipe(), now),
              ElementsAre("the stage's version: 1 -> 2", "version of the tool colmap: 3.8 -> 3.9",
                          "option depth: 9 -> 10", "option trim is new: 7",
                          "dense/rest.cloud changed", "photos/rest/a.jpg changed",
                          "photos/rest/b.jpg is gone", "photos/rest/c.jpg is new"));
}

TEST(Differences, WhatCameAndWentIsToldOfItsOwnInputOnly) {
  const auto input = [](const std::string& port, const std::string& origin) {
    return RecipeInput{port, origin, {origin + " as it is", {}}};
  };
  Recipe before{"blend", "1", {}, {}, {}}, now = before;
  before.inputs = {input("keys", "rest"), input("keys", "bent"), input("timeline", "the timeline")};
  now.inputs = {input("keys", "rest"), input("keys", "wave"), input("keys", "bent"),
                input("timeline", "the timeline")};
  EXPECT_THAT(Differences(before, now), ElementsAre("input keys now also gets wave"));
  EXPECT_THAT(Differences(now, before), ElementsAre("input keys no longer gets wave"));
  now.inputs[2].content.hash = "other";
  EXPECT_THAT(Differences(before, now),
              ElementsAre("input keys now also gets wave", "bent changed"));
  now.inputs = {input("keys", "bent"), input("keys", "rest"), input("timeline", "the timeline")};
  EXPECT_THAT(Differences(before, now), ElementsAre("input keys was rest, and is bent now",
                                                    "input keys was bent, and is rest now"));
}

TEST(Differences, ManyFilesAreSummedUp) {
  Recipe before = SomeRecipe(), now = SomeRecipe();
  std::map<std::string, std::string> a, b;
  for (int i = 0; i < 50; ++i) a["f" + std::to_string(i)] = "1", b["f" + std::to_string(i)] = "2";
  before.inputs[1].content = FolderContent(a);
  now.inputs[1].content = FolderContent(b);
  const auto differences = Differences(before, now);
  ASSERT_EQ(differences.size(), 6u);
  EXPECT_EQ(differences.back(), "and 45 more files of photos/rest");
}

TEST(Text, NamesAreOfAnyScript) {
  for (const char* name : {"rest", "m\u00e4hen", "ma\u0308hen", "\u8df3\u8e8d", "a_b-2"})
    EXPECT_TRUE(IsName(name)) << name;
  for (const char* name :
       {"", "-a", "a b", "a/b", "a.b", "a\u00a0b", "a\u200bb", "\xe4", "a\nb", "@all"})
    EXPECT_FALSE(IsName(name)) << name;
  EXPECT_EQ(Composed("ma\u0308hen"), "m\u00e4hen");
  EXPECT_EQ(Composed("\xe4"), "\xe4") << "what is no UTF-8 stays";
}

TEST(Text, IsCutAndWrappedByColumns) {
  EXPECT_EQ(WidthOf("ma\u0308h"), 3u);
  EXPECT_EQ(WidthOf("\u8df3\u8e8d"), 4u) << "these letters are two columns wide";
  EXPECT_EQ(CutTo("m\u00e4hen", 2), "m\u00e4");
  EXPECT_EQ(CutTo("\u8df3\u8e8d", 3), "\u8df3");
  EXPECT_THAT(Wrapped("one two three", 7), ElementsAre("one two", "three"));
  EXPECT_THAT(Wrapped("verylongword a", 4), ElementsAre("verylongword", "a"));
  EXPECT_THAT(Wrapped("one two three", 0), ElementsAre("one two three"));
  EXPECT_EQ(ShellWord("/a/b c"), "'/a/b c'");
  EXPECT_EQ(ShellWord("it's"), "'it'\\''s'");
}

TEST(IsShotName, TakesPhotographsOfTheFigureOnly) {
  for (const char* shot : {"a.jpg", "lying/a.JPG", "a.nef", "masks.jpg"})
    EXPECT_TRUE(IsShotName(shot)) << shot;
  for (const char* other : {"masks/a.png", "lying/masks/a.png", "stacks/a_f1.jpg", "background.jpg",
                            "lying/Background.CR2", ".trash/a.jpg", "@eaDir/a.jpg/thumb.jpg",
                            "old/first/a.jpg", "shoot.json"})
    EXPECT_FALSE(IsShotName(other)) << other;
}

TEST(WorkSize, MegapixelsComeFromTheHeaderOrTheSize) {
  const TestingFolder folder;
  const fs::path file = folder.path() / "pixels.jpg";
  WriteImage(file, Image8(300, 200, 3, 90));
  EXPECT_DOUBLE_EQ(MegapixelsOf("a.jpg", ReadFile(file)), 0.06);
  EXPECT_NEAR(MegapixelsOf("a.heic", std::string(1800000, 'x')), 12, 1e-9)
      << "a phone's twelve megapixels";
  EXPECT_NEAR(MegapixelsOf("a.NEF", std::string(2400000, 'x')), 2, 1e-9);
  EXPECT_NEAR(MegapixelsOf("broken.jpg", std::string(350000, 'x')), 1, 1e-9);
}

TEST(Overlay, ProjectChangesStepsFieldByField) {
  const PipelineFile defaults = ParsePipelineFile(
      "steps: {a: {stage: x, for: pose, options: {p: 1, q: 2}}, b: {stage: y, for: pose}}",
      "default");
  const PipelineFile own = ParsePipelineFile(
      "steps: {a: {options: {q: 3}}, b: {enabled: false}, c: {stage: z, for: project}}", "own");
  const PipelineFile both = Overlay(defaults, own);
  ASSERT_EQ(both.steps.size(), 3u);
  EXPECT_EQ(both.steps[0].stage->text, "x");
  EXPECT_EQ(both.steps[0].options.at("p").text, "1");
  EXPECT_EQ(both.steps[0].options.at("q").text, "3");
  EXPECT_FALSE(both.steps[1].enabled);
  EXPECT_EQ(both.steps[2].name, "c");
}

class RealDiskTest : public ::testing::Test, public TestingFolder {
 protected:
  const fs::path root_ = path();
};

TEST_F(RealDiskTest, WritesThroughItsStagingFolderAndLeavesNothingThere) {
  RealDisk disk(root_ / "staging");
  disk.Write(root_ / "a/b/file", "content");
  EXPECT_EQ(disk.Read(root_ / "a/b/file"), "content");
  EXPECT_EQ(disk.Children(root_ / "a/b"), (std::vector<std::string>{"file"}));
  EXPECT_TRUE(fs::is_empty(root_ / "staging"));
  EXPECT_EQ(disk.ContentHash(root_ / "a/b/file"), Sha256Of("content"));
}

TEST_F(RealDiskTest, CopyIsIndependentOfItsSource) {
  RealDisk disk;
  disk.Write(root_ / "a", "content");
  disk.Copy(root_ / "a", root_ / "sub/b");
  std::ofstream(root_ / "sub/b", std::ios::app) << " edited";
  EXPECT_EQ(disk.Read(root_ / "a"), "content");
}

TEST_F(RealDiskTest, MoveReplacesAFolderThatHasContent) {
  RealDisk disk;
  disk.Write(root_ / "new/x", "new");
  disk.Write(root_ / "old/x", "old");
  disk.Write(root_ / "old/y", "old");
  disk.Move(root_ / "new", root_ / "old");
  EXPECT_EQ(disk.FilesBelow(root_ / "old"), (std::vector<std::string>{"x"}));
  EXPECT_EQ(disk.Read(root_ / "old/x"), "new");
  EXPECT_FALSE(disk.Stat(root_ / "new"));
}

TEST_F(RealDiskTest, FaultsAreDiskErrorsWithPathAndReason) {
  RealDisk disk;
  EXPECT_THAT(MessageOf<DiskError>([&] { disk.Read(root_ / "none"); }),
              HasSubstr("none: No such file or directory"));
  disk.Write(root_ / "file", "");
  EXPECT_THAT(MessageOf<DiskError>([&] { disk.Write(root_ / "file/below", "x"); }),
              HasSubstr("file"));
  EXPECT_FALSE(disk.Stat(root_ / "file/below"));
}

TEST(ResultsFolder, OwnCopyOfAKilledRunIsNotTakenForAnEdit) {
  MemoryDisk disk;
  disk.Write("/p/.keypose/cache/m.txt", "new");
  disk.Write("/p/out/m.txt", "new");  // placed, but the run was killed before it could record that
  disk.Write("/p/.keypose/out.json", R"({"m.txt":{"step":"s","sha256":"","next":")" +
                                         Sha256Of("new") +
                                         R"(","size":0,"mtime_ns":0,"inode":0}})");
  Step step;
  step.id = "s";
  step.results.push_back({"mesh", "", "m.txt", {}});
  Artifact artifact;
  artifact.folder = "/p/.keypose/cache";
  disk.Write("/p/.keypose/cache/m.txt", "newer");
  artifact.outputs["mesh"] = {"m.txt", false, {Sha256Of("newer"), {}}};
  ResultsFolder results(disk, "/p/out", "/p/.keypose/out.json");
  EXPECT_TRUE(results.Publish(step, artifact).notes.empty());
  EXPECT_EQ(disk.Read("/p/out/m.txt"), "newer");
  EXPECT_EQ(disk.FilesBelow("/p/out").size(), 1u);
}

}  // namespace keypose::pipeline::unit_test
