// Kills, missing files, damage and full disks while the program `keypose` runs, with real
// processes, files and signals.
#include <gmock/gmock.h>
#include <sys/stat.h>

#include <csignal>
#include <nlohmann/json.hpp>
#include <random>

#include "pipeline/testing/installed_house.h"

namespace keypose::pipeline::run_faults_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(RunTest, KilledAtTwentyRandomMomentsGivesTheSameBitsAndNoLitter) {
  const std::map<std::string, std::string> slow = {{"TEXT_STAGE_DELAY_MS", "25"}};
  MakeProject(root_ / "reference");
  const auto start = Clock::now();
  ASSERT_EQ(Keypose({"run", "-C", (root_ / "reference").string()}, slow).code, 0);
  const double whole = SecondsSince(start);
  std::mt19937 random(1);
  int killed_at_work = 0;
  // On a slow machine some kills come too late; then more are tried.
  for (int i = 0; i < 20 || (killed_at_work < 10 && i < 100); ++i) {
    // Every second time the pictures change, so that the run has work to do when it is killed.
    if (i % 2 == 0) WriteFile(root_ / "hero/photos/rest/IMG_2.jpg", "retake " + std::to_string(i));
    const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, slow);
    SleepSeconds(std::uniform_real_distribution<double>(0, whole)(random));
    kill(pid, SIGKILL);
    killed_at_work += Finish(pid).code == 128 + SIGKILL;
  }
  EXPECT_GE(killed_at_work, 10);
  WriteFile(root_ / "hero/photos/rest/IMG_2.jpg",
            ReadFile(root_ / "reference/photos/rest/IMG_2.jpg"));
  const Ended last = Run();
  ASSERT_EQ(last.code, 0) << last.text;
  EXPECT_TRUE(NoStageAliveSoon());
  EXPECT_EQ(Snapshot(root_ / "hero/out"), Snapshot(root_ / "reference/out"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/tmp"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/writing"));
  for (const auto& [name, text] : Snapshot(root_ / "hero"))
    EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
  // Every artifact in the cache is complete: its files match its manifest.
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "hero/.keypose/cache")) {
    if (entry.path().filename() != "manifest.json") continue;
    const auto manifest = nlohmann::json::parse(ReadFile(entry.path()));
    for (const auto& [name, file] : manifest.at("files").items())
      EXPECT_EQ(fs::file_size(entry.path().parent_path() / name),
                file.at("stamp").at(0).get<std::uintmax_t>());
  }
  EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, KilledRunnerTakesAllThatItsStagesStartedAlong) {
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()},
                          {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
  ASSERT_TRUE(WaitForStage());
  SleepSeconds(0.2);
  kill(pid, SIGKILL);
  Finish(pid);
  EXPECT_TRUE(NoStageAliveSoon());
  EXPECT_EQ(Run().code, 0);
}

TEST_F(RunTest, RunnerAndEitherGuardianKilledTogetherLeaveNothing) {
  for (int which = 0; which < 2; ++which)
    for (int round = 0; round < 5; ++round) {
      fs::remove_all(root_ / "hero/.keypose");
      const pid_t pid = Start({"run", "-C", (root_ / "hero").string(), "-j", "1"},
                              {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
      ASSERT_TRUE(WaitForStage());
      SleepSeconds(0.2);
      const std::vector<pid_t> watcher = ChildrenOf(pid);
      ASSERT_EQ(watcher.size(), 1U);
      const std::vector<pid_t> guardian = ChildrenOf(watcher[0]);
      ASSERT_EQ(guardian.size(), 1U);
      kill(which == 0 ? watcher[0] : guardian[0], SIGKILL);
      kill(pid, SIGKILL);
      Finish(pid);
      EXPECT_TRUE(NoStageAliveSoon());
    }
  EXPECT_EQ(Run().code, 0);
}

TEST_F(RunTest, KillingAllProcessesOfItsNameLeavesNothing) {
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()},
                          {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
  ASSERT_TRUE(WaitForStage());
  SleepSeconds(0.2);
  // Like `killall -9 keypose`, but only for this test's processes.
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream name_file(entry.path() / "comm");
    std::string name;
    std::error_code error;
    if (std::getline(name_file, name) && name == "keypose" &&
        fs::read_symlink(entry.path() / "exe", error) == root_ / "bin/keypose")
      kill(std::stoi(entry.path().filename().string()), SIGKILL);
  }
  EXPECT_EQ(Finish(pid).code, 128 + SIGKILL);
  EXPECT_TRUE(NoStageAliveSoon());
  EXPECT_EQ(Run().code, 0);
}

TEST_F(RunTest, GoesOnAfterAHangupUnderNohup) {
  const auto run = [&](bool nohup) {
    fs::remove_all(root_ / "hero/.keypose");
    if (nohup) ::signal(SIGHUP, SIG_IGN);
    const pid_t pid =
        Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "100"}});
    ::signal(SIGHUP, SIG_DFL);
    EXPECT_TRUE(WaitForStage());
    SleepSeconds(0.1);
    kill(pid, SIGHUP);
    return Finish(pid).code;
  };
  EXPECT_EQ(run(true), 0);
  EXPECT_EQ(run(false), 130);
}

