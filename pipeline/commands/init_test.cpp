// `keypose init`, with real processes and files.
#include <gmock/gmock.h>

#include "pipeline/testing/installed_house.h"

namespace keypose::pipeline::init_test {

using ::testing::HasSubstr;
using ::testing::Not;

class InitTest : public RunTest {
 protected:
  void SetUp() override {
    RunTest::SetUp();
    MakePhotographs(root_ / "hero");
  }
};

TEST_F(InitTest, InitCopiesPhotographsAndLeavesOriginals) {
  const auto before = Snapshot(root_ / "hero/photos");
  const std::string rest = "rest=" + (root_ / "hero/photos/rest").string(),
                    bent = "bent=" + (root_ / "hero/photos/bent").string();
  const Ended ended = Keypose(
      {"init", (root_ / "new").string(), "--pose", rest, "--pose", bent, "--template", "bent"});
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("warning: --pose bent: 4 photographs; the pose that gives the "
                                    "others their net needs 8, and 24 or more"));
  EXPECT_THAT(ended.text, Not(HasSubstr("--pose rest: 4"))) << "that is bent into its four";
  EXPECT_EQ(Snapshot(root_ / "new/photos"), before);
  EXPECT_EQ(Snapshot(root_ / "hero/photos"), before);
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "new").string()}).code, 0);
  EXPECT_EQ(ReadFile(root_ / "new/out/all/0.txt").substr(4, 4), "BENT")
      << "the template comes first";
  EXPECT_EQ(Keypose({"init", (root_ / "new").string(), "--pose", rest}).code, 2)
      << "a folder with content is not overwritten";
  EXPECT_EQ(Keypose({"init", (root_ / "other").string(), "--pose", "rest=/no/such/folder"}).code,
            3);
}

TEST_F(InitTest, InitRefusesFoldersThatCannotBePoses) {
  const std::string photos = (root_ / "hero/photos").string(), fresh = (root_ / "new").string();
  const auto init = [&](const std::string& rest, const std::string& bent) {
    return Keypose({"init", fresh, "--pose", "rest=" + rest, "--pose", "bent=" + bent});
  };
  const Ended same = init(photos + "/rest", photos + "/rest/");
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.text, HasSubstr("'rest' and 'bent' have the same photographs"));
  const Ended parent = init(photos, photos + "/bent");
  EXPECT_EQ(parent.code, 2);
  EXPECT_THAT(parent.text, HasSubstr("lie inside the folder of pose 'rest'"));
  fs::create_directories(root_ / "empty");
  const Ended empty = init(photos + "/rest", (root_ / "empty").string());
  EXPECT_EQ(empty.code, 3);
  EXPECT_THAT(empty.text, HasSubstr("has no photographs; name the folder that they are in"));
  WriteFile(root_ / "empty/a.CRW", "raw");
  WriteFile(root_ / "empty/b.crw", "raw");
  const Ended raw = init(photos + "/rest", (root_ / "empty").string());
  EXPECT_EQ(raw.code, 3);
  EXPECT_THAT(raw.text, HasSubstr("2 .crw (a.CRW, b.crw)"));
  EXPECT_THAT(raw.text, HasSubstr(".heic"));
  EXPECT_THAT(raw.text, HasSubstr("develop RAW files to JPEG"));
  EXPECT_FALSE(fs::exists(fresh)) << "a refused project must leave nothing behind";
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: photos/rest}\n");
  const Ended run = Run();
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.text,
              HasSubstr("pipeline.yaml:1: the poses 'rest' and 'bent' have the same photographs"));
}

/// The line of a pose in a new project's file.
std::string PoseLine(const fs::path& project, const std::string& pose) {
  const std::string text = ReadFile(project / "pipeline.yaml");
  const auto at = text.find("\n  " + pose + ":") + 1;
  return text.substr(at, text.find('\n', at) - at);
}

