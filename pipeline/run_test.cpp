// The program `keypose` with real processes, files and signals; its stages are small text programs.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>

#include "core/io/files.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;
using Clock = std::chrono::steady_clock;

const char kTestPipeline[] = R"(steps:
  gather: {stage: gather, for: pose, inputs: {photos: $photos}}
  join: {stage: join, for: pose, inputs: {images: gather.images}, out: {text: "{pose}/text.txt"}}
  merge: {stage: merge, for: project, inputs: {texts: join.text@all}, out: {all: all}, show: {all: all texts, all/9.txt: the tenth}}
)";

double SecondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }
void SleepSeconds(double seconds) { std::this_thread::sleep_for(std::chrono::duration<double>(seconds)); }

/// All files below a folder with their content; times and the run records do not count.
std::map<std::string, std::string> Snapshot(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files[entry.path().lexically_relative(folder).string()] = ReadFile(entry.path());
  }
  return files;
}

/// What a run says that has nothing to do.
std::string AllUpToDate(const fs::path& project) {
  return "5 steps up to date\n\nresults\n  all texts  " + (project / "out/all").string() + "\n";
}

struct Ended {
  int code = -1;
  std::string text;  ///< standard output and error
};

class RunTest : public ::testing::Test {
 protected:
  void SetUp() override {
    char name[] = "/tmp/keypose-run-test-XXXXXX";
    root_ = mkdtemp(name);
    Install(root_);
    MakeProject(root_ / "hero");
  }
  void TearDown() override {
    if (mounted_) umount2((root_ / "small").c_str(), MNT_DETACH);
    fs::remove_all(root_);
  }

  /// keypose and its test stages as an installation of their own.
  static void Install(const fs::path& root) {
    fs::create_directories(root / "bin");
    fs::create_directories(root / "share/keypose");
    fs::copy_file(KEYPOSE_PROGRAM, root / "bin/keypose");
    for (const std::string stage : {"gather", "join", "merge"}) fs::copy_file(KEYPOSE_TEXT_STAGE, root / ("bin/keypose-" + stage));
    WriteFile(root / "share/keypose/pipeline.yaml", kTestPipeline);
  }
  static void MakeProject(const fs::path& project) {
    for (const std::string pose : {"rest", "bent"}) {
      fs::create_directories(project / "photos" / pose);
      for (int i = 0; i < 4; ++i)
        WriteFile(project / "photos" / pose / ("IMG_" + std::to_string(i) + ".jpg"), pose + " picture " + std::to_string(i) + "\n");
    }
    WriteFile(project / "pipeline.yaml", "poses: {rest: photos/rest, bent: photos/bent}\n");
  }

  pid_t Start(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment = {}) const {
    const pid_t pid = fork();
    if (pid != 0) return pid;
    const int out = open((root_ / ("output" + std::to_string(getpid()))).c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0666);
    dup2(out, 1);
    dup2(out, 2);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    std::vector<std::string> all = {(root_ / "bin/keypose").string()};
    all.insert(all.end(), arguments.begin(), arguments.end());
    std::vector<char*> argv;
    for (std::string& text : all) argv.push_back(text.data());
    argv.push_back(nullptr);
    execv(argv[0], argv.data());
    _exit(126);
  }
  Ended Finish(pid_t pid) const {
    int status = 0;
    waitpid(pid, &status, 0);
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), ReadFile(root_ / ("output" + std::to_string(pid)))};
  }
  Ended Keypose(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment = {}) const {
    return Finish(Start(arguments, environment));
  }
  Ended Run(const std::vector<std::string>& more = {}, const std::map<std::string, std::string>& environment = {}) const {
    std::vector<std::string> arguments = {"run", "-C", (root_ / "hero").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return Keypose(arguments, environment);
  }

  /// Processes whose program lies in this test's bin/.
  int StagesAlive() const {
    int count = 0;
    for (const auto& entry : fs::directory_iterator("/proc")) {
      std::error_code error;
      const fs::path program = fs::read_symlink(entry.path() / "exe", error);
      count += !error && program.string().starts_with((root_ / "bin/keypose-").string());
    }
    return count;
  }
  static std::vector<pid_t> ChildrenOf(pid_t parent) {
    std::ifstream in("/proc/" + std::to_string(parent) + "/task/" + std::to_string(parent) + "/children");
    std::vector<pid_t> children;
    for (pid_t child = 0; in >> child;) children.push_back(child);
    return children;
  }
  bool NoStageAliveSoon() const {
    for (int i = 0; i < 100 && StagesAlive() > 0; ++i) SleepSeconds(0.02);
    return StagesAlive() == 0;
  }
  /// Until a step is at work (a program that only describes itself does not count).
  bool WaitForStage() const {
    const auto at_work = [&] { return fs::exists(root_ / "hero/.keypose/tmp/gather.rest/made/log.txt"); };
    for (int i = 0; i < 1000 && !at_work(); ++i) SleepSeconds(0.01);
    return at_work();
  }

  fs::path root_;
  bool mounted_ = false;
};

