// Failures, damage and changes during a run, with disk, clock and processes in memory.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"
#include "pipeline/cache/artifact_store.h"
#include "pipeline/testing/fake_house.h"
#include "pipeline/testing/message_of.h"

namespace keypose::pipeline::rules_faults_test {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

TEST(Rules, FailedStepKeepsItsLogStopsWhatDependsAndGoesOnAfterRepair) {
  FakeHouse house;
  auto& shape = house.processes.stages["/bin/keypose-shape"].run;
  const auto good = shape;
  shape = [](const FakeCall& call, MemoryDisk& d) {
    d.Write(call.log, "looking\nkeypose shape: error: vertex 7 is not a number\n");
    d.Write(call.Flag("mesh"), "half");
    return 3;
  };
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kInput);
  EXPECT_THAT(outcome.result.message,
              HasSubstr("shape/rest failed: what it was given cannot be used\n"));
  EXPECT_THAT(outcome.result.message, Not(HasSubstr("error: ")));
  EXPECT_THAT(outcome.result.message, HasSubstr("vertex 7 is not a number"));
  EXPECT_THAT(outcome.result.message, HasSubstr(".keypose/failed/shape.rest/log.txt"));
  EXPECT_THAT(house.disk.Read(house.project / ".keypose/failed/shape.rest/log.txt"),
              HasSubstr("vertex 7"));
  EXPECT_FALSE(house.disk.Stat(house.project / "out/rest/mesh.txt"));
  EXPECT_THAT(house.Look().Reasons("shape/rest"), HasSubstr("its last try failed"));

  shape = good;
  const auto second = house.Run();
  EXPECT_EQ(second.result.code, ExitCode::kOk);
  EXPECT_EQ(second.ran, (Names{"blend", "match/bent", "shape/bent", "shape/rest", "tell"}));
  EXPECT_FALSE(house.disk.Stat(house.project / ".keypose/failed/shape.rest"));
}

TEST(Rules, PictureOfAFailureIsKeptAndItsPlaceIsCorrected) {
  FakeHouse house;
  auto& shape = house.processes.stages["/bin/keypose-shape"].run;
  const auto good = shape;
  shape = [](const FakeCall& call, MemoryDisk& d) {
    const std::string picture = call.Flag("mesh") + ".failed.jpg";
    d.Write(picture, "a picture");
    d.Write(call.Flag("mesh") + ".half.jpg", "another");
    d.Write(call.log, "keypose shape: error: unclear; look at " + picture + "\n");
    return 3;
  };
  const auto outcome = house.Run();
  const auto failed = house.project / ".keypose/failed/shape.rest";
  const auto files = house.disk.FilesBelow(failed);
  ASSERT_EQ(files.size(), 2U);
  EXPECT_THAT(files[1], ::testing::EndsWith(".failed.jpg"));
  EXPECT_THAT(outcome.result.message, HasSubstr("look at " + (failed / files[1]).string()));
  EXPECT_THAT(house.disk.Read(failed / "log.txt"), HasSubstr((failed / files[1]).string()));
  shape = good;
  EXPECT_EQ(house.Run().result.code, ExitCode::kOk);
  EXPECT_FALSE(house.disk.Stat(failed));
}

TEST(Rules, FailureLeavesNoTemporaryFolder) {
  FakeHouse house;
  house.processes.stages["/bin/keypose-solve"].run = [](const FakeCall&, MemoryDisk&) { return 5; };
  EXPECT_EQ(house.Run().result.code, ExitCode::kTool);
  EXPECT_THAT(house.disk.FilesBelow(house.project / ".keypose/tmp"), IsEmpty());
}

TEST(Rules, SignalledStageIsReportedAsABugWithTheSignal) {
  FakeHouse house;
  house.processes.stages["/bin/keypose-solve"].run = [](const FakeCall&, MemoryDisk&) {
    return 139;
  };
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kBug);
  EXPECT_THAT(outcome.result.message, HasSubstr("signal 11"));
}

TEST(Rules, StageThatWritesNothingFails) {
  FakeHouse house;
  house.processes.stages["/bin/keypose-solve"].run = [](const FakeCall&, MemoryDisk&) { return 0; };
  const auto outcome = house.Run();
  EXPECT_EQ(outcome.result.code, ExitCode::kTool);
  EXPECT_THAT(outcome.result.message, HasSubstr("did not write its output 'model'"));
}

TEST(Rules, FullDiskIsExitCode4AndKeepsWhatWasMade) {
  FakeHouse house;
  auto& shape = house.processes.stages["/bin/keypose-shape"].run;
  const auto good = shape;
  shape = [&](const FakeCall& call, MemoryDisk& d) {
    const int code = good(call, d);
    d.SetFull(true);
    return code;
  };
  EXPECT_EQ(house.Run({}, {}, 1).result.code, ExitCode::kDisk);
  house.disk.SetFull(false);
  shape = good;
  const auto second = house.Run();
  EXPECT_EQ(second.result.code, ExitCode::kOk);
  EXPECT_EQ(std::count(second.ran.begin(), second.ran.end(), "shoot/rest"), 0)
      << "finished work was lost";
}