TEST_F(InitTest, InitTakesRawFilesWhereThereAreNoOtherPhotographs) {
  fs::create_directories(root_ / "raw/upright");
  fs::create_directories(root_ / "pairs");
  WriteFile(root_ / "raw/upright/a.CR2", "raw");
  WriteFile(root_ / "raw/notes.txt", "text");
  WriteFile(root_ / "pairs/b.jpg", kPictureStart);
  WriteFile(root_ / "pairs/b.cr2", "raw");
  const Ended made =
      Keypose({"init", (root_ / "new").string(), "--pose", "raw=" + (root_ / "raw").string(),
               "--pose", "pairs=" + (root_ / "pairs").string()});
  ASSERT_EQ(made.code, 0) << made.text;
  EXPECT_TRUE(fs::exists(root_ / "new/photos/raw/upright/a.CR2"));
  EXPECT_FALSE(fs::exists(root_ / "new/photos/raw/notes.txt"));
  EXPECT_TRUE(fs::exists(root_ / "new/photos/pairs/b.jpg"));
  EXPECT_FALSE(fs::exists(root_ / "new/photos/pairs/b.cr2")) << "the JPEG is taken";
  EXPECT_THAT(made.text, HasSubstr("because there are other photographs: RAW files, 1 .cr2"));
}

TEST_F(InitTest, PhotographsThatCannotBeReadAreAllNamedBeforeAnythingIsCopied) {
  const fs::path photos = root_ / "hero/photos/rest", fresh = root_ / "new";
  WriteFile(photos / "IMG_0.jpg", "<!DOCTYPE html><p>not found");
  WriteFile(photos / "IMG_2.jpg", "\xff\xd8\xff\xe0 begun");
  WriteFile(photos / "IMG_3.jpg", "");
  const Ended made = Keypose({"init", fresh.string(), "--pose", "rest=" + photos.string()});
  EXPECT_EQ(made.code, 3);
  EXPECT_THAT(made.text, HasSubstr("IMG_0.jpg is a web page, whatever its name says"));
  EXPECT_THAT(made.text, HasSubstr("IMG_2.jpg is cut off: its end is missing"));
  EXPECT_THAT(made.text, HasSubstr("IMG_3.jpg is empty. Nothing was copied"));
  EXPECT_THAT(made.text, Not(HasSubstr("IMG_1.jpg")));
  EXPECT_FALSE(fs::exists(fresh));
}

TEST_F(InitTest, InitTakesWhatShootNotedAndLeavesItsFocusStacks) {
  fs::create_directories(root_ / "shot/stacks");
  fs::create_directories(root_ / "lean");
  for (int i = 0; i < 6; ++i) {
    const std::string shot = "r1_a0" + std::to_string(10 * i);
    WriteFile(root_ / "shot" / (shot + ".jpg"), kPictureStart);
    for (int k = 1; k <= 3; ++k)
      WriteFile(root_ / "shot/stacks" / (shot + "_f" + std::to_string(k) + ".jpg"), kPictureStart);
  }
  for (int i = 0; i < 15; ++i)
    WriteFile(root_ / "lean" / ("IMG_" + std::to_string(i) + ".jpg"), kPictureStart);
  WriteFile(root_ / "lean/background.jpg", kPictureStart);
  fs::create_directories(root_ / "lean/masks");
  WriteFile(root_ / "lean/masks/IMG_0.jpg.png", kPictureStart);
  WriteFile(root_ / "lean/masks/painted.json", R"({"masks": {}})");
  fs::create_directories(root_ / "lean/@eaDir/IMG_0.jpg");
  WriteFile(root_ / "lean/@eaDir/IMG_0.jpg/SYNOPHOTO_THUMB_M.jpg", "a disk station's");
  WriteFile(root_ / "shot/shoot.json", "{}");
  const fs::path fresh = root_ / "new";
  const Ended made = Keypose(
      {"init", fresh.string(), "--pose", "rest=" + (root_ / "hero/photos/rest").string(), "--pose",
       "wave=" + (root_ / "shot").string(), "--pose", "lean=" + (root_ / "lean").string()});
  ASSERT_EQ(made.code, 0) << made.text;
  EXPECT_TRUE(fs::exists(fresh / "photos/wave/shoot.json")) << "white balance and angles";
  EXPECT_FALSE(fs::exists(fresh / "photos/wave/stacks")) << "each is in its merged photograph";
  EXPECT_TRUE(fs::exists(fresh / "photos/lean/background.jpg"));
  EXPECT_TRUE(fs::exists(fresh / "photos/lean/masks/painted.json")) << "what the masks belong to";
  EXPECT_EQ(PoseLine(fresh, "wave"), "  wave: {photos: photos/wave, method: fit}")
      << "six photographs, whatever they were merged from";
  EXPECT_EQ(PoseLine(fresh, "lean"), "  lean: {photos: photos/lean, method: fit}")
      << "the clean plate does not show the figure";
  EXPECT_FALSE(fs::exists(fresh / "photos/lean/@eaDir"));
  EXPECT_THAT(made.text, Not(HasSubstr("not copied")));
}