TEST_F(RunTest, MakesResultsThenDoesNothingInUnderASecond) {
  const Ended first = Run();
  ASSERT_EQ(first.code, 0) << first.text;
  EXPECT_EQ(ReadFile(root_ / "hero/out/rest/text.txt"), "REST PICTURE 0\nREST PICTURE 1\nREST PICTURE 2\nREST PICTURE 3\n");
  const auto start = Clock::now();
  const Ended second = Run();
  EXPECT_LT(SecondsSince(start), 1.0);
  EXPECT_EQ(second.code, 0);
  EXPECT_EQ(second.text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, KilledAtTwentyRandomMomentsGivesTheSameBitsAndNoLitter) {
  const std::map<std::string, std::string> slow = {{"TEXT_STAGE_DELAY_MS", "25"}};
  MakeProject(root_ / "reference");
  const auto start = Clock::now();
  ASSERT_EQ(Keypose({"run", "-C", (root_ / "reference").string()}, slow).code, 0);
  const double whole = SecondsSince(start);
  std::mt19937 random(1);
  int killed_at_work = 0;
  // On a slow day some come too late: more are tried then.
  for (int i = 0; i < 20 || (killed_at_work < 10 && i < 100); ++i) {
    // Work for the run to be killed in: every second time the pictures change.
    if (i % 2 == 0) WriteFile(root_ / "hero/photos/rest/IMG_2.jpg", "retake " + std::to_string(i));
    const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, slow);
    SleepSeconds(std::uniform_real_distribution<double>(0, whole)(random));
    kill(pid, SIGKILL);
    killed_at_work += Finish(pid).code == 128 + SIGKILL;
  }
  EXPECT_GE(killed_at_work, 10);
  WriteFile(root_ / "hero/photos/rest/IMG_2.jpg", ReadFile(root_ / "reference/photos/rest/IMG_2.jpg"));
  const Ended last = Run();
  ASSERT_EQ(last.code, 0) << last.text;
  EXPECT_TRUE(NoStageAliveSoon());
  EXPECT_EQ(Snapshot(root_ / "hero/out"), Snapshot(root_ / "reference/out"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/tmp"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/writing"));
  for (const auto& [name, text] : Snapshot(root_ / "hero")) EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
  // Every artifact in the cache is whole: its files are as its manifest says.
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "hero/.keypose/cache")) {
    if (entry.path().filename() != "manifest.json") continue;
    const auto manifest = nlohmann::json::parse(ReadFile(entry.path()));
    for (const auto& [name, file] : manifest.at("files").items())
      EXPECT_EQ(fs::file_size(entry.path().parent_path() / name), file.at("stamp").at(0).get<std::uintmax_t>());
  }
  EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, KilledRunnerTakesAllThatItsStagesStartedAlong) {
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
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
      const pid_t pid =
          Start({"run", "-C", (root_ / "hero").string(), "-j", "1"}, {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
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
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "2000"}, {"TEXT_STAGE_SPAWN", "1"}});
  ASSERT_TRUE(WaitForStage());
  SleepSeconds(0.2);
  // What `killall -9 keypose` does, for this test's processes alone.
  for (const auto& entry : fs::directory_iterator("/proc")) {
    std::ifstream name_file(entry.path() / "comm");
    std::string name;
    std::error_code error;
    if (std::getline(name_file, name) && name == "keypose" && fs::read_symlink(entry.path() / "exe", error) == root_ / "bin/keypose")
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
    const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "100"}});
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
    const pid_t pid = Start({"run", "-C", (root_ / "hero").string(), "-j", "1"}, {{"TEXT_STAGE_DELAY_MS", "15"}});
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
  EXPECT_THAT(Keypose({"verify", "-C", (root_ / "hero").string()}).text, HasSubstr("all are as they were made"));
  int flipped = 0;
  for (const auto& entry : fs::recursive_directory_iterator(root_ / "hero/.keypose/cache")) {
    if (entry.path().filename() != "text.txt" || flipped > 0) continue;
    std::string text = ReadFile(entry.path());
    text[0] ^= 1;
    WriteFile(entry.path(), text);
    // The stamp in the manifest is made to fit, as if no time had changed.
    struct stat info;
    ASSERT_EQ(stat(entry.path().c_str(), &info), 0);
    const fs::path file = entry.path().parent_path() / "manifest.json";
    auto manifest = nlohmann::json::parse(ReadFile(file));
    manifest["files"]["text.txt"]["stamp"] = {info.st_size, info.st_mtim.tv_sec * 1000000000 + info.st_mtim.tv_nsec,
                                              info.st_ctim.tv_sec * 1000000000 + info.st_ctim.tv_nsec, info.st_ino};
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
    if (entry.path().filename() == "log.txt" && ReadFile(entry.path()).find("join") != std::string::npos) log = entry.path();
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
  for (const char* text : {"", "[", "7", "{\"photos/rest/IMG_0.jpg\": [\"a\", null, 3, 4, 5], \"lock\": 3, \"pid\": \"x\"}",
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
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "500"}, {"TEXT_STAGE_SPAWN", "1"}});
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
  const pid_t pid = Start({"run", "-C", (root_ / "hero").string()}, {{"TEXT_STAGE_DELAY_MS", "1500"}});
  ASSERT_TRUE(WaitForStage());
  const Ended second = Run();
  EXPECT_EQ(second.code, 7);
  EXPECT_THAT(second.text, HasSubstr("process " + std::to_string(pid) + " on "));
  EXPECT_THAT(second.text, HasSubstr("since 20"));
  EXPECT_EQ(Keypose({"unlock", "-C", (root_ / "hero").string()}).code, 7);
  EXPECT_EQ(Keypose({"status", "-C", (root_ / "hero").string()}).code, 0) << "looking needs no lock";
  kill(pid, SIGINT);
  EXPECT_EQ(Finish(pid).code, 130);
  EXPECT_EQ(Keypose({"unlock", "-C", (root_ / "hero").string()}).text, "the project is not locked\n");
}

