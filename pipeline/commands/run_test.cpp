// The program `keypose`, with real processes and files.
#include <gmock/gmock.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "pipeline/testing/installed_house.h"

namespace keypose::pipeline::run_test {

using ::testing::HasSubstr;
using ::testing::Not;

TEST_F(RunTest, MakesResultsThenDoesNothingInAPartOfTheTime) {
  const auto begin = Clock::now();
  const Ended first = Run();
  const double first_s = SecondsSince(begin);
  ASSERT_EQ(first.code, 0) << first.text;
  EXPECT_EQ(ReadFile(root_ / "hero/out/rest/text.txt"),
            "REST PICTURE 0\nREST PICTURE 1\nREST PICTURE 2\nREST PICTURE 3\n");
  const auto start = Clock::now();
  const Ended second = Run();
  EXPECT_LT(SecondsSince(start), 0.5 * first_s);
  EXPECT_EQ(second.code, 0);
  EXPECT_EQ(second.text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, MovedAndCopiedProjectsRunNothing) {
  ASSERT_EQ(Run().code, 0);
  fs::rename(root_ / "hero", root_ / "moved");
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "moved").string()}).text, AllUpToDate(root_ / "moved"));
  fs::copy(root_ / "moved", root_ / "copied", fs::copy_options::recursive);
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "copied").string()}).text,
            AllUpToDate(root_ / "copied"));
}

/// Unpacks with a program that is not ours.
void Unzip(const fs::path& archive, const fs::path& into) {
  const std::string command =
      "python3 -m zipfile -e '" + archive.string() + "' '" + into.string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0);
}

TEST_F(RunTest, PackedProjectRunsNothingWhereItIsUnpacked) {
  fs::rename(root_ / "hero", root_ / "Äffchen");
  const std::string project = (root_ / "Äffchen").string(), zip = (root_ / "all.zip").string();
  ASSERT_EQ(Keypose({"run", "-C", project}).code, 0);
  fs::create_directories(root_ / "Äffchen/.keypose/cache/00/1111");
  WriteFile(root_ / "Äffchen/.keypose/cache/00/1111/old.txt", "nothing refers to this");
  const Ended packed = Keypose({"pack", "-C", project, "-o", zip});
  ASSERT_EQ(packed.code, 0) << packed.text;
  EXPECT_THAT(packed.text, HasSubstr("all.zip: "));
  fs::rename(root_ / "Äffchen", root_ / "away");
  Unzip(zip, root_ / "there");
  const fs::path there = root_ / "there/Äffchen";
  EXPECT_FALSE(fs::exists(there / ".keypose/cache/00"));
  EXPECT_EQ(Snapshot(there / "photos"), Snapshot(root_ / "away/photos"));
  EXPECT_EQ(Keypose({"run", "-C", there.string()}).text, AllUpToDate(there));

  const Ended again = Keypose({"pack", "-C", there.string(), "-o", zip});
  EXPECT_EQ(again.code, 4) << again.text;
  EXPECT_THAT(again.text, HasSubstr("exists already"));
}

TEST_F(RunTest, PackWithoutTheCacheHoldsWhatThePersonMade) {
  ASSERT_EQ(Run().code, 0);
  const std::string hero = (root_ / "hero").string();
  const fs::path inside = root_ / "hero/hero.zip";
  ASSERT_EQ(Keypose({"pack", "-C", hero, "--without-cache", "-o", inside.string()}).code, 0);
  Unzip(inside, root_ / "there");
  EXPECT_FALSE(fs::exists(root_ / "there/hero/.keypose"));
  EXPECT_FALSE(fs::exists(root_ / "there/hero/hero.zip")) << "it does not hold itself";
  EXPECT_TRUE(fs::exists(root_ / "there/hero/out/rest/text.txt"));
  EXPECT_EQ(Keypose({"run", "-C", (root_ / "there/hero").string()}).code, 0);
}

TEST_F(RunTest, PackSaysWhatLiesOutsideOfTheProject) {
  fs::create_directories(root_ / "elsewhere");
  WriteFile(root_ / "elsewhere/IMG_0.jpg", "picture\n");
  WriteFile(root_ / "hero/pipeline.yaml", "poses:\n  rest: ../elsewhere\n");
  const std::string zip = (root_ / "all.zip").string();
  const Ended packed = Keypose({"pack", "-C", (root_ / "hero").string(), "-o", zip});
  EXPECT_EQ(packed.code, 0) << packed.text;
  EXPECT_THAT(packed.text, HasSubstr("outside of the project: pipeline.yaml:2: ../elsewhere"));
  EXPECT_EQ(Keypose({"pack", "-C", (root_ / "hero").string(), "-o", "/no/such/folder/a.zip"}).code,
            4);
}