TEST(Rules, InterruptKeepsWhatWasMadeAndExitsWith130) {
  FakeHouse house;
  house.processes.interrupt_after = 3;
  const auto outcome = house.Run({}, {}, 1);
  EXPECT_EQ(outcome.result.code, ExitCode::kInterrupted);
  EXPECT_EQ(house.disk.FilesBelow(house.project / ".keypose/tmp"), Names());
  FakeProcesses fresh(house.disk, house.clock);
  EXPECT_EQ(house.Look().Step("shoot/rest").state, StepPlan::State::kDone);
}

TEST(Rules, DamagedArtifactIsMadeAgain) {
  FakeHouse house;
  house.Run();
  const auto view = house.Look();
  house.disk.Write(view.Step("solve/rest").artifact->Path("model"), "cut");
  EXPECT_EQ(house.Run().ran, (Names{"solve/rest"}));
}

TEST(Rules, FlippedBitIsNoticedSaidAndMendedBeforeItReachesResults) {
  FakeHouse house;
  house.Run();
  const std::string good = house.Out("rest/mesh.txt");
  const std::filesystem::path mesh = house.Look().Step("shape/rest").artifact->Path("mesh");
  std::string flipped = house.disk.Read(mesh);
  flipped[0] ^= 1;  // of the same size, as bit rot is
  house.disk.Write(mesh, flipped);
  house.disk.Remove(house.project / "out");
  EXPECT_EQ(
      house.Look().Reasons("shape/rest"),
      "its artifact in the cache was damaged from outside (mesh.txt is not as it was made)\n");
  EXPECT_EQ(house.Run().ran, (Names{"shape/rest"}));
  EXPECT_EQ(house.Out("rest/mesh.txt"), good);
}

TEST(Rules, ACopiedCacheIsReadOnceAndBelievedFromThenOn) {
  FakeHouse house;
  house.Run();
  house.MoveProject("/srv/hero");
  EXPECT_TRUE(house.Run().ran.empty());
  const int hashed = house.disk.hashed();
  EXPECT_TRUE(house.Run().ran.empty());
  EXPECT_EQ(house.disk.hashed(), hashed);
}

TEST(Rules, ArtifactsWithoutTheirReportOrInEachOthersFolderAreMadeAgain) {
  FakeHouse house;
  house.Run();
  const auto folder = [&](const std::string& step) {
    return house.Look().Step(step).artifact->folder;
  };
  house.disk.Remove(folder("match/bent") / "report.json");
  EXPECT_EQ(house.Run().ran, (Names{"match/bent"}));
  const std::filesystem::path rest = folder("shape/rest"), bent = folder("shape/bent");
  house.disk.Move(rest, "/tmp/aside");
  house.disk.Move(bent, rest);
  house.disk.Move("/tmp/aside", bent);
  EXPECT_EQ(house.Look().Reasons("shape/rest"),
            "its artifact in the cache was damaged from outside (manifest.json belongs to another "
            "artifact)\n");
  EXPECT_EQ(house.Run().ran, (Names{"shape/bent", "shape/rest"}));
}

TEST(Rules, AFlippedBitOfAManifestIsNotBelieved) {
  FakeHouse house;
  house.Run();
  const ArtifactStore store(house.disk, house.project / ".keypose");
  const std::string mesh = house.Out("rest/mesh.txt");
  const std::size_t kept = store.All().size();
  const std::filesystem::path file =
      house.Look().Step("shape/rest").artifact->folder / "manifest.json";
  for (std::size_t i = 0; i < house.disk.Read(file).size(); ++i) {
    std::string text = house.disk.Read(file);
    text[i] ^= static_cast<char>(1 << i % 8);
    house.disk.Write(file, text);
    ASSERT_EQ(house.Run().result.code, ExitCode::kOk) << "byte " << i;
    ASSERT_EQ(house.Out("rest/mesh.txt"), mesh) << "byte " << i;
    ASSERT_EQ(store.All().size(), kept) << "byte " << i << ": another step saw another input";
    for (const std::string& fingerprint : store.All())
      ASSERT_EQ(store.Verify(fingerprint), "") << "byte " << i << ": " << text;
  }
}

TEST(Rules, AResultDamagedWhileItIsCopiedIsMadeAgain) {
  FakeHouse house;
  house.Run();
  const std::string mesh = house.Out("rest/mesh.txt");
  house.disk.Remove(house.project / "out");
  bool done = false;
  house.disk.before_copy = [&](const std::filesystem::path& from) {
    if (done || from.filename() != "mesh.txt") return;
    done = true;
    house.disk.Write(from, "damaged");
  };
  const auto outcome = house.Run();
  ASSERT_TRUE(done);
  EXPECT_EQ(outcome.result.code, ExitCode::kOk);
  house.Run();
  EXPECT_EQ(house.Out("rest/mesh.txt"), mesh);
  EXPECT_THAT(house.disk.FilesBelow(house.project / "out"),
              Not(::testing::Contains(HasSubstr(".mine"))));
}

