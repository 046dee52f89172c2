// The page's timeline and pipeline.yaml: what stays of a file that a person wrote.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "studio/project/snapshot.h"
#include "studio/routes/routes.h"

namespace keypose::studio::timeline_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kHead[] = "# by hand\nposes: {rest: photos/rest, wave: photos/wave}\n";

class TimelineRoutes : public ::testing::Test {
 protected:
  TimelineRoutes() {
    for (const char* folder : {"photos/rest", "photos/wave", "films/take1"})
      fs::create_directories(folder_ / folder);
  }
  ~TimelineRoutes() override { routes_.reset(); }

  json Read(const std::string& rest) {
    routes_.reset();
    WriteFile(folder_ / "pipeline.yaml", kHead + rest);
    routes_ = std::make_unique<Routes>(folder_);
    const Answer answer = routes_->Handle({"GET", "/api/timeline", {}, ""});
    EXPECT_EQ(answer.status, 200) << answer.bytes;
    return json::parse(answer.bytes);
  }
  Answer Save(const json& timeline) {
    return routes_->Handle({"PUT", "/api/timeline", {}, timeline.dump()});
  }
  std::string Text() const { return ReadFile(folder_ / "pipeline.yaml"); }

  const TestingFolder own_;
  const fs::path folder_ = own_.path() / "hero";
  std::unique_ptr<Routes> routes_;
};

TEST_F(TimelineRoutes, WithoutOneTheDefaultLoopIsShownAndSavedAsTimes) {
  json timeline = Read("");
  EXPECT_TRUE(timeline.at("timed").get<bool>());
  EXPECT_TRUE(timeline.at("loop").get<bool>());
  ASSERT_EQ(timeline["keys"].size(), 3u);
  EXPECT_EQ(timeline["keys"][1],
            json::parse(R"({"pose": "wave", "at": 1.5, "hold": 0.6, "ease": "in-out"})"));
  timeline["keys"][1]["at"] = 2.0;
  ASSERT_EQ(Save(timeline).status, 200);
  EXPECT_THAT(Text(), HasSubstr("    - {pose: wave, at: 2, ease: in-out, hold: 0.6}\n"
                                "    - {pose: rest, at: 3}\n"));
  EXPECT_THAT(Text(), HasSubstr("  loop: true\n"));
}

TEST_F(TimelineRoutes, AnOrderOfPosesKeepsWhatItSaysOfEachWhenItGetsTimes) {
  json timeline = Read(
      "timeline:   # the greeting\n  # asleep\n  - {pose: rest, hold: 0.5, ease: in-out}   # calm\n"
      "  - wave   # up\n  - rest\nfps: 24\n");
  EXPECT_FALSE(timeline.at("timed").get<bool>());
  EXPECT_EQ(timeline["keys"][0], json::parse(R"({"pose": "rest", "at": 0.0, "hold": 0.5,
                                                 "ease": "in-out"})"));
  EXPECT_NEAR(timeline["keys"][1]["at"], 22 / 24., 1e-9) << "12 frames stand, then 10 to the next";
  timeline["keys"][1]["at"] = 1.0;
  timeline["keys"][2]["at"] = 1.5;
  const Answer answer = Save(timeline);
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_EQ(Text(), std::string(kHead) +
                        "timeline:   # the greeting\n  keys:\n    # asleep\n"
                        "    - {pose: rest, at: 0, ease: in-out, hold: 0.5}   # calm\n"
                        "    - {pose: wave, at: 1}   # up\n    - {pose: rest, at: 1.5}\nfps: 24\n");
}

TEST_F(TimelineRoutes, AKeyMoreLeavesTheCommentsOfTheOthers) {
  json timeline = Read(
      "timeline: [{pose: rest, at: 0}, {pose: wave, at: 1}]   # the greeting\noptions:\n"
      "  cleanup: {faces: 9000}\n");
  timeline["keys"].push_back({{"pose", "rest"}, {"at", 2.25}});
  ASSERT_EQ(Save(timeline).status, 200);
  EXPECT_EQ(Text(), std::string(kHead) +
                        "timeline:   # the greeting\n  keys:\n    - {pose: rest, at: 0}\n"
                        "    - {pose: wave, at: 1}\n    - {pose: rest, at: 2.25}\noptions:\n"
                        "  cleanup: {faces: 9000}\n");
}

TEST_F(TimelineRoutes, KeysOfAFilmedShotStayStraightWhenTheyAreEdited) {
  json timeline = Read("shot: {film: films/take1, shows: {0: rest, 4: wave}}\n");
  EXPECT_EQ(timeline["other"]["interpolation"], "linear");
  timeline["keys"][0]["ease"] = "in";
  const Answer answer = Save(timeline);
  ASSERT_EQ(answer.status, 200) << answer.bytes;
  EXPECT_THAT(Text(), HasSubstr("timeline:\n  keys:\n    - {pose: rest, at: 0, ease: in}\n"
                                "    - {pose: wave, at: 0.333333}\n  interpolation: linear\n"));
}

