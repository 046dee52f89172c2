// `keypose figure`, with real processes and files.
#include <gmock/gmock.h>

#include <cstdio>

#include "core/io/pictures/image_io.h"
#include "core/testing/paths.h"
#include "pipeline/testing/installed_house.h"

namespace keypose::pipeline::figure_test {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr char kMasked[] = R"(sources: {photos: {of: pose}}
steps:
  capture: {stage: capture, for: pose, inputs: {photos: $photos}}
  masks:
    stage: masks
    for: pose
    method: scan
    inputs: {images: capture.images}
    out: {masked/contact_sheet.jpg: "{pose}/masks_agreed.jpg"}
  join: {stage: join, for: pose, method: scan, inputs: {images: masks.masked}, out: {text: "{pose}/text.txt"}}
)";
constexpr char kFilmed[] = R"(sources: {video: {of: shot}}
steps:
  silhouettes: {stage: silhouettes, for: shot, when: [$unmasked], inputs: {video: $unmasked}}
  join: {stage: join, for: shot, inputs: {images: {either: [silhouettes.masked, $video]}}, out: {text: "{shot}/text.txt"}}
)";
constexpr char kProject[] = R"(# what the cat left
poses:
  rest: photos/rest        # short
  bent:
    photos: photos/bent
    options: {capture: {exit_code: 0}}  # keep
  wave: {photos: photos/wave, method: fit}
)";

class Figure : public RunTest {
 protected:
  void SetUp() override {
    RunTest::SetUp();
    fs::copy_file(BinFolder() + "/keypose-figure", root_ / "bin/keypose-figure");
    fs::create_symlink(fs::path(BinFolder()).parent_path() / "lib", root_ / "lib");
    for (const std::string stage : {"capture", "masks", "silhouettes"})
      fs::copy_file(BinFolder() + "/testing/pipeline_text_stage", root_ / ("bin/keypose-" + stage));
    WriteFile(root_ / "share/keypose/pipeline.yaml", kMasked);
    WriteFile(root_ / "share/keypose/performance.yaml", kFilmed);
    fs::remove_all(root_ / "hero");
    for (const std::string pose : {"rest", "bent", "wave"}) {
      fs::create_directories(root_ / "hero/photos" / pose);
      for (const int i : {1, 2})
        WritePhotograph("photos/" + pose + "/IMG_" + std::to_string(i) + ".jpg", 1);
    }
    WriteFile(Yaml(), kProject);
  }

  fs::path Yaml() const { return root_ / "hero/pipeline.yaml"; }
  /// Of 40 x 30 pixels as stored; a viewer shows those of orientation 6 as 30 x 40.
  void WritePhotograph(const fs::path& file, int orientation) {
    fs::create_directories((root_ / "hero" / file).parent_path());
    ExifToWrite exif;
    exif.orientation = orientation;
    WriteImage(root_ / "hero" / file, Image8(40, 30, 3, 128), 90, &exif);
  }
  Ended Say(std::vector<std::string> words) const {
    words.insert(words.begin(), "figure");
    words.insert(words.end(), {"-C", (root_ / "hero").string()});
    return Keypose(words);
  }
  /// What the stage of the last run was told.
  std::string Told(const std::string& pose) const {
    return ReadFile(root_ / "hero/out" / pose / "text.txt");
  }
  /// Makes the project a performance with two cameras of pictures.
  void MakePerformance() {
    for (const std::string camera : {"cam2", "cam10"})
      for (int i = 0; i < 3; ++i)
        WritePhotograph("films/walk/" + camera + "/00" + std::to_string(7 + i) + ".png", 1);
    WriteFile(Yaml(), "kind: performance\nshots:\n  walk: films/walk # home\n");
  }
};

