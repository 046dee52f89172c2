#include "studio/project/pose_photographs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/pictures/srgb.h"
#include "core/testing/folder.h"
#include "studio/project/testing/photographs.h"

namespace keypose::studio::pose_photographs_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

TEST_F(Photographs, APoseOfRawFilesOnlyIsListed) {
  PutRaw("p1.dng", 0.2f);
  PutRaw("p2.DNG", 0.2f);
  Snapshot snapshot(folder_);
  std::vector<std::string> names;
  for (const auto& one : PhotographsJson(snapshot, "rest")) {
    names.push_back(one.at("name"));
    EXPECT_FALSE(one.at("captured"));
  }
  EXPECT_THAT(names, ElementsAre("p1.dng", "p2.DNG"));
}

TEST_F(Photographs, APictureOfARawFileShowsItsColours) {
  PutRaw("p1.dng", 0.2f);
  Snapshot snapshot(folder_);
  const fs::path source = PhotographSource(snapshot, "rest", "p1.dng");
  const Image8 small = ReadImage(PictureFile(folder_ / "kept", source, 32), 3);
  EXPECT_EQ(small.width, 32);
  EXPECT_EQ(small.height, 24);
  EXPECT_NEAR(small.at(16, 12)[1], 255 * SrgbFromLinear(0.2), 4);  // LibRaw's tables, and JPEG
  EXPECT_EQ(ReadImage(PictureFile(folder_ / "kept", source, 0), 3).width, 64);
}

TEST_F(Photographs, WhatIsNoPhotographIsNotFound) {
  Put("notes.txt");
  Put("e.x3f");
  Snapshot snapshot(folder_);
  for (const char* name : {"notes.txt", "e.x3f", "none.dng", "../../pipeline.yaml"})
    EXPECT_THROW(PhotographSource(snapshot, "rest", name), NotFound) << name;
}

}  // namespace keypose::studio::pose_photographs_test