TEST_F(RunTest, ExplainAndStatusSayWhatChanged) {
  EXPECT_THAT(Keypose({"status", "-C", (root_ / "hero").string()}).text, HasSubstr("never ran"));
  ASSERT_EQ(Run().code, 0);
  WriteFile(root_ / "hero/photos/bent/IMG_3.jpg", "retake\n");
  EXPECT_THAT(Keypose({"explain", "join/bent", "-C", (root_ / "hero").string()}).text,
              HasSubstr("photos/bent/IMG_3.jpg changed"));
  EXPECT_THAT(Keypose({"status", "-C", (root_ / "hero").string()}).text,
              HasSubstr("gather/bent  would run    photos/bent/IMG_3.jpg changed"));
  const Ended run = Run();
  EXPECT_THAT(run.text, HasSubstr("gather/bent starts"));
  EXPECT_THAT(run.text, Not(HasSubstr("gather/rest")));
  const std::string after =
      Keypose({"explain", "gather/bent", "-C", (root_ / "hero").string()}).text;
  EXPECT_THAT(after, HasSubstr("gather/bent is up to date\nit last ran at 20"));
  EXPECT_THAT(after, HasSubstr("because\n  - photos/bent/IMG_3.jpg changed\n"));
}

TEST_F(RunTest, FailureExitsWithTheStagesCodeAndKeepsItsLog) {
  const Ended ended = Run({"--set", "join.exit_code=6"});
  EXPECT_EQ(ended.code, 6);
  EXPECT_THAT(ended.text, HasSubstr("failed: its result is not good enough"));
  EXPECT_THAT(ended.text, HasSubstr("told to fail"));
  EXPECT_THAT(Keypose({"log", "join", "-C", (root_ / "hero").string()}).text,
              HasSubstr("join at work"));
  EXPECT_EQ(Run({"--set", "join.exit_code=139"}).code, 1) << "a crash is a bug";
}

TEST_F(RunTest, OwnExecutableJoinsByNameInTheFile) {
  fs::create_directories(root_ / "hero/tools");
  WriteFile(
      root_ / "hero/tools/count",
      "#!/bin/sh\n"
      "if [ \"$1\" = --describe ]; then\n"
      "  echo "
      "'{\"schema\":1,\"stage\":\"count\",\"version\":\"1\",\"inputs\":[{\"name\":\"text\","
      "\"kind\":\"file\"}],'\n"
      "  echo '\"outputs\":[{\"name\":\"lines\",\"kind\":\"file\",\"file\":\"lines.txt\"}]}'\n"
      "  exit\n"
      "fi\n"
      "wc -l < \"$2\" > \"$4\"\n");
  chmod((root_ / "hero/tools/count").c_str(), 0755);
  WriteFile(root_ / "hero/pipeline.yaml",
            "poses: {rest: photos/rest}\nsteps:\n  count: {program: tools/count, for: pose, "
            "inputs: {text: join.text}, out: {lines: "
            "'{pose}/lines.txt'}}\n");
  const Ended ended = Run();
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_EQ(ReadFile(root_ / "hero/out/rest/lines.txt"), "4\n");
}

TEST_F(RunTest, JsonLinesParse) {
  const Ended ended = Run({"--progress", "jsonl"});
  ASSERT_EQ(ended.code, 0);
  std::istringstream lines(ended.text);
  std::map<std::string, int> events;
  for (std::string line; std::getline(lines, line);)
    ++events[nlohmann::json::parse(line).at("event").get<std::string>()];
  EXPECT_EQ(events["begin"], 1);
  EXPECT_EQ(events["start"], 5);
  EXPECT_EQ(events["finish"], 5);
  EXPECT_GT(events["progress"], 0);
  EXPECT_EQ(events["end"], 1);
}

TEST_F(RunTest, EndRepeatsWarningsVerdictsAndResultsAlsoFromTheCache) {
  const Ended first =
      Run({}, {{"TEXT_STAGE_WARNING", "two landmarks look swapped"}, {"TEXT_STAGE_GRADE", "look"}});
  ASSERT_EQ(first.code, 0) << first.text;
  const std::string end =
      "\n1 warning\n  rest, bent\n    gather: two landmarks look swapped\n\nverdicts\n  rest  look "
      " it was told so\n\nresults\n"
      "  all texts  " +
      (root_ / "hero/out/all").string() + "\n";
  EXPECT_THAT(first.text, ::testing::EndsWith("5 made, 0 steps up to date\n" + end));
  EXPECT_EQ(Run().text, "5 steps up to date\n" + end);
  const std::string status = Keypose({"status", "-C", (root_ / "hero").string()}).text;
  EXPECT_THAT(status, HasSubstr("verdicts\n  rest  look  it was told so\n"));
  EXPECT_THAT(status, HasSubstr("1 warning of the steps that are up to date"));
}