TEST_F(Figure, ClicksStandInPipelineYamlWithAllElseAsItWas) {
  ASSERT_EQ(Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20.5"}).code, 0);
  const Ended more =
      Say({"--pose", "rest", "--at", "IMG_2.jpg:1,2-30,25", "--not", "IMG_1.jpg:0,0"});
  ASSERT_EQ(more.code, 0) << more.text;
  ASSERT_EQ(Say({"--pose", "bent", "--at", "IMG_2.jpg:40,30"}).code, 0);
  EXPECT_EQ(ReadFile(Yaml()), R"(# what the cat left
poses:
  rest: {photos: photos/rest, options: {masks: {figure: "IMG_1.jpg:12,20.5; IMG_2.jpg:1,2-30,25; !IMG_1.jpg:0,0"}}}        # short
  bent:
    photos: photos/bent
    options: {capture: {exit_code: 0}, masks: {figure: "IMG_2.jpg:40,30"}}  # keep
  wave: {photos: photos/wave, method: fit}
)");
  EXPECT_THAT(more.text, HasSubstr("  the figure      IMG_2.jpg:1,2-30,25\n"
                                   "  not the figure  IMG_1.jpg:0,0\n"));
  const Ended shown = Say({"--pose", "rest"});
  EXPECT_EQ(shown.code, 0);
  EXPECT_EQ(shown.text, more.text.substr(0, more.text.find("masks/rest has")));
}

TEST_F(Figure, APlaceIsNotBothTheFigureAndNot) {
  const std::string before = ReadFile(Yaml());
  const Ended said = Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20", "--not", "IMG_1.jpg:12,20"});
  EXPECT_EQ(said.code, 2);
  EXPECT_THAT(said.text, HasSubstr("IMG_1.jpg:12,20 is said both to be the figure and not"));
  EXPECT_EQ(ReadFile(Yaml()), before);
  ASSERT_EQ(Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"}).code, 0);
  EXPECT_EQ(Say({"--pose", "rest", "--not", "IMG_1.jpg:12,20"}).code, 2);
}

TEST_F(Figure, TheStepIsToldAndOnlyItAndWhatFollowsRunsAgain) {
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Told("rest"), "");
  const std::string folder = (root_ / "hero").string();
  const Ended said = Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"});
  EXPECT_THAT(said.text,
              EndsWith("masks/rest will run again, and the 1 that follows if its result changes\n"
                       "next: keypose run -C " +
                       folder +
                       " --until masks/rest\n"
                       "      look at out/rest/masks_agreed.jpg, then keypose run -C " +
                       folder + "\n"));
  EXPECT_THAT(Keypose({"explain", "masks/rest", "-C", folder}).text, HasSubstr("figure"));
  const Ended dry = Run({"--dry-run"});
  EXPECT_THAT(dry.text, AllOf(HasSubstr("masks/rest"), Not(HasSubstr("capture/rest")),
                              Not(HasSubstr("masks/bent"))));
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Told("rest"), "IMG_1.jpg:12,20");
  EXPECT_EQ(Told("bent"), "");
}

TEST_F(Figure, WhatIsTakenBackComesFromTheCache) {
  ASSERT_EQ(Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"}).code, 0);
  const Ended again = Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"});
  EXPECT_EQ(again.code, 0);
  EXPECT_THAT(again.text, HasSubstr("this was said already"));
  ASSERT_EQ(Run().code, 0);
  ASSERT_EQ(Say({"--pose", "rest", "--clear", "--at", "IMG_2.jpg:3,4"}).code, 0);
  EXPECT_THAT(ReadFile(Yaml()), HasSubstr("{figure: \"IMG_2.jpg:3,4\"}"));
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Told("rest"), "IMG_2.jpg:3,4");
  ASSERT_EQ(Say({"--pose", "rest", "--clear"}).code, 0);
  EXPECT_THAT(ReadFile(Yaml()), Not(HasSubstr("figure")));
  const Ended back = Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"});
  EXPECT_THAT(back.text, HasSubstr("masks/rest was made with this before"));
}

TEST_F(Figure, WhatHoldsForAllPosesCanBeTakenBackForOne) {
  WriteFile(Yaml(), std::string(kProject) + "options: {masks: {figure: \"IMG_1.jpg:5,5\"}}\n");
  EXPECT_THAT(Say({"--pose", "rest"}).text, HasSubstr("the figure      IMG_1.jpg:5,5"));
  ASSERT_EQ(Say({"--pose", "rest", "--clear"}).code, 0);
  EXPECT_THAT(Say({"--pose", "rest"}).text, HasSubstr("nothing is said"));
  EXPECT_THAT(Say({"--pose", "bent"}).text, HasSubstr("IMG_1.jpg:5,5"));
}

