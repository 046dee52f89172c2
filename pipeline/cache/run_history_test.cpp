#include "pipeline/cache/run_history.h"

#include <gtest/gtest.h>

#include "pipeline/cache/records.h"
#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline::run_history_test {

const std::string kA(64, 'a'), kB(64, 'b');

RunRecord RunAt(const std::string& name, double begin, std::vector<RunStep> steps) {
  RunRecord run;
  run.name = name;
  run.begin = begin;
  run.steps = std::move(steps);
  return run;
}

TEST(PastRuns, ComeOldestFirstWithTheStepsThatEndedWell) {
  MemoryDisk disk;
  Records records(disk, "/p/.keypose");
  records.Save(RunAt("20260302", 86400, {{"mesh/bent", "cached", kB, 0, 0, {}}}));
  records.Save(RunAt("20260301", 0,
                     {{"mesh/bent", "made", kA, 2, 0, {}},
                      {"bake/bent", "failed", kB, 2, 0, {}},
                      {"masks/bent", "made", "../../etc", 2, 0, {}}}));
  disk.Write("/p/.keypose/runs/20260303.json", "{half");
  disk.Write("/p/.keypose/runs/notes.txt", "{}");
  const std::vector<PastRun> runs = PastRuns(disk, "/p/.keypose");
  ASSERT_EQ(runs.size(), 2u);
  EXPECT_EQ(runs[0].name, "20260301");
  EXPECT_EQ(runs[0].begin, "1970-01-01 00:00:00 UTC");
  ASSERT_EQ(runs[0].steps.size(), 1u) << "neither what failed nor what is no fingerprint";
  EXPECT_EQ(runs[0].steps[0].id, "mesh/bent");
  EXPECT_EQ(runs[0].steps[0].fingerprint, kA);
  EXPECT_EQ(runs[1].begin, "1970-01-02 00:00:00 UTC");
  EXPECT_EQ(runs[1].steps[0].fingerprint, kB);
}

TEST(PastRuns, ANewProjectHasNone) {
  const MemoryDisk disk;
  EXPECT_TRUE(PastRuns(disk, "/p/.keypose").empty());
}

}  // namespace keypose::pipeline::run_history_test