TEST_F(InitTest, InitFitsPosesOfFewPhotographsAndSaysSo) {
  fs::create_directories(root_ / "many/masks");
  for (int i = 0; i < 16; ++i) {
    WriteFile(root_ / "many" / ("IMG_" + std::to_string(i) + ".jpg"), kPictureStart);
    WriteFile(root_ / "many/masks" / ("IMG_" + std::to_string(i) + ".jpg.png"), kPictureStart);
  }
  const std::string photos = (root_ / "hero/photos").string();
  const std::vector<std::string> poses = {"--pose", "rest=" + photos + "/rest",
                                          "--pose", "bent=" + photos + "/bent",
                                          "--pose", "many=" + (root_ / "many").string()};
  const auto init = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> all = {"init", (root_ / name).string()};
    all.insert(all.end(), poses.begin(), poses.end());
    all.insert(all.end(), more.begin(), more.end());
    return Keypose(all);
  };
  const Ended by_itself = init("a", {});
  ASSERT_EQ(by_itself.code, 0) << by_itself.text;
  EXPECT_THAT(by_itself.text, HasSubstr("4 photographs: 'rest' will be bent into them, instead of "
                                        "a scan of 'bent' from 16 or more (`method: fit`"));
  EXPECT_EQ(PoseLine(root_ / "a", "rest"), "  rest: photos/rest") << "the template is scanned";
  EXPECT_EQ(PoseLine(root_ / "a", "bent"), "  bent: {photos: photos/bent, method: fit}");
  EXPECT_EQ(PoseLine(root_ / "a", "many"), "  many: photos/many") << "masks are no photographs";
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "a").string()}).code, 0);
  ASSERT_EQ(init("b", {"--few", "many", "--scan", "bent"}).code, 0);
  EXPECT_EQ(PoseLine(root_ / "b", "bent"), "  bent: photos/bent");
  EXPECT_EQ(PoseLine(root_ / "b", "many"), "  many: {photos: photos/many, method: fit}");
}