TEST_F(Figure, PosesOfFewPhotographsTellCapture) {
  const Ended said = Say({"--pose", "wave", "--at", "IMG_2.jpg:3,4"});
  ASSERT_EQ(said.code, 0) << said.text;
  EXPECT_THAT(said.text, HasSubstr("pose 'wave', for its step capture"));
  EXPECT_THAT(ReadFile(Yaml()), HasSubstr("options: {capture: {figure: \"IMG_2.jpg:3,4\"}}"));
}

TEST_F(Figure, PicturesAreMeasuredAsAViewerShowsThem) {
  WritePhotograph("photos/rest/upright.jpg", 6);
  EXPECT_EQ(Say({"--pose", "rest", "--at", "upright.jpg:30,40"}).code, 0);
  const Ended beside = Say({"--pose", "rest", "--at", "upright.jpg:31,20"});
  EXPECT_EQ(beside.code, 2);
  EXPECT_THAT(beside.text,
              HasSubstr("31,20 lies outside of upright.jpg, which has 30 x 40 pixels"));
  EXPECT_EQ(Say({"--pose", "rest", "--at", "IMG_1.jpg:5,5-20,31"}).code, 2);
}

TEST_F(Figure, PhotographsInFoldersAndUnderOtherNamesAreFound) {
  fs::remove_all(root_ / "hero/photos/rest");
  WritePhotograph("photos/rest/lying/a b:1.jpg", 1);
  WritePhotograph("photos/rest/lying/IMG_1.jpg", 1);
  WritePhotograph("photos/rest/upright/IMG_1.jpg", 1);
  const Ended said = Say({"--pose", "rest", "--at", "a b:1.jpg:3,4", "--at", "lying/IMG_1.jpg:1,1",
                          "--at", "upright_IMG_1.jpg:2,2"});
  ASSERT_EQ(said.code, 0) << said.text;
  EXPECT_THAT(ReadFile(Yaml()),
              HasSubstr("\"lying/a b%3A1.jpg:3,4; lying/IMG_1.jpg:1,1; upright/IMG_1.jpg:2,2\""));
  const Ended two = Say({"--pose", "rest", "--at", "IMG_1.jpg:1,1"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.text, HasSubstr("2 photographs 'IMG_1.jpg': lying/IMG_1.jpg, upright/IMG_1.jpg"));
}

TEST_F(Figure, WhatIsNotThereIsRefusedWithTheNearestName) {
  const std::string before = ReadFile(Yaml());
  const auto refuse = [&](const std::vector<std::string>& words, const std::string& why) {
    const Ended ended = Say(words);
    EXPECT_EQ(ended.code, 2) << ended.text;
    EXPECT_THAT(ended.text, HasSubstr(why));
    EXPECT_EQ(ReadFile(Yaml()), before);
  };
  refuse({"--pose", "bend", "--at", "IMG_1.jpg:1,1"}, "no pose 'bend'; did you mean 'bent'?");
  refuse({"--pose", "rest", "--at", "IMG_11.jpg:1,1"}, "did you mean 'IMG_1.jpg'?");
  refuse({"--at", "IMG_1.jpg:1,1"}, "say which pose: --pose NAME, with one of rest, bent, wave");
  refuse({"--shot", "walk", "--at", "cam2/1:1,1"}, "this project has poses; say --pose NAME");
  refuse({"--pose", "rest", "--at", "IMG_1.jpg"}, "'IMG_1.jpg' has no ':'");
  refuse({"--pose", "rest", "--at", "IMG_1.jpg:1,2", "--at", "IMG_2.jpg:99,2"}, "lies outside");
  refuse({"--pose", "rest", "--on", "IMG_1.jpg:1,2"}, "keypose figure --help");
  WriteFile(root_ / "hero/photos/rest/IMG_3.jpg", "no picture");
  const Ended damaged = Say({"--pose", "rest", "--at", "IMG_3.jpg:1,1"});
  EXPECT_EQ(damaged.code, 3);
  EXPECT_THAT(damaged.text, HasSubstr("IMG_3.jpg"));
}

TEST_F(Figure, TextsThatAPersonWroteWronglyAreNamedAndCanBeCleared) {
  WriteFile(Yaml(),
            "poses:\n  rest: {photos: photos/rest, options: {masks: {figure: IMG_1.jpg}}}\n");
  const Ended wrong = Say({"--at", "IMG_1.jpg:1,1"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_THAT(wrong.text, HasSubstr("step 'masks/rest': figure: 'IMG_1.jpg' has no ':'"));
  EXPECT_EQ(Say({"--clear", "--at", "IMG_1.jpg:1,1"}).code, 0);
  EXPECT_THAT(ReadFile(Yaml()), HasSubstr("{figure: \"IMG_1.jpg:1,1\"}"));
}

TEST_F(Figure, PosesThatNoStepMasksAreNamed) {
  WriteFile(root_ / "share/keypose/pipeline.yaml", kTestPipeline);
  WriteFile(Yaml(), "poses: {rest: photos/rest}\n");
  const Ended none = Say({"--at", "IMG_1.jpg:1,1"});
  EXPECT_EQ(none.code, 2);
  EXPECT_THAT(none.text, HasSubstr("nothing makes masks of pose 'rest'"));
}

TEST_F(Figure, ClicksAtOneTimeAreAllKept) {
  std::vector<pid_t> started;
  for (int i = 0; i < 5; ++i)
    started.push_back(Start({"figure", "-C", (root_ / "hero").string(), "--pose", "rest", "--at",
                             "IMG_1.jpg:" + std::to_string(i) + ",1"}));
  for (const pid_t pid : started) {
    const Ended ended = Finish(pid);
    EXPECT_EQ(ended.code, 0) << ended.text;
  }
  const std::string text = Say({"--pose", "rest"}).text;
  for (int i = 0; i < 5; ++i)
    EXPECT_THAT(text, HasSubstr("IMG_1.jpg:" + std::to_string(i) + ",1\n"));
}

TEST_F(Figure, ARunAtWorkIsNotDisturbedAndSeesItNextTime) {
  const pid_t run =
      Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "400"}});
  for (int i = 0; i < 500 && !fs::exists(root_ / "hero/.keypose/tmp/capture.rest"); ++i)
    SleepSeconds(0.01);
  const Ended said = Say({"--pose", "rest", "--at", "IMG_1.jpg:12,20"});
  EXPECT_EQ(said.code, 0) << said.text;
  EXPECT_THAT(said.text, HasSubstr("what runs now does not see this yet"));
  EXPECT_EQ(Finish(run).code, 0);
  EXPECT_EQ(Told("rest"), "");
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Told("rest"), "IMG_1.jpg:12,20");
}