TEST_F(RunTest, FullDiskIsExitCode4AndTheRunGoesOnLater) {
  fs::create_directories(root_ / "small");
  if (mount("keypose-test", (root_ / "small").c_str(), "tmpfs", 0, "size=400k") != 0)
    GTEST_SKIP() << "mounting a small tmpfs needs privileges that are not here";
  mounted_ = true;
  MakeProject(root_ / "small/hero");
  for (int i = 0; i < 4; ++i) WriteFile(root_ / "small/hero/photos/rest" / ("IMG_" + std::to_string(i) + ".jpg"), std::string(30000, 'a'));
  const std::vector<std::string> run = {"run", "-C", (root_ / "small/hero").string()};
  const Ended full = Keypose(run);
  EXPECT_EQ(full.code, 4) << full.text;
  EXPECT_THAT(full.text, HasSubstr("error: "));
  ASSERT_EQ(mount("keypose-test", (root_ / "small").c_str(), "tmpfs", MS_REMOUNT, "size=8m"), 0);
  const Ended roomy = Keypose(run);
  EXPECT_EQ(roomy.code, 0) << roomy.text;
  EXPECT_EQ(ReadFile(root_ / "small/hero/out/rest/text.txt"), std::string(120000, 'A'));
}

TEST_F(RunTest, MovedAndCopiedProjectsRunNothing) {
  ASSERT_EQ(Run().code, 0);
  fs::rename(root_ / "hero", root_ / "moved");
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "moved").string()}).text, AllUpToDate(root_ / "moved"));
  fs::copy(root_ / "moved", root_ / "copied", fs::copy_options::recursive);
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "copied").string()}).text, AllUpToDate(root_ / "copied"));
}

