#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/dng.h"
#include "core/testing/folder.h"
#include "studio/project/pose_photographs.h"
#include "studio/routes/routes.h"

namespace keypose::studio::masks_routes_test {

namespace fs = std::filesystem;
using nlohmann::json;

class MasksRoutes : public ::testing::Test, public TestingFolder {
 protected:
  MasksRoutes() {
    fs::create_directories(folder_ / "photos/rest");
    WriteImage(folder_ / "photos/rest/a.png", Image8(60, 40, 3, 90));
    WriteFile(folder_ / "pipeline.yaml", "name: x\nposes: {rest: photos/rest}\ntemplate: rest\n");
    routes_ = std::make_unique<Routes>(folder_);
  }
  ~MasksRoutes() override { routes_.reset(); }
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

  json Photographs() {
    return json::parse(routes_->Handle({"GET", "/api/photos", {{"pose", "rest"}}, ""}).bytes);
  }
  int Hold(bool hold) {
    const json body = {{"pose", "rest"}, {"names", {"a.png"}}, {"hold", hold}};
    return routes_->Handle({"POST", "/api/masks/hold", {}, body.dump()}).status;
  }
  void Shoot(int grey, int width = 60) const {
    WriteImage(folder_ / "photos/rest/a.png", Image8(width, 40, 3, static_cast<uint8_t>(grey)));
  }
  /// White rows of a file.
  int Rows(const char* name) const {
    const Image8 mask = ReadImage(folder_ / "masks/rest" / name, 1);
    return static_cast<int>(std::count(mask.data.begin(), mask.data.end(), 255) / 60);
  }

  std::unique_ptr<Routes> routes_;
};

TEST_F(MasksRoutes, WhatWasChangedMeanwhileIsNotWrittenOver) {
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
  EXPECT_THAT(late.bytes, ::testing::HasSubstr("the mask of a.png was changed elsewhere"));
  EXPECT_EQ(Get().first, 12);
  EXPECT_EQ(Put(14, {}).status, 200) << "who names no revision writes as into a folder";
}

TEST_F(MasksRoutes, APhotographThatCaptureDevelopsMayHaveOne) {
  WriteDng(folder_ / "photos/rest/p1.dng", ImageF(60, 40, 3, 0.2f), {});
  const Answer saved = Put(10, {{"name", "p1.jpg"}});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_TRUE(fs::exists(folder_ / "masks/rest/p1.jpg.png")) << "where capture looks for it";
  EXPECT_NE(Put(10, {{"name", "p2.jpg"}}).status, 200);
}

TEST_F(MasksRoutes, OfAPhotographThatWasShotAgainIsHeldOrSetAsideAndNeverLost) {
  ASSERT_EQ(Put(10, {}).status, 200);
  EXPECT_EQ(Photographs()[0].at("mask_given"), true);
  EXPECT_EQ(Photographs()[0].at("mask_of_another"), false);
  EXPECT_EQ(Hold(true), 400) << "nothing to decide";
  Shoot(50);
  EXPECT_EQ(Photographs()[0].at("mask_given"), false);
  EXPECT_EQ(Photographs()[0].at("mask_of_another"), true);
  EXPECT_EQ(Get().first, -1) << "the brush begins without it";
  ASSERT_EQ(Hold(true), 200);
  EXPECT_EQ(Get().first, 10);
  Shoot(51);
  ASSERT_EQ(Hold(false), 200);
  EXPECT_EQ(Photographs()[0].at("mask_of_another"), false);
  EXPECT_EQ(Rows("a.png.png.old"), 10);
  ASSERT_EQ(Put(11, {}).status, 200);
  Shoot(52, 90);
  EXPECT_EQ(Hold(true), 400) << "it has another size now";
  Shoot(53);
  ASSERT_EQ(Put(12, {{"revision", ""}}).status, 200) << "painted anew";
  EXPECT_EQ(Get().first, 12);
  EXPECT_EQ(Rows("a.png.png.old"), 10);
  EXPECT_EQ(Rows("a.png.png.old2"), 11);
}

TEST_F(MasksRoutes, IsOfThePhotographThatWasUnderTheBrush) {
  const std::string under = Photographs()[0].at("photograph");
  Shoot(50);
  ASSERT_EQ(Put(10, {{"photograph", under}}).status, 200);
  EXPECT_EQ(Photographs()[0].at("mask_of_another"), true);
  EXPECT_EQ(Put(10, {{"photograph", "x"}}).status, 400);
}

TEST_F(MasksRoutes, PhotographsInSubfoldersHaveThemUnderTheNamesThatCaptureGives) {
  for (const char* lay : {"upright", "lying"}) {
    fs::create_directories(folder_ / "photos/rest" / lay);
    fs::copy(folder_ / "photos/rest/a.png", folder_ / "photos/rest" / lay / "b.png");
  }
  const Answer saved = Put(10, {{"name", "lying_b.png"}});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  EXPECT_EQ(Rows("lying_b.png.png"), 10);
}

TEST_F(MasksRoutes, APortraitThatCaptureTurnsIsPaintedAsThePageShowsIt) {
  WriteImage(folder_ / "photos/rest/tall.png", Image8(40, 60, 3, 90));
  const Answer saved = Put(10, {{"name", "tall.png"}});
  ASSERT_EQ(saved.status, 200) << saved.bytes;
  const fs::path file = folder_ / "masks/rest/tall.png.png";
  const Image8 mask = ReadImage(file, 1);
  ASSERT_EQ(mask.width, 40) << "as the photograph lies in its file";
  EXPECT_EQ(mask.at(5, 30)[0], 255);  // capture turns clockwise: the left becomes the top
  EXPECT_EQ(mask.at(35, 30)[0], 0);
  const Image8 shown = ReadImage(MaskPicture(folder_ / "kept", file, 60, 40), 1);
  EXPECT_EQ(shown.data, ReadImage(folder_ / "mask.png", 1).data);
}

TEST_F(MasksRoutes, AMaskOfAnotherProgramIsShownAsCaptureTakesIt) {
  for (const auto& [low, high] : {std::pair{0, 1}, {255, 0}}) {
    Image8 mask(60, 40, 1, static_cast<std::uint8_t>(low));
    for (int y = 10; y < 20; ++y)
      for (int x = 20; x < 40; ++x) *mask.at(x, y) = static_cast<std::uint8_t>(high);
    const fs::path file = folder_ / fmt::format("masks/rest/of{}.png", high);
    fs::create_directories(file.parent_path());
    WriteImage(file, mask);
    const Image8 shown = ReadImage(MaskPicture(folder_ / "kept", file, 60, 40), 1);
    EXPECT_EQ(*shown.at(30, 15), 255) << high;
    EXPECT_EQ(*shown.at(5, 5), 0) << high;
  }
}

}  // namespace keypose::studio::masks_routes_test