TEST_F(Figure, FramesOfFilmsAreCountedFromTheFirst) {
  MakePerformance();
  const Ended said = Say({"--shot", "walk", "--at", "cam10/2:20,10"});
  ASSERT_EQ(said.code, 0) << said.text;
  EXPECT_EQ(ReadFile(Yaml()),
            "kind: performance\nshots:\n  walk: {video: films/walk, options: {silhouettes: "
            "{figure: \"cam10/2:20,10\"}}} # home\n");
  ASSERT_EQ(Run().code, 0);
  EXPECT_EQ(Told("walk"), "cam10/2:20,10");
  for (const auto& [at, why] : std::vector<std::pair<std::string, std::string>>{
           {"cam10/3:20,10", "there is no frame 3 of camera 'cam10': its film has 3"},
           {"cam3/1:20,10", "there is no camera 'cam3'; did you mean 'cam2'? (known: cam2, cam10)"},
           {"cam2/1:41,10", "41,10 lies outside of cam2/1"},
           {"cam2/009.png:1,1", "names no frame of a film; write it as CAMERA/FRAME:X,Y"}}) {
    const Ended refused = Say({"--shot", "walk", "--at", at});
    EXPECT_EQ(refused.code, 2);
    EXPECT_THAT(refused.text, HasSubstr(why));
  }
  EXPECT_THAT(Say({"--pose", "walk"}).text, HasSubstr("this project has shots; say --shot NAME"));
  fs::create_directories(root_ / "hero/films/walk/masks");
  const Ended masked = Say({"--at", "cam2/1:1,1"});
  EXPECT_EQ(masked.code, 2) << masked.text;
}

}  // namespace keypose::pipeline::figure_test
