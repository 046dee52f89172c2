#include "reconstruct/matching/colmap_database.h"

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <string>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::reconstruct::colmap_database_test {

namespace fs = std::filesystem;

class DatabaseTest : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    camera.width = 640;
    camera.height = 480;
    camera.fx = camera.fy = 800;
    camera.cx = 320;
    camera.cy = 240;
  }
  const fs::path folder = path();
  Camera camera;
};

TEST_F(DatabaseTest, VerifiedMatchesAreReadInPairOrderAsTheyWerePut) {
  ColmapDatabase database = ColmapDatabase::Create(folder / "d.db", {camera}, true,
                                                   {"a.jpg", "b.jpg", "c.jpg"}, {0, 0, 0});
  database.PutInliers({{1, 2, {{0, 3}, {4, 5}}}, {0, 1, {{7, 8}}}, {0, 2, {}}});
  database.PutInliers({{1, 2, {{6, 9}}}});  // replaces the previous matches
  const std::vector<PairMatches> pairs = database.VerifiedMatches();
  using Matches = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(pairs[0].first, 0);
  EXPECT_EQ(pairs[0].second, 1);
  EXPECT_EQ(pairs[0].features, (Matches{{7, 8}}));
  EXPECT_EQ(pairs[1].first, 1);
  EXPECT_EQ(pairs[1].second, 2);
  EXPECT_EQ(pairs[1].features, (Matches{{6, 9}}));
}

TEST_F(DatabaseTest, ImagesWithoutFeaturesReadAsEmpty) {
  EXPECT_EQ(ColmapDatabase::Create(folder / "d.db", {camera}, true, {"a.jpg"}, {0})
                .ReadFeatures(0)
                .count(),
            0);
}

TEST_F(DatabaseTest, MissingFileThrowsDiskError) {
  EXPECT_THROW(ColmapDatabase(folder / "none.db"), DiskError);
}

}  // namespace keypose::reconstruct::colmap_database_test