TEST_F(TimelineRoutes, WhatCannotBePlayedIsRefusedAndTheFileStays) {
  const json timeline = Read("timeline: [{pose: rest, at: 0}, {pose: wave, at: 1}]\n");
  const std::string before = Text();
  json loop = timeline;
  loop["loop"] = true;
  const Answer answer = Save(loop);
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.bytes, HasSubstr("begins with pose 'rest' and ends with 'wave'"));
  json elsewhere = timeline;
  elsewhere["keys"][1]["pose"] = "bow";
  EXPECT_THAT(Save(elsewhere).bytes, HasSubstr("there is no pose 'bow'"));
  json late = timeline;
  late["revision"] = "0123456789abcdef";
  EXPECT_EQ(Save(late).status, 409) << "an editor has changed the file meanwhile";
  EXPECT_EQ(Text(), before);
}

TEST_F(TimelineRoutes, APoseThatIsGoneIsToldWithTheLineOfTheTimeline) {
  routes_.reset();
  WriteFile(folder_ / "pipeline.yaml", std::string(kHead) + "timeline: [rest, bow]\n");
  routes_ = std::make_unique<Routes>(folder_);
  const Answer answer = routes_->Handle({"GET", "/api/timeline", {}, ""});
  EXPECT_EQ(answer.status, 400);
  EXPECT_THAT(answer.bytes, HasSubstr("pipeline.yaml:3: timeline pose 'bow' is not among the"));
}

/// A tenth of a second of silence, 8 bits. Source: the WAVE format of RIFF.
std::string ShortWav() {
  const std::string data(800, '\x80');
  const std::string rate("\x40\x1f\0\0", 4);
  const std::string size("\x20\x03\0\0", 4), whole("\x44\x03\0\0", 4);
  return "RIFF" + whole + "WAVEfmt " + std::string("\x10\0\0\0\1\0\1\0", 8) + rate + rate +
         std::string("\1\0\x08\0", 4) + "data" + size + data;
}

TEST_F(TimelineRoutes, ItsSoundIsAFileOfTheProject) {
  Read("fps: 12  # on twos\n");
  const auto get = [&] { return routes_->Handle({"GET", "/api/sound", {}, ""}).bytes; };
  EXPECT_EQ(get(), "null");
  const auto put = [&](const std::string& name, const std::string& bytes) {
    return routes_->Handle({"PUT", "/api/sound", {{"name", name}}, bytes});
  };
  ASSERT_EQ(put("line.wav", ShortWav()).status, 200);
  EXPECT_EQ(json::parse(get()),
            json::parse(R"({"file": "sound/line.wav", "name": "line.wav", "at": 0})"));
  EXPECT_EQ(ReadFile(folder_ / "sound/line.wav"), ShortWav());
  EXPECT_EQ(routes_->Handle({"GET", "/api/sound/file", {}, ""}).bytes, ShortWav());
  ASSERT_EQ(routes_->Handle({"PUT", "/api/sound/at", {}, R"({"at": 0.5})"}).status, 200);
  EXPECT_EQ(json::parse(get())["at"], 0.5);
  EXPECT_THAT(Text(), HasSubstr("fps: 12  # on twos"));
  EXPECT_THAT(Text(), HasSubstr("sound: sound/line.wav"));
  EXPECT_THAT(Text(), HasSubstr("sound_at: 0.5"));

  std::string other = ShortWav();
  other.back() = 'a';
  const json second = json::parse(put("line.wav", other).bytes);
  EXPECT_EQ(second["file"], "sound/line-2.wav") << "nothing is replaced";
  EXPECT_EQ(second["at"], 0);
  EXPECT_EQ(json::parse(put("line.wav", ShortWav()).bytes)["file"], "sound/line.wav");
  ASSERT_EQ(routes_->Handle({"PUT", "/api/sound/remove", {}, "{}"}).status, 200);
  EXPECT_EQ(get(), "null");
  EXPECT_TRUE(fs::exists(folder_ / "sound/line.wav"));
  EXPECT_THAT(Text(), Not(HasSubstr("sound")));
}

TEST_F(TimelineRoutes, WhatIsNoSoundStaysOut) {
  Read("");
  const Answer answer =
      routes_->Handle({"PUT", "/api/sound", {{"name", "a.wav"}}, "shot on Monday"});
  EXPECT_EQ(answer.status, 400) << answer.bytes;
  EXPECT_THAT(answer.bytes, HasSubstr("is no film or sound"));
  EXPECT_FALSE(fs::exists(folder_ / "sound"));
  EXPECT_EQ(routes_->Handle({"PUT", "/api/sound", {{"name", "../a.wav"}}, ShortWav()}).status, 400);
  EXPECT_EQ(routes_->Handle({"GET", "/api/sound/file", {}, ""}).status, 400);
}

}  // namespace keypose::studio::timeline_routes_test
