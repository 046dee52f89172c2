#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/testing_dng.h"
#include "core/io/testing_folder.h"
#include "studio/server/routes.h"

namespace keypose::studio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class MaskRoutes : public testing::Test, public TestingFolder {
 protected:
  MaskRoutes() {
    fs::create_directories(folder_ / "photos/rest");
    WriteImage(folder_ / "photos/rest/a.png", Image8(60, 40, 3, 90));
    WriteFile(folder_ / "pipeline.yaml", "name: x\nposes: {rest: photos/rest}\ntemplate: rest\n");
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~MaskRoutes() override { routes_.reset(); }
  /// A mask of which so many rows are white.
  std::string Mask(int rows) const {
    Image8 mask(60, 40, 1);
    std::fill_n(mask.data.begin(), 60 * rows, 255);
    WriteImage(folder_ / "mask.png", mask);
    return ReadFile(folder_ / "mask.png");
  }
  Answer Put(int rows, std::map<std::string, std::string> query) {
    query.insert({{"pose", "rest"}, {"name", "a.png"}});
    return routes_->Handle({"PUT", "/api/mask", query, Mask(rows)});
  }
  /// Its white rows, and the tag under which a browser gets it.
  std::pair<int, std::string> Get() {
    const Answer answer =
        routes_->Handle({"GET", "/api/mask", {{"pose", "rest"}, {"name", "a.png"}}, ""});
    if (answer.status != 200) return {-1, ""};
    const Image8 mask = ReadImage(answer.file, 1);
    return {static_cast<int>(std::count(mask.data.begin(), mask.data.end(), 255) / 60),
            TagOf(answer.file)};
  }

  std::unique_ptr<Routes> routes_;
};

TEST_F(MaskRoutes, WhatWasChangedMeanwhileIsNotWrittenOver) {
  EXPECT_EQ(Get().first, -1) << "no mask yet";
  const Answer first = Put(10, {{"revision", ""}});
  ASSERT_EQ(first.status, 200) << first.bytes;
  const std::string revision = json::parse(first.bytes).at("revision");
  EXPECT_EQ(Get(), std::pair(10, revision));
  EXPECT_EQ(Put(11, {{"revision", ""}}).status, 409) << "another tab that found none";
  const Answer second = Put(12, {{"revision", revision}});
  ASSERT_EQ(second.status, 200) << second.bytes;
  EXPECT_EQ(Get(), std::pair(12, std::string(json::parse(second.bytes).at("revision"))));
  const Answer late = Put(13, {{"revision", revision}});
  EXPECT_EQ(late.status, 409);
  EXPECT_THAT(late.bytes, testing::HasSubstr("the mask of a.png was changed elsewhere"));
  EXPECT_EQ(Get().first, 12);
  EXPECT_EQ(Put(14, {}).status, 200) << "who names no revision writes as into a folder";
}

TEST_F(MaskRoutes, APhotographThatCaptureDevelopsMayHaveOne) {
  WriteDng(folder_ / "photos/rest/p1.dng", ImageF(60, 40, 3, 0.2f), {});
  const Answer saved = Put(10, {{"name", "p1.jpg"}});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_TRUE(fs::exists(folder_ / "masks/rest/p1.jpg.png")) << "where capture looks for it";
  EXPECT_NE(Put(10, {{"name", "p2.jpg"}}).status, 200);
}

}  // namespace
}  // namespace keypose::studio