TEST_F(RunTest, ExplainAndStatusSayWhatChanged) {
  EXPECT_THAT(Keypose({"status", "-C", (root_ / "hero").string()}).text, HasSubstr("never ran"));
  ASSERT_EQ(Run().code, 0);
  WriteFile(root_ / "hero/photos/bent/IMG_3.jpg", "retake\n");
  EXPECT_THAT(Keypose({"explain", "join/bent", "-C", (root_ / "hero").string()}).text, HasSubstr("photos/bent/IMG_3.jpg changed"));
  EXPECT_THAT(Keypose({"status", "-C", (root_ / "hero").string()}).text,
              HasSubstr("gather/bent  would run    photos/bent/IMG_3.jpg changed"));
  const Ended run = Run();
  EXPECT_THAT(run.text, HasSubstr("gather/bent starts"));
  EXPECT_THAT(run.text, Not(HasSubstr("gather/rest")));
  const std::string after = Keypose({"explain", "gather/bent", "-C", (root_ / "hero").string()}).text;
  EXPECT_THAT(after, HasSubstr("gather/bent is up to date\nit last ran at 20"));
  EXPECT_THAT(after, HasSubstr("because\n  - photos/bent/IMG_3.jpg changed\n"));
}

TEST_F(RunTest, FailureExitsWithTheStagesCodeAndKeepsItsLog) {
  const Ended ended = Run({"--set", "join.exit_code=6"});
  EXPECT_EQ(ended.code, 6);
  EXPECT_THAT(ended.text, HasSubstr("failed with exit code 6"));
  EXPECT_THAT(ended.text, HasSubstr("told to fail"));
  EXPECT_THAT(Keypose({"log", "join", "-C", (root_ / "hero").string()}).text, HasSubstr("join at work"));
  EXPECT_EQ(Run({"--set", "join.exit_code=139"}).code, 1) << "a crash is a bug";
}

TEST_F(RunTest, OwnExecutableJoinsByNameInTheFile) {
  fs::create_directories(root_ / "hero/tools");
  WriteFile(root_ / "hero/tools/count",
            "#!/bin/sh\n"
            "if [ \"$1\" = --describe ]; then\n"
            "  echo '{\"schema\":1,\"stage\":\"count\",\"version\":\"1\",\"inputs\":[{\"name\":\"text\",\"kind\":\"file\"}],'\n"
            "  echo '\"outputs\":[{\"name\":\"lines\",\"kind\":\"file\",\"file\":\"lines.txt\"}]}'\n"
            "  exit\n"
            "fi\n"
            "wc -l < \"$2\" > \"$4\"\n");
  chmod((root_ / "hero/tools/count").c_str(), 0755);
  WriteFile(root_ / "hero/pipeline.yaml",
            "poses: {rest: photos/rest}\nsteps:\n  count: {program: tools/count, for: pose, inputs: {text: join.text}, out: {lines: "
            "'{pose}/lines.txt'}}\n");
  const Ended ended = Run();
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_EQ(ReadFile(root_ / "hero/out/rest/lines.txt"), "4\n");
}

TEST_F(RunTest, InitCopiesPhotographsAndLeavesOriginals) {
  const auto before = Snapshot(root_ / "hero/photos");
  const std::string rest = "rest=" + (root_ / "hero/photos/rest").string(), bent = "bent=" + (root_ / "hero/photos/bent").string();
  const Ended ended = Keypose({"init", (root_ / "new").string(), "--pose", rest, "--pose", bent, "--template", "bent"});
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_EQ(Snapshot(root_ / "new/photos"), before);
  EXPECT_EQ(Snapshot(root_ / "hero/photos"), before);
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "new").string()}).code, 0);
  EXPECT_EQ(ReadFile(root_ / "new/out/all/0.txt").substr(0, 4), "BENT") << "the template comes first";
  EXPECT_EQ(Keypose({"init", (root_ / "new").string(), "--pose", rest}).code, 2) << "a folder with content is not overwritten";
  EXPECT_EQ(Keypose({"init", (root_ / "other").string(), "--pose", "rest=/no/such/folder"}).code, 3);
}

