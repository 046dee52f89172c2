#include "reconstruct/sfm/colmap_release.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::reconstruct::colmap_release_test {

using ::testing::ElementsAre;

TEST(ColmapRelease, IsReadFromTheHelpsFirstLine) {
  EXPECT_EQ(ParseColmapRelease("COLMAP 3.8 -- Structure-from-Motion and Multi-View Stereo"),
            (ColmapRelease{3, 8}));
  EXPECT_EQ(ParseColmapRelease("COLMAP 4.1.0 (Commit 0000000 on 2026-06-25 without CUDA)"),
            (ColmapRelease{4, 1}));
  EXPECT_EQ(ParseColmapRelease("COLMAP 3.14.0.dev0 -- Structure-from-Motion"),
            (ColmapRelease{3, 14}));
  EXPECT_THROW(ParseColmapRelease("Usage: colmap [command]"), ToolError);
  EXPECT_THROW(ParseColmapRelease("COLMAP 3.5 -- Structure-from-Motion"), ToolError);
}

TEST(ColmapRelease, ReleasesAreOrderedByTheirNumbers) {
  EXPECT_LT((ColmapRelease{3, 9}), (ColmapRelease{3, 12}));
  EXPECT_LT((ColmapRelease{3, 14}), (ColmapRelease{4, 0}));
}

TEST(ColmapRelease, OptionsHaveTheNamesOfTheRelease) {
  const std::vector<std::string> words = {
      "mapper", "--SiftExtraction.use_gpu",        "0",   "--SiftExtraction.max_image_size",
      "900",    "--SiftExtraction.peak_threshold", "0.1", "--Mapper.fix_existing_images",
      "1",      "--Mapper.ba_global_images_ratio", "1.5"};
  EXPECT_EQ(ArgumentsFor({3, 8}, words), words);
  EXPECT_EQ(ArgumentsFor({3, 11}, words), words);
  EXPECT_THAT(
      ArgumentsFor({3, 12}, words),
      ElementsAre("mapper", "--SiftExtraction.use_gpu", "0", "--SiftExtraction.max_image_size",
                  "900", "--SiftExtraction.peak_threshold", "0.1", "--Mapper.fix_existing_frames",
                  "1", "--Mapper.ba_global_frames_ratio", "1.5"));
  EXPECT_THAT(
      ArgumentsFor({3, 13}, words),
      ElementsAre("mapper", "--FeatureExtraction.use_gpu", "0", "--SiftExtraction.max_image_size",
                  "900", "--SiftExtraction.peak_threshold", "0.1", "--Mapper.fix_existing_frames",
                  "1", "--Mapper.ba_global_frames_ratio", "1.5"));
  EXPECT_THAT(ArgumentsFor({4, 1}, words),
              ElementsAre("mapper", "--FeatureExtraction.use_gpu", "0",
                          "--FeatureExtraction.max_image_size", "900",
                          "--SiftExtraction.peak_threshold", "0.1", "--Mapper.fix_existing_frames",
                          "1", "--Mapper.ba_global_frames_ratio", "1.5"));
}

}  // namespace keypose::reconstruct::colmap_release_test
