#include "core/io/project/regions_io.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::regions_io_test {

class RegionsIo : public ::testing::Test, public TestingFolder {
 protected:
  RegionsIo() : ball_(MakeIcosphere(3)) {
    cap_.name = "cap";
    for (int v = 0; v < ball_.vertex_count(); ++v)
      if (ball_.points(v, 2) > 0.8) cap_.vertices.push_back(v);
    middle_.name = "middle";
    middle_.center = {0.1, 0, 0};
    middle_.radius = 0.25;
  }
  Mesh ball_;
  TimelineRegion cap_, middle_;
};

TEST_F(RegionsIo, ComeBackAsTheyWereWritten) {
  WriteRegions(folder_ / "r.json", ball_, {cap_, middle_});
  const auto read = RegionsOn(folder_ / "r.json", nullptr);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0].name, "cap");
  EXPECT_EQ(read[0].vertices, cap_.vertices);
  EXPECT_EQ(read[1].name, "middle");
  EXPECT_NEAR(read[1].radius, 0.25, 1e-12);
  EXPECT_LT((read[1].center - middle_.center).norm(), 1e-12);
}

TEST_F(RegionsIo, OnAnotherPoseOfTheSameFacesAListStays) {
  WriteRegions(folder_ / "r.json", ball_, {cap_});
  Mesh posed = ball_;
  posed.points.col(0) *= 3;
  Timeline timeline;
  timeline.regions = {cap_};
  CarryLog log;
  FollowRegions(folder_ / "r.json", posed, timeline, &log);
  EXPECT_EQ(timeline.regions[0].vertices, cap_.vertices);
  EXPECT_TRUE(log.warnings.empty());
}

TEST_F(RegionsIo, WithoutAFileListsAreTakenWithAWarning) {
  Timeline timeline;
  timeline.regions = {cap_};
  CarryLog log;
  FollowRegions({}, ball_, timeline, &log);
  EXPECT_EQ(timeline.regions[0].vertices, cap_.vertices);
  EXPECT_FALSE(log.warnings.empty());
}

TEST_F(RegionsIo, VerticesThatTheMeshLacksAndDamagedFilesAreRefused) {
  TimelineRegion beyond = cap_;
  beyond.vertices.push_back(ball_.vertex_count());
  EXPECT_THROW(WriteRegions(folder_ / "r.json", ball_, {beyond}), InputError);
  EXPECT_THROW(RegionsOn(Put("bad.json", "{\"regions\": 3}"), nullptr), InputError);
}

}  // namespace keypose::regions_io_test
