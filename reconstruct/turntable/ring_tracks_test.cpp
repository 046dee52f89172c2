#include "reconstruct/turntable/ring_tracks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::reconstruct::ring_tracks_test {

TEST(BuildTracks, JoinsThroughImagesAndDropsWhatDisagrees) {
  std::vector<Features> features(3);
  for (Features& f : features) f.scales.resize(5), f.positions.resize(5, 2);
  const auto tracks =
      BuildTracks({{0, 1, {{0, 1}, {2, 2}}}, {1, 2, {{1, 3}}}, {0, 2, {{2, 4}, {3, 4}}}}, features);
  ASSERT_EQ(tracks.size(), 2U);
  EXPECT_EQ(tracks[0].elements.size(), 3U);  // 0:0 - 1:1 - 2:3
  EXPECT_EQ(tracks[1].elements.size(),
            2U);  // features 2 and 3 of image 0 both match 2:4, so only 1:2 and 2:4 remain
}

}  // namespace keypose::reconstruct::ring_tracks_test
