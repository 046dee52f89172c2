#include "studio/runs/example_maker.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::studio::example_maker_test {

/// Programs of the names of Keypose's, which draw and make projects of a few words.
class ExampleMakerTest : public TestingFolder, public ::testing::Test {
 protected:
  ExampleMakerTest() {
    Program("keypose-synth", R"(echo "$@" > said; echo "synth:  40 % photographs of rest" >&2
mkdir -p "$3/film" "$3/photos/rest"; echo a > "$3/film/0000.png")");
    Program("keypose",
            R"(echo "shot: {film: $here/.$(basename "$2").drawn/film}" > "$2/pipeline.yaml")");
  }
  void Program(const std::string& name, const std::string& act) {
    Put(name, "#!/bin/sh\nhere='" + (folder_ / "base").string() + "'\n" + act + "\n");
    fs::permissions(folder_ / name, fs::perms::owner_all);
  }
  ExampleState Made(const std::string& kind) {
    maker_.Start(kind, folder_ / "base");
    while (maker_.State().at_work) usleep(10'000);
    return maker_.State();
  }
  /// What lies in the folder of examples, hidden files too.
  std::vector<std::string> Left() const {
    std::vector<std::string> names;
    for (const auto& one : fs::directory_iterator(folder_ / "base"))
      names.push_back(one.path().filename());
    return names;
  }

  std::vector<std::pair<fs::path, bool>> made_;
  ExampleMaker maker_{folder_, [this](const fs::path& folder, bool runs) {
                        made_.push_back({folder, runs});
                      }};
};

using Names = std::vector<std::string>;

TEST_F(ExampleMakerTest, DrawsThenMakesAProjectAndLeavesNothingElse) {
  const ExampleState state = Made("six");
  EXPECT_EQ(state.error, "");
  EXPECT_EQ(state.share, 1);
  EXPECT_EQ(Left(), (Names{"six"}));
  ASSERT_EQ(made_.size(), 1U);
  EXPECT_EQ(made_[0].first, folder_ / "base/six");
  EXPECT_FALSE(made_[0].second);
  EXPECT_NE(ReadFile(folder_ / "base/six/said").find("--few wave=6"), std::string::npos);
}

TEST_F(ExampleMakerTest, OnlyTheFinishedOneRuns) {
  Made("finished");
  ASSERT_EQ(made_.size(), 1U);
  EXPECT_TRUE(made_[0].second);
}

TEST_F(ExampleMakerTest, AFilmBecomesTheProjectsOwn) {
  EXPECT_EQ(Made("film").error, "");
  EXPECT_EQ(ReadFile(folder_ / "base/film/films/film/0000.png"), "a\n");
  EXPECT_EQ(ReadFile(folder_ / "base/film/pipeline.yaml"), "shot: {film: films/film}\n");
}

TEST_F(ExampleMakerTest, WhatFailsIsSaidAndRemoved) {
  Program("keypose", "echo 'keypose: error: the disk is full' >&2; exit 5");
  EXPECT_EQ(Made("six").error, "the disk is full");
  EXPECT_TRUE(Left().empty());
  EXPECT_TRUE(made_.empty());
}

TEST_F(ExampleMakerTest, StopsWhenAsked) {
  Program("keypose-synth", "echo 'synth: 7 % sculpting' >&2; exec sleep 60");
  maker_.Start("two", folder_ / "base");
  while (maker_.State().words.empty()) usleep(10'000);
  EXPECT_NEAR(maker_.State().share, 0.95 * 0.07, 1e-9);
  EXPECT_THROW(maker_.Start("six", folder_ / "base"), LockedError);
  maker_.Stop();
  while (maker_.State().at_work) usleep(10'000);
  EXPECT_EQ(maker_.State().error, "stopped");
  EXPECT_TRUE(Left().empty());
}

TEST_F(ExampleMakerTest, AFolderThatHasFilesAndAnUnknownKindAreRefused) {
  fs::create_directories(folder_ / "base/six");
  Put("base/six/mine.txt", "mine");
  EXPECT_THROW(maker_.Start("six", folder_ / "base"), UsageError);
  EXPECT_THROW(maker_.Start("../six", folder_ / "base"), UsageError);
  EXPECT_EQ(ReadFile(folder_ / "base/six/mine.txt"), "mine");
}

}  // namespace keypose::studio::example_maker_test