TEST(Rules, NamesThatLeadOutOfTheProjectAreNotFollowed) {
  FakeHouse house;
  house.Run();
  house.disk.Write("/home/ann/taxes.txt", "of 2025");
  // The stored list of results of a project from elsewhere.
  auto memory = nlohmann::json::parse(house.disk.Read(house.project / ".keypose/out.json"));
  memory["../../taxes.txt"] = memory["rest/mesh.txt"];
  memory["../../taxes.txt"]["step"] = "gone/rest";
  memory["odd"] = {{"step", 7}};
  house.disk.Write(house.project / ".keypose/out.json", memory.dump());
  EXPECT_TRUE(house.Run().ran.empty());
  EXPECT_EQ(house.disk.Read("/home/ann/taxes.txt"), "of 2025");
  // A manifest whose output lies elsewhere.
  const std::filesystem::path file =
      house.Look().Step("shape/rest").artifact->folder / "manifest.json";
  auto manifest = nlohmann::json::parse(house.disk.Read(file));
  manifest["outputs"]["mesh"]["file"] = "../../../../../taxes.txt";
  manifest.erase("checksum");  // as earlier versions wrote it
  house.disk.Write(file, manifest.dump());
  EXPECT_EQ(house.Run().ran, (Names{"shape/rest"}));
  EXPECT_EQ(house.Out("rest/mesh.txt").find("2025"), std::string::npos);
}

TEST(Rules, PhotographChangedAndPutBackWhileItsStepRunsSpoilsIt) {
  FakeHouse house;
  const auto photo = house.project / "photos/rest/IMG_1.jpg";
  const std::string text = house.disk.Read(photo);
  const auto shoot = house.processes.stages.at("/bin/keypose-shoot").run;
  int calls = 0;
  house.processes.stages.at("/bin/keypose-shoot").run = [&](const FakeCall& call,
                                                            MemoryDisk& disk) {
    const bool first = call.Flag("photos").ends_with("rest") && calls++ == 0;
    if (first) disk.Write(photo, "r another");
    const int code = shoot(call, disk);
    if (first) disk.Write(photo, text);
    return code;
  };
  const auto outcome = house.Run();
  EXPECT_TRUE(outcome.result.again);
  EXPECT_EQ(outcome.result.code, ExitCode::kOk);
  EXPECT_THAT(outcome.notes, ::testing::Contains(::testing::HasSubstr("while shoot/rest ran, ")));
  EXPECT_FALSE(house.Run().result.again);
  FakeHouse undisturbed;
  undisturbed.Run();
  EXPECT_EQ(house.Out("rest/mesh.txt"), undisturbed.Out("rest/mesh.txt"));
  EXPECT_EQ(house.Look().Step("shoot/rest").artifact->outputs.at("images").content.hash,
            undisturbed.Look().Step("shoot/rest").artifact->outputs.at("images").content.hash);
}

TEST(Rules, ProgramReplacedWhileItRunsSpoilsItsStep) {
  FakeHouse house;
  const auto shape = house.processes.stages.at("/bin/keypose-shape").run;
  bool replaced = false;
  house.processes.stages.at("/bin/keypose-shape").run = [&](const FakeCall& call,
                                                            MemoryDisk& disk) {
    if (!replaced) {
      replaced = true;
      disk.Write("/bin/keypose-shape", "a new version");
      house.processes.stages.at("/bin/keypose-shape").describe["version"] = "2";
    }
    return shape(call, disk);
  };
  EXPECT_TRUE(house.Run().result.again);
  EXPECT_FALSE(house.Run().result.again);
  EXPECT_EQ(house.Look().Step("shape/rest").artifact->recipe.version, "2");
}

TEST(Rules, LostCacheExplainsItself) {
  FakeHouse house;
  house.Run();
  house.disk.Remove(house.project / ".keypose/cache");
  EXPECT_EQ(house.Look().Reasons("shoot/rest"), "its artifact is no longer in the cache\n");
  EXPECT_EQ(house.Run().ran, kAllSteps);
}

TEST(Rules, LandmarksThatARenamedPoseLeftAreTold) {
  FakeHouse house;
  house.disk.Write(house.project / "landmarks/rest.json", "rest picks");
  house.disk.Write(house.project / "landmarks/bowed.json", "picks of bent, when it was called so");
  EXPECT_THAT(house.Run().notes,
              ElementsAre(AllOf(HasSubstr("pose 'bent' has no landmarks"),
                                HasSubstr("landmarks/bowed.json bears the name of no pose"))));
  house.disk.Remove(house.project / "landmarks/bowed.json");
  EXPECT_THAT(house.Run().notes, ElementsAre(Not(HasSubstr("of no pose"))));
}

}  // namespace keypose::pipeline::rules_faults_test