TEST_F(RunTest, PhotographTakenAwayInMidRunAndPutBackChangesNoResult) {
  MakeProject(root_ / "reference");
  ASSERT_EQ(Keypose({"run", "-C", (root_ / "reference").string()}).code, 0);
  const fs::path photo = root_ / "hero/photos/rest/IMG_2.jpg";
  int spoilt = 0;
  for (int round = 0; round < 12; ++round) {
    fs::remove_all(root_ / "hero/.keypose");
    const pid_t pid =
        Start({"run", "-C", (root_ / "hero").string(), "-j", "1"}, {{"TEXT_STAGE_DELAY_MS", "15"}});
    ASSERT_TRUE(WaitForStage());
    SleepSeconds(0.005 * round);
    if (round % 2) {
      fs::rename(photo, root_ / "aside");
      SleepSeconds(0.02);
      fs::rename(root_ / "aside", photo);
    } else {
      const std::string text = ReadFile(photo);
      WriteFile(photo, "another picture\n");
      SleepSeconds(0.02);
      WriteFile(photo, text);
    }
    const Ended ended = Finish(pid);
    ASSERT_EQ(ended.code, 0) << ended.text;
    spoilt += ended.text.find("nothing of it was kept") != std::string::npos;
    EXPECT_EQ(Snapshot(root_ / "hero/out"), Snapshot(root_ / "reference/out")) << ended.text;
    EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero"));
  }
  EXPECT_GT(spoilt, 0);
}

TEST_F(RunTest, VerifyFindsWhatTheDiskDamagedWithoutATrace) {
  ASSERT_EQ(Run().code, 0);
  const std::string good = ReadFile(root_ / "hero/out/rest/text.txt");
  EXPECT_THAT(Keypose({"verify", "-C", (root_ / "hero").string()}).text,
              HasSubstr("all are as they were made"));
  int flipped = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "hero/.keypose/cache")) {
    if (entry.path().filename() != "text.txt" || flipped > 0) continue;
    std::string text = ReadFile(entry.path());
    text[0] ^= 1;
    WriteFile(entry.path(), text);
    // The stamp in the manifest is adjusted, as if no time had changed.
    struct stat info;
    ASSERT_EQ(stat(entry.path().c_str(), &info), 0);
    const fs::path file = entry.path().parent_path() / "manifest.json";
    auto manifest = nlohmann::json::parse(ReadFile(file));
    manifest["files"]["text.txt"]["stamp"] = {
        info.st_size, info.st_mtim.tv_sec * 1000000000 + info.st_mtim.tv_nsec,
        info.st_ctim.tv_sec * 1000000000 + info.st_ctim.tv_nsec, info.st_ino};
    manifest.erase("checksum");
    WriteFile(file, manifest.dump());
    ++flipped;
  }
  ASSERT_EQ(flipped, 1);
  EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero")) << "no time tells of it";
  const Ended verify = Keypose({"verify", "-C", (root_ / "hero").string()});
  EXPECT_EQ(verify.code, 4);
  EXPECT_THAT(verify.text, HasSubstr("damaged: text.txt is not as it was made"));
  EXPECT_THAT(verify.text, HasSubstr("made by join/"));
  EXPECT_EQ(Run().code, 0);
  EXPECT_EQ(ReadFile(root_ / "hero/out/rest/text.txt"), good);
  EXPECT_EQ(Keypose({"verify", "-C", (root_ / "hero").string()}).code, 0);
}

TEST_F(RunTest, LinksInCirclesPipesAndDevicesAmongPhotographsAreLeftOut) {
  ASSERT_EQ(Run().code, 0);
  fs::create_directory_symlink(".", root_ / "hero/photos/rest/again");
  fs::create_directory_symlink("../..", root_ / "hero/photos/rest/above");
  fs::create_symlink("/dev/zero", root_ / "hero/photos/rest/zero.jpg");
  ASSERT_EQ(mkfifo((root_ / "hero/photos/rest/pipe.jpg").c_str(), 0666), 0);
  const auto start = Clock::now();
  EXPECT_EQ(Keypose({"status", "-C", (root_ / "hero").string()}).code, 0);
  EXPECT_LT(SecondsSince(start), 10);
}

TEST_F(RunTest, AStageThatDescribesItselfForEverIsStopped) {
  fs::remove(root_ / "bin/keypose-join");
  WriteFile(root_ / "bin/keypose-join", "#!/bin/sh\nexec yes\n");
  chmod((root_ / "bin/keypose-join").c_str(), 0755);
  const Ended ended = Run();
  EXPECT_EQ(ended.code, 5);
  EXPECT_THAT(ended.text, HasSubstr("does not come to an end"));
}