TEST_F(RunTest, JsonLinesParse) {
  const Ended ended = Run({"--progress", "jsonl"});
  ASSERT_EQ(ended.code, 0);
  std::istringstream lines(ended.text);
  std::map<std::string, int> events;
  for (std::string line; std::getline(lines, line);) ++events[nlohmann::json::parse(line).at("event").get<std::string>()];
  EXPECT_EQ(events["begin"], 1);
  EXPECT_EQ(events["start"], 5);
  EXPECT_EQ(events["finish"], 5);
  EXPECT_GT(events["progress"], 0);
  EXPECT_EQ(events["end"], 1);
}

TEST_F(RunTest, EndRepeatsWarningsVerdictsAndResultsAlsoFromTheCache) {
  const Ended first = Run({}, {{"TEXT_STAGE_WARNING", "two landmarks look swapped"}, {"TEXT_STAGE_GRADE", "look"}});
  ASSERT_EQ(first.code, 0) << first.text;
  const std::string end =
      "\n1 warning\n  rest, bent\n    gather: two landmarks look swapped\n\nverdicts\n  rest  look  it was told so\n\nresults\n"
      "  all texts  " +
      (root_ / "hero/out/all").string() + "\n";
  EXPECT_THAT(first.text, ::testing::EndsWith("5 made, 0 steps up to date\n" + end));
  EXPECT_EQ(Run().text, "5 steps up to date\n" + end);
  const std::string status = Keypose({"status", "-C", (root_ / "hero").string()}).text;
  EXPECT_THAT(status, HasSubstr("verdicts\n  rest  look  it was told so\n"));
  EXPECT_THAT(status, HasSubstr("1 warning of the steps that are up to date"));
}

TEST_F(RunTest, EndIsInJsonLinesAndInTheRunRecord) {
  const Ended ended = Run({"--progress", "jsonl"}, {{"TEXT_STAGE_WARNING", "dark"}, {"TEXT_STAGE_GRADE", "good"}});
  std::vector<nlohmann::json> last;
  std::istringstream lines(ended.text);
  for (std::string line; std::getline(lines, line);) last.push_back(nlohmann::json::parse(line));
  ASSERT_GE(last.size(), 4u);
  const std::vector<nlohmann::json> end(last.end() - 4, last.end());
  EXPECT_EQ(end[0]["event"], "warning");
  EXPECT_EQ(end[0]["text"], "dark");
  EXPECT_EQ(end[0]["steps"], nlohmann::json::array({"gather/rest", "gather/bent"}));
  EXPECT_EQ(end[1]["event"], "verdict");
  EXPECT_EQ(end[1]["grade"], "good");
  EXPECT_EQ(end[2]["event"], "result");
  EXPECT_EQ(end[2]["path"], (root_ / "hero/out/all").string());
  EXPECT_EQ(end[3]["event"], "end");
  for (const nlohmann::json& line : last) {
    const bool at_work = line["event"] == "progress" || line["event"] == "start";
    EXPECT_TRUE(!at_work || line["overall"].get<double>() < 1) << line;
  }
  const fs::path run = fs::directory_iterator(root_ / "hero/.keypose/runs")->path();
  const auto record = nlohmann::json::parse(ReadFile(run));
  EXPECT_EQ(record["warnings"][0]["text"], "dark");
  EXPECT_EQ(record["verdicts"][0]["about"], "rest");
  EXPECT_EQ(record["results"][0]["label"], "all texts");
}

TEST_F(RunTest, FailedRunTellsWarningsOfWhatWasMadeAndNoResult) {
  const Ended ended = Run({"--set", "join.exit_code=3"}, {{"TEXT_STAGE_WARNING", "dark"}});
  EXPECT_EQ(ended.code, 3);
  EXPECT_THAT(ended.text, HasSubstr("gather: dark"));
  EXPECT_THAT(ended.text, HasSubstr(" failed\n"));
  EXPECT_THAT(ended.text, Not(HasSubstr("results\n")));
}

