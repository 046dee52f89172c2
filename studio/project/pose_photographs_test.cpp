#include "studio/project/pose_photographs.h"
#include "studio/project/originals.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/srgb.h"
#include "core/testing/dng.h"
#include "core/testing/folder.h"

namespace keypose::studio::photographs_test {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::UnorderedElementsAre;

class Photographs : public ::testing::Test, public TestingFolder {
 protected:
  Photographs() {
    fs::create_directories(photos());
    WriteFile(folder_ / "pipeline.yaml", "name: raw\nposes: {rest: photos/rest}\ntemplate: rest\n");
  }

  fs::path photos() const { return folder_ / "photos/rest"; }
  void Put(const std::string& name) const { WriteFile(photos() / name, name); }
  /// Grey of one linear value.
  void PutRaw(const std::string& name, float linear) const {
    WriteDng(photos() / name, ImageF(64, 48, 3, linear), {});
  }
};

TEST_F(Photographs, RawFilesCountWhereNoOtherPhotographHasTheirStem) {
  for (const char* name : {"a.CR2", "b.jpg", "b.CR2", "c.HEIC", "Thumbs.db", "shoot.json", "d.x3f"})
    Put(name);
  EXPECT_THAT(OriginalPhotographs(photos()), UnorderedElementsAre("a.CR2", "b.jpg", "c.HEIC"));
}

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

}  // namespace keypose::studio::photographs_test