TEST_F(RunTest, EndIsInJsonLinesAndInTheRunRecord) {
  const Ended ended =
      Run({"--progress", "jsonl"}, {{"TEXT_STAGE_WARNING", "dark"}, {"TEXT_STAGE_GRADE", "good"}});
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
  const Ended log = shell("bash -o pipefail -c '" + keypose + " log gather/rest -C " + hero +
                          " | head -n 1 > /dev/null'");
  EXPECT_EQ(log.text, "");
  EXPECT_EQ(log.code, 0);
  WriteFile(root_ / "hero/photos/rest/IMG_2.jpg", "retake\n");
  const Ended run = shell("bash -o pipefail -c 'TEXT_STAGE_DELAY_MS=50 " + keypose + " run -C " +
                          hero + " | head -n 1 > /dev/null'");
  EXPECT_EQ(run.text, "");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(ReadFile(root_ / "hero/out/rest/text.txt"), HasSubstr("RETAKE"))
      << "a run goes on though nobody listens";
}

TEST_F(RunTest, PosesAreNamedInAnyLanguageAndSpelling) {
  // "mähen", with its umlaut as one letter and as in macOS file names: an a and a combining
  // diaeresis.
  const std::string composed = "m\u00e4hen", apart = "ma\u0308hen";
  MakePhotographs(root_ / "hero");
  fs::rename(root_ / "hero/photos/bent", root_ / "hero/photos" / apart);
  const Ended init =
      Keypose({"init", (root_ / "new").string(), "--pose",
               "rest=" + (root_ / "hero/photos/rest").string(), "--pose",
               composed + "=" + (root_ / "hero/photos" / composed).string(), "--template", apart});
  ASSERT_EQ(init.code, 0) << init.text;
  const std::string project = (root_ / "new").string();
  fs::rename(root_ / "new/photos" / composed,
             root_ / "new/photos" / apart);  // as unpacked from a Mac's archive
  const Ended run = Keypose({"run", "-C", project, "--set", "join/" + apart + ".exit_code=0"});
  ASSERT_EQ(run.code, 0) << run.text;
  EXPECT_THAT(ReadFile(root_ / "new/out" / composed / "text.txt"), HasSubstr("BENT PICTURE"));
  EXPECT_EQ(ReadFile(root_ / "new/out/all/0.txt").substr(4, 4), "BENT")
      << "the template, named in the other spelling, comes first";
  for (const std::string& name : {composed, apart}) {
    EXPECT_THAT(Keypose({"log", "join/" + name, "-C", project}).text, HasSubstr("join at work"));
    EXPECT_THAT(Keypose({"explain", "join/" + name, "-C", project}).text,
                HasSubstr("join/" + composed + " is up to date"));
  }
  EXPECT_THAT(Keypose({"status", "-C", project}).text,
              HasSubstr("gather/" + composed + "  up to date"));
  EXPECT_THAT(Keypose({"graph", "--dot", "-C", project}).text,
              HasSubstr("\"gather/" + composed + "\" -> \"join/" + composed + "\""));
  const Ended twice = Keypose({"init", (root_ / "other").string(), "--pose",
                               composed + "=" + project, "--pose", apart + "=" + project});
  EXPECT_EQ(twice.code, 2) << "one name in two spellings is one name";
  EXPECT_EQ(Keypose({"init", (root_ / "other").string(), "--pose", "m\xe4hen=" + project}).code, 2)
      << "Latin-1 is no UTF-8";
}

TEST_F(RunTest, HomeIsWrittenAsATilde) {
  MakePhotographs(root_ / "hero");
  fs::rename(root_ / "hero/photos/bent", root_ / "elsewhere");
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: ~/elsewhere}\n");
  const std::map<std::string, std::string> home = {{"HOME", root_.string()}};
  const Ended ended = Run({}, home);
  ASSERT_EQ(ended.code, 0) << ended.text;
  EXPECT_THAT(ReadFile(root_ / "hero/out/bent/text.txt"), HasSubstr("BENT PICTURE"));
  EXPECT_EQ(Keypose({"init", (root_ / "new").string(), "--pose", "bent=~/elsewhere"}, home).code,
            0);
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest, bent: ~ann/elsewhere}\n");
  EXPECT_THAT(Run({}, home).text, HasSubstr("only your own home folder can be written as ~"));
}

TEST_F(RunTest, GcRemovesWhatNothingRefersTo) {
  ASSERT_EQ(Run().code, 0);
  ASSERT_EQ(Run({"--set", "gather.exit_code=0"}).code, 0);
  WriteFile(root_ / "hero/photos/rest/IMG_0.jpg", "other\n");
  ASSERT_EQ(Run().code, 0);
  EXPECT_THAT(
      Keypose({"gc", "-C", (root_ / "hero").string(), "--keep-runs", "1", "--dry-run"}).text,
      HasSubstr("would remove 3 artifacts"));
  EXPECT_THAT(Keypose({"gc", "-C", (root_ / "hero").string(), "--keep-runs", "1"}).text,
              HasSubstr("removed 3 artifacts"));
  EXPECT_EQ(Run().text, AllUpToDate(root_ / "hero"));
}