TEST_F(RunTest, ReaderThatHasSeenEnoughIsNoFault) {
  ASSERT_EQ(Run({}, {{"TEXT_STAGE_LOG_LINES", "20000"}}).code, 0);
  const std::string keypose = (root_ / "bin/keypose").string(), hero = (root_ / "hero").string();
  const auto shell = [&](const std::string& command) {
    const fs::path said = root_ / "said.txt";
    const int code = std::system((command + " > " + said.string() + " 2>&1").c_str());
    return Ended{WEXITSTATUS(code), ReadFile(said)};
  };
  const Ended log = shell("bash -o pipefail -c '" + keypose + " log gather/rest -C " + hero + " | head -n 1 > /dev/null'");
  EXPECT_EQ(log.text, "");
  EXPECT_EQ(log.code, 0);
  WriteFile(root_ / "hero/photos/rest/IMG_2.jpg", "retake\n");
  const Ended run = shell("bash -o pipefail -c 'TEXT_STAGE_DELAY_MS=50 " + keypose + " run -C " + hero + " | head -n 1 > /dev/null'");
  EXPECT_EQ(run.text, "");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(ReadFile(root_ / "hero/out/rest/text.txt"), HasSubstr("RETAKE")) << "a run goes on though nobody listens";
}

TEST_F(RunTest, InitRefusesFoldersThatCannotBePoses) {
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
  WriteFile(root_ / "empty/a.CR2", "raw");
  WriteFile(root_ / "empty/b.cr2", "raw");
  const Ended raw = init(photos + "/rest", (root_ / "empty").string());
  EXPECT_EQ(raw.code, 3);
  EXPECT_THAT(raw.text, HasSubstr("2 .cr2 (a.CR2, b.cr2)"));
  EXPECT_THAT(raw.text, HasSubstr(".heic"));
  EXPECT_THAT(raw.text, HasSubstr("develop RAW files to JPEG"));
  EXPECT_FALSE(fs::exists(fresh)) << "a refused project must leave nothing behind";
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: photos/rest}\n");
  const Ended run = Run();
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.text, HasSubstr("pipeline.yaml:1: the poses 'rest' and 'bent' have the same photographs"));
}

TEST_F(RunTest, InitLeavesOutAndNamesWhatIsNoPhotograph) {
  WriteFile(root_ / "hero/photos/rest/IMG_0.mov", "film");
  WriteFile(root_ / "hero/photos/rest/.DS_Store", "x");
  const Ended ended = Keypose({"init", (root_ / "a new one").string(), "--pose", "rest=" + (root_ / "hero/photos/rest").string()});
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ended.text, HasSubstr("rest: 4 files copied"));
  EXPECT_THAT(ended.text, HasSubstr("no photographs that can be read: 1 .mov (IMG_0.mov)"));
  EXPECT_THAT(ended.text, HasSubstr("next: keypose run -C '" + (root_ / "a new one").string() + "'"));
  EXPECT_FALSE(fs::exists(root_ / "a new one/photos/rest/IMG_0.mov"));
}