TEST_F(InitTest, InitRefusesFewPhotographsOfTheTemplate) {
  const std::string photos = (root_ / "hero/photos").string(), fresh = (root_ / "new").string();
  const auto init = [&](const std::vector<std::string>& more) {
    std::vector<std::string> all = {
        "init", fresh, "--pose", "rest=" + photos + "/rest", "--pose", "bent=" + photos + "/bent"};
    all.insert(all.end(), more.begin(), more.end());
    return Keypose(all);
  };
  const Ended same = init({"--few", "rest"});
  EXPECT_EQ(same.code, 2);
  EXPECT_THAT(same.text, HasSubstr("--few rest: 'rest' is the template"));
  EXPECT_THAT(same.text, HasSubstr("name another pose with --template"));
  EXPECT_EQ(init({"--few", "rest", "--template", "bent"}).code, 0);
  fs::remove_all(fresh);
  const Ended unknown = init({"--few", "wave"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_THAT(unknown.text, HasSubstr("--few wave: there is no pose of that name"));
  const Ended both = init({"--few", "bent", "--scan", "bent"});
  EXPECT_EQ(both.code, 2);
  EXPECT_FALSE(fs::exists(fresh)) << "a refused project must leave nothing behind";
}

TEST_F(InitTest, InitOfAPerformanceLeavesFilmsAndCopiesTheRest) {
  WriteFile(root_ / "share/keypose/performance.yaml",
            "sources: {video: {of: shot}, calibration: {of: shot}, scan: {of: project}}\n"
            "steps:\n"
            "  gather: {stage: gather, for: shot, inputs: {photos: $video}}\n"
            "  join: {stage: join, for: shot, inputs: {images: gather.images}, out: {text: "
            "'{shot}/text.txt'}}\n");
  const fs::path films = root_ / "films/walk";
  fs::create_directories(films);
  WriteFile(films / "000.jpg", "walking\n");
  WriteFile(root_ / "films/rig.yml", "rig");
  WriteFile(root_ / "hero.obj", "clay");
  const auto before = Snapshot(root_ / "films");
  const Ended init =
      Keypose({"init", (root_ / "dance").string(), "--kind", "performance", "--shot",
               "walk=" + films.string(), "--calibration", (root_ / "films/rig.yml").string(),
               "--scan-mesh", (root_ / "hero.obj").string()});
  ASSERT_EQ(init.code, 0) << init.text;
  EXPECT_THAT(init.text, HasSubstr("walk: films stay in " + films.string()));
  const std::string yaml = ReadFile(root_ / "dance/pipeline.yaml");
  EXPECT_THAT(yaml, HasSubstr("kind: performance"));
  EXPECT_THAT(yaml, HasSubstr("video: " + films.string()));
  EXPECT_THAT(yaml, HasSubstr("calibration: " + (root_ / "films/rig.yml").string()));
  EXPECT_THAT(yaml, HasSubstr("scan: hero.obj"));
  EXPECT_EQ(ReadFile(root_ / "dance/hero.obj"), "clay");
  EXPECT_FALSE(fs::exists(root_ / "dance/films"));
  const Ended run = Keypose({"run", "-C", (root_ / "dance").string()});
  EXPECT_EQ(run.code, 0) << run.text;
  EXPECT_EQ(ReadFile(root_ / "dance/out/walk/text.txt"), "WALKING\n");
  EXPECT_EQ(Snapshot(root_ / "films"), before);
  EXPECT_THAT(yaml, Not(HasSubstr("video3d")));
  const Ended painted = Keypose({"init", (root_ / "painted").string(), "--kind", "performance",
                                 "--shot", "walk=" + films.string(), "--video3d", "--surface"});
  ASSERT_EQ(painted.code, 0) << painted.text;
  const std::string with = ReadFile(root_ / "painted/pipeline.yaml");
  EXPECT_THAT(with, HasSubstr("video3d: {enabled: true}"));
  EXPECT_THAT(with, HasSubstr("follow: {enabled: true}"));
  EXPECT_THAT(with, HasSubstr("transfer: {options: {space: template}}"));
}

TEST_F(InitTest, InitLeavesOutAndNamesWhatIsNoPhotograph) {
  WriteFile(root_ / "hero/photos/rest/IMG_0.mov", "film");
  WriteFile(root_ / "hero/photos/rest/.DS_Store", "x");
  const Ended ended = Keypose({"init", (root_ / "a new one").string(), "--pose",
                               "rest=" + (root_ / "hero/photos/rest").string()});
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("rest: 4 files copied"));
  EXPECT_THAT(ended.text, HasSubstr("no photographs that can be read: 1 .mov (IMG_0.mov)"));
  EXPECT_THAT(ended.text,
              HasSubstr("next: keypose run -C '" + (root_ / "a new one").string() + "'"));
  EXPECT_FALSE(fs::exists(root_ / "a new one/photos/rest/IMG_0.mov"));
}

TEST_F(RunTest, InitSaysHowAFilmBecomesPhotographs) {
  WriteFile(root_ / "turn.mkv", "\x1a\x45\xdf\xa3 and so on");
  const Ended pose = Keypose(
      {"init", (root_ / "new").string(), "--pose", "rest=" + (root_ / "turn.mkv").string()});
  EXPECT_EQ(pose.code, 3);
  EXPECT_THAT(pose.text, HasSubstr("is a film, and a pose is made of photographs"));
  EXPECT_THAT(pose.text, HasSubstr("-vf fps=2 -q:v 1 rest/%04d.jpg"));
  const Ended film = Keypose({"init", (root_ / "new").string(), "--pose",
                              "rest=" + (root_ / "hero/photos/rest").string(), "--film",
                              (root_ / "turn.mkv").string(), "--shows", "0=rest,4=rest"});
  EXPECT_EQ(film.code, 3);
  EXPECT_THAT(film.text, HasSubstr("-c copy film.mp4"));
  const Ended shot = Keypose({"init", (root_ / "new").string(), "--kind", "performance", "--shot",
                              "walk=" + (root_ / "turn.mkv").string()});
  EXPECT_EQ(shot.code, 3);
  EXPECT_THAT(shot.text, HasSubstr("is a film; put it into a folder"));
}

}  // namespace keypose::pipeline::init_test