TEST_F(RunTest, GcRemovesWhatWasMadeOfARemovedPoseOnceTheLastRunsDoNotNameIt) {
  ASSERT_EQ(Run().code, 0);
  WriteFile(root_ / "hero/pipeline.yaml", "poses: {rest: photos/rest}\n");
  ASSERT_EQ(Run().code, 0);
  const std::vector<std::string> gc = {"gc", "-C", (root_ / "hero").string()};
  EXPECT_THAT(Keypose(gc).text, HasSubstr("removed 0 artifacts")) << "the last 10 runs name it";
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/steps/gather/bent.json"));
  const Ended one = Keypose({"gc", "-C", (root_ / "hero").string(), "--keep-runs", "1"});
  EXPECT_THAT(one.text, Not(HasSubstr("removed 0 artifacts"))) << one.text;
  EXPECT_THAT(Run().text, ::testing::StartsWith("3 steps up to date"));
}

TEST_F(RunTest, ReportSaysWhenItIsOfAnEarlierState) {
  const fs::path hero = root_ / "hero";
  WriteFile(hero / "pipeline.yaml",
            ReadFile(hero / "pipeline.yaml") +
                "steps: {page: {stage: merge, for: project, inputs: {texts: "
                "join.text@all}, out: {all/0.txt: report/index.html}}}\n");
  ASSERT_EQ(Run().code, 0);
  const std::vector<std::string> report = {"report", "-C", hero.string()};
  const std::string path = (hero / "out/report/index.html").string() + "\n";
  EXPECT_EQ(Keypose(report).text, path);
  WriteFile(hero / "photos/rest/IMG_0.jpg", "another\n");
  EXPECT_EQ(Run({"--set", "merge.exit_code=3", "--set", "page.exit_code=3"}).code, 3);
  const Ended older = Keypose(report);
  EXPECT_EQ(older.code, 0);
  EXPECT_EQ(older.text, path +
                            "keypose: this report is not of the present project: page would run "
                            "again; `keypose run` brings it up to date\n");
}

TEST_F(RunTest, WordsOfTheCommandLineAreChecked) {
  EXPECT_EQ(Keypose({"rnu"}).code, 2);
  EXPECT_THAT(Keypose({"rnu"}).text, HasSubstr("did you mean 'run'?"));
  EXPECT_EQ(Keypose({"studio"}).code, 5) << "a command, whose program this house does not have";
  EXPECT_EQ(Run({"--executor", "slurm"}).code, 2);
  EXPECT_EQ(Run({"-j", "0"}).code, 2);
  EXPECT_EQ(Keypose({"run", "-C", root_.string()}).code, 2) << "not a project";
  EXPECT_THAT(Keypose({"run", (root_ / "hero").string()}).text,
              HasSubstr("named with -C, as in -C " + (root_ / "hero").string()));
  EXPECT_EQ(Keypose({"gather", "--describe"}).code, 0) << "`keypose STAGE` becomes the stage";
}

TEST_F(RunTest, HelpOfACommandIsOfTheCommandThoughAStageHasItsName) {
  EXPECT_THAT(Keypose({"report", "--help"}).text, HasSubstr("show where the project's report is"));
  const fs::path stage = root_ / "bin/keypose-report";
  WriteFile(stage, "#!/bin/sh\necho \"the stage with $*\"\n");
  fs::permissions(stage, fs::perms::owner_all);
  for (const char* help : {"--help", "-h"}) {
    const Ended both = Keypose({"report", help});
    EXPECT_EQ(both.code, 0);
    EXPECT_THAT(both.text, ::testing::StartsWith("show where the project's report is"));
    EXPECT_THAT(both.text, HasSubstr("Usage: keypose report [OPTIONS]"));
    EXPECT_THAT(both.text, HasSubstr("-C,--folder"));
    EXPECT_THAT(both.text, ::testing::EndsWith("\nthe stage with --help\n"));
  }
  const std::string folder = "--folder=" + (root_ / "hero").string();
  EXPECT_THAT(Keypose({"report", folder}).text, HasSubstr("there is no report yet"));
  EXPECT_EQ(Keypose({"report", "--run", "x"}).text, "the stage with --run x\n");
}

TEST_F(RunTest, DryRunChangesNothing) {
  const Ended ended = Run({"--dry-run"});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.text, HasSubstr("would run gather/rest: it has never run"));
  EXPECT_FALSE(fs::exists(root_ / "hero/out"));
  EXPECT_FALSE(fs::exists(root_ / "hero/.keypose/cache"));
}

}  // namespace keypose::pipeline::run_test
