#include "pipeline/cache/records.h"

#include <gtest/gtest.h>

#include "pipeline/testing/memory_disk.h"

namespace keypose::pipeline::records_test {

RunRecord RunOf(const std::string& name, const std::string& fingerprint) {
  RunRecord run;
  run.name = name;
  run.steps.resize(1);
  run.steps[0].id = "mesh.bent";
  run.steps[0].status = "made";
  run.steps[0].fingerprint = fingerprint;
  return run;
}

TEST(Records, TheLastRecordOfAStepComesBack) {
  MemoryDisk disk;
  StepRecord record;
  record.fingerprint = std::string(64, 'a');
  record.seconds = 2.5;
  record.reasons = {"option depth: 9 -> 10"};
  record.failed = true;
  record.exit_code = 3;
  record.error = "the disk is full";
  Records(disk, "/p/.keypose").SetLast("mesh.bent", record);
  const auto last = Records(disk, "/p/.keypose").Last("mesh.bent");
  ASSERT_TRUE(last.has_value());
  EXPECT_EQ(last->fingerprint, record.fingerprint);
  EXPECT_EQ(last->seconds, 2.5);
  EXPECT_EQ(last->reasons, record.reasons);
  EXPECT_TRUE(last->failed);
  EXPECT_EQ(last->exit_code, 3);
  EXPECT_EQ(last->error, record.error);
  EXPECT_FALSE(Records(disk, "/p/.keypose").Last("mesh.straight").has_value());
}

TEST(Records, OnlyTheNewestRunsAreKeptAndTheirArtifactsMentioned) {
  MemoryDisk disk;
  Records records(disk, "/p/.keypose");
  records.Save(RunOf("20260101T000000-1", "aa"));
  records.Save(RunOf("20260102T000000-1", "bb"));
  records.Save(RunOf("20260103T000000-1", "cc"));
  EXPECT_EQ(records.Mentioned(2, {}), (std::set<std::string>{"bb", "cc"}));
  EXPECT_EQ(records.DropOldRuns(1), 2);
  EXPECT_EQ(records.Mentioned(9, {}), (std::set<std::string>{"cc"}));
}

TEST(Records, StepsThatAreGoneAreForgotten) {
  MemoryDisk disk;
  Records records(disk, "/p/.keypose");
  records.SetLast("mesh.bent", {});
  records.SetLast("mesh.straight", {});
  records.ForgetStepsOutside({"mesh.bent"});
  EXPECT_TRUE(records.Last("mesh.bent").has_value());
  EXPECT_FALSE(records.Last("mesh.straight").has_value());
}

TEST(TimeText, IsInUtc) {
  EXPECT_EQ(TimeText(0), "1970-01-01 00:00:00 UTC");
  EXPECT_EQ(TimeText(951782400), "2000-02-29 00:00:00 UTC");
}

}  // namespace keypose::pipeline::records_test