TEST_F(RunTest, OfAHugeLogTheEndIsShown) {
  ASSERT_EQ(Run().code, 0);
  fs::path log;
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "hero/.keypose/cache"))
    if (entry.path().filename() == "log.txt" &&
        ReadFile(entry.path()).find("join") != std::string::npos)
      log = entry.path();
  ASSERT_FALSE(log.empty());
  std::ofstream(log, std::ios::app) << std::string(5'000'000, 'x') << "\nthe end\n";
  const Ended ended = Keypose({"log", "join", "-C", (root_ / "hero").string()});
  EXPECT_EQ(ended.code, 0);
  EXPECT_LT(ended.text.size(), 5'000'000U);
  EXPECT_THAT(ended.text, HasSubstr("the end\n"));
}

TEST_F(RunTest, LinksOutOfTheResultsAreRefused) {
  fs::create_directories(root_ / "elsewhere");
  fs::create_directories(root_ / "hero/out");
  fs::create_directory_symlink(root_ / "elsewhere", root_ / "hero/out/rest");
  const Ended ended = Run();
  EXPECT_EQ(ended.code, 4) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("outside of the project's results"));
  EXPECT_TRUE(fs::is_empty(root_ / "elsewhere"));
}

TEST_F(RunTest, DamagedStateFilesAreHarmless) {
  ASSERT_EQ(Run().code, 0);
  const auto results = Snapshot(root_ / "hero/out");
  for (const char* text :
       {"", "[", "7",
        "{\"photos/rest/IMG_0.jpg\": [\"a\", null, 3, 4, 5], \"lock\": 3, \"pid\": \"x\"}",
        "{\"rest/text.txt\": {\"step\": 3}}"})
    for (const char* file : {"hashes.json", "out.json", "stages.json", "lock"}) {
      WriteFile(root_ / "hero/.keypose" / file, text);
      const Ended ended = Run();
      EXPECT_EQ(ended.text, AllUpToDate(root_ / "hero")) << file << " was " << text;
      EXPECT_EQ(ended.code, 0);
      EXPECT_EQ(Snapshot(root_ / "hero/out"), results);
    }
}

TEST_F(RunTest, CtrlCStopsEverythingAndExitsWith130) {
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()},
                          {{"TEXT_STAGE_DELAY_MS", "500"}, {"TEXT_STAGE_SPAWN", "1"}});
  ASSERT_TRUE(WaitForStage());
  SleepSeconds(0.2);
  const auto start = Clock::now();
  kill(pid, SIGINT);
  const Ended ended = Finish(pid);
  EXPECT_LT(SecondsSince(start), 4.0);
  EXPECT_EQ(ended.code, 130);
  EXPECT_THAT(ended.text, HasSubstr("interrupted"));
  EXPECT_EQ(StagesAlive(), 0);
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/tmp"));
  EXPECT_EQ(Run().code, 0);
}

TEST_F(RunTest, StageThatLeavesAProcessBehindDoesNotHoldTheRunUp) {
  const Ended ended = Run({}, {{"TEXT_STAGE_SPAWN", "1"}});
  EXPECT_EQ(ended.code, 0) << ended.text;
  EXPECT_EQ(StagesAlive(), 0);
}

TEST_F(RunTest, SecondRunAtTheSameTimeExitsWith7AndNamesTheFirst) {
  const pid_t pid =
      Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "1500"}});
  ASSERT_TRUE(WaitForStage());
  const Ended second = Run();
  EXPECT_EQ(second.code, 7);
  EXPECT_THAT(second.text, HasSubstr("process " + std::to_string(pid) + " on "));
  EXPECT_THAT(second.text, HasSubstr("since 20"));
  EXPECT_EQ(Keypose({"unlock", "-C", (root_ / "hero").string()}).code, 7);
  EXPECT_EQ(Keypose({"status", "-C", (root_ / "hero").string()}).code, 0)
      << "looking needs no lock";
  kill(pid, SIGINT);
  EXPECT_EQ(Finish(pid).code, 130);
  EXPECT_EQ(Keypose({"unlock", "-C", (root_ / "hero").string()}).text,
            "the project is not locked\n");
}

TEST_F(RunTest, FullDiskIsExitCode4AndTheRunGoesOnLater) {
  fs::create_directories(root_ / "small");
  if (mount("keypose-test", (root_ / "small").c_str(), "tmpfs", 0, "size=400k") != 0)
    GTEST_SKIP() << "mounting a small tmpfs needs privileges that are not here";
  mounted_ = true;
  MakeProject(root_ / "small/hero");
  for (int i = 0; i < 4; ++i)
    WriteFile(root_ / "small/hero/photos/rest" / ("IMG_" + std::to_string(i) + ".jpg"),
              std::string(30000, 'a'));
  const std::vector<std::string> run = {"run", "-C", (root_ / "small/hero").string()};
  const Ended full = Keypose(run);
  EXPECT_EQ(full.code, 4) << full.text;
  EXPECT_THAT(full.text, HasSubstr("error: "));
  ASSERT_EQ(mount("keypose-test", (root_ / "small").c_str(), "tmpfs", MS_REMOUNT, "size=8m"), 0);
  const Ended roomy = Keypose(run);
  EXPECT_EQ(roomy.code, 0) << roomy.text;
  EXPECT_EQ(ReadFile(root_ / "small/hero/out/rest/text.txt"), std::string(120000, 'A'));
}

}  // namespace keypose::pipeline::run_faults_test