TEST_F(RunTest, PosesAreNamedInAnyLanguageAndSpelling) {
  // "mähen", its umlaut as one letter and as macOS writes it: a, then two dots.
  const std::string composed = "m\u00e4hen", apart = "ma\u0308hen";
  fs::rename(root_ / "hero/photos/bent", root_ / "hero/photos" / apart);
  const Ended init = Keypose({"init", (root_ / "new").string(), "--pose", "rest=" + (root_ / "hero/photos/rest").string(), "--pose",
                              composed + "=" + (root_ / "hero/photos" / composed).string(), "--template", apart});
  ASSERT_EQ(init.code, 0) << init.text;
  const std::string project = (root_ / "new").string();
  fs::rename(root_ / "new/photos" / composed, root_ / "new/photos" / apart);  // as a Mac's archive would bring it
  const Ended run = Keypose({"run", "-C", project, "--set", "join/" + apart + ".exit_code=0"});
  ASSERT_EQ(run.code, 0) << run.text;
  EXPECT_THAT(ReadFile(root_ / "new/out" / composed / "text.txt"), HasSubstr("BENT PICTURE"));
  EXPECT_EQ(ReadFile(root_ / "new/out/all/0.txt").substr(0, 4), "BENT") << "the template, named in the other spelling, comes first";
  for (const std::string& name : {composed, apart}) {
    EXPECT_THAT(Keypose({"log", "join/" + name, "-C", project}).text, HasSubstr("join at work"));
    EXPECT_THAT(Keypose({"explain", "join/" + name, "-C", project}).text, HasSubstr("join/" + composed + " is up to date"));
  }
  EXPECT_THAT(Keypose({"status", "-C", project}).text, HasSubstr("gather/" + composed + "  up to date"));
  EXPECT_THAT(Keypose({"graph", "--dot", "-C", project}).text, HasSubstr("\"gather/" + composed + "\" -> \"join/" + composed + "\""));
  const Ended twice = Keypose({"init", (root_ / "other").string(), "--pose", composed + "=" + project, "--pose", apart + "=" + project});
  EXPECT_EQ(twice.code, 2) << "one name in two spellings is one name";
  EXPECT_EQ(Keypose({"init", (root_ / "other").string(), "--pose", "m\xe4hen=" + project}).code, 2) << "Latin-1 is no UTF-8";
}

TEST_F(RunTest, HomeIsWrittenAsATilde) {
  fs::rename(root_ / "hero/photos/bent", root_ / "elsewhere");
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: ~/elsewhere}\n");
  const std::map<std::string, std::string> home = {{"HOME", root_.string()}};
  const Ended ended = Run({}, home);
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ReadFile(root_ / "hero/out/bent/text.txt"), HasSubstr("BENT PICTURE"));
  EXPECT_EQ(Keypose({"init", (root_ / "new").string(), "--pose", "bent=~/elsewhere"}, home).code, 0);
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: ~ann/elsewhere}\n");
  EXPECT_THAT(Run({}, home).text, HasSubstr("only your own home folder can be written as ~"));
}

TEST_F(RunTest, GcRemovesWhatNothingRefersTo) {
  ASSERT_EQ(Run().code, 0);
  ASSERT_EQ(Run({"--set", "gather.exit_code=0"}).code, 0);
  WriteFile(root_ / "hero/photos/rest/IMG_0.jpg", "other\n");
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(Keypose({"gc", "-C", (root_ / "hero").string(), "--keep-runs", "1", "--dry-run"}).text,
              HasSubstr("would remove 3 artifacts"));
  EXPECT_THAT(Keypose({"gc", "-C", (root_ / "hero").string(), "--keep-runs", "1"}).text, HasSubstr("removed 3 artifacts"));
  EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, WordsOfTheCommandLineAreChecked) {
  EXPECT_EQ(Keypose({"rnu"}).code, 2);
  EXPECT_THAT(Keypose({"rnu"}).text, HasSubstr("did you mean 'run'?"));
  EXPECT_EQ(Keypose({"studio"}).code, 2);
  EXPECT_EQ(Keypose({"pack"}).code, 2);
  EXPECT_EQ(Run({"--executor", "slurm"}).code, 2);
  EXPECT_EQ(Run({"-j", "0"}).code, 2);
  EXPECT_EQ(Keypose({"run", "-C", root_.string()}).code, 2) << "not a project";
  EXPECT_THAT(Keypose({"run", (root_ / "hero").string()}).text, HasSubstr("named with -C, as in -C " + (root_ / "hero").string()));
  EXPECT_EQ(Keypose({"gather", "--describe"}).code, 0) << "`keypose STAGE` becomes the stage";
}

TEST_F(RunTest, DryRunChangesNothing) {
  const Ended ended = Run({"--dry-run"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.text, HasSubstr("would run gather/rest: it has never run"));
  EXPECT_FALSE(fs::exists(root_ / "hero/out"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/cache"));
}

}  // namespace
}  // namespace keypose::pipeline
