// The player's data, and the page in a headless Chromium if there is one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "report/contents.h"
#include "report/player_data.h"
#include "report/sections.h"

namespace keypose::report::player_test {

using ::testing::HasSubstr;

// Eight frames: keys 0, 3 and 7; 1 repeats 0, 5 repeats 4.
const std::vector<int> kRepeats = {0, 0, 2, 3, 4, 4, 6, 7};
const std::vector<char> kKeys = {1, 0, 0, 1, 0, 0, 0, 1};

TEST(FramesToStore, KeepsAllThatDifferWhereThereIsRoom) {
  EXPECT_EQ(FramesToStore(kRepeats, kKeys, 100), (std::vector<int>{0, 2, 3, 4, 6, 7}));
}

TEST(FramesToStore, KeepsAllKeysEvenWhereThereIsNone) {
  EXPECT_EQ(FramesToStore(kRepeats, kKeys, 1), (std::vector<int>{0, 3, 7}));
}

TEST(FramesToStore, TakesOthersEvenly) {
  std::vector<int> repeats(101);
  std::vector<char> keys(101, 0);
  for (int i = 0; i <= 100; ++i) repeats[i] = i;
  keys.front() = keys.back() = 1;
  const std::vector<int> stored = FramesToStore(repeats, keys, 12);
  ASSERT_EQ(stored.size(), 12u);
  for (std::size_t i = 1; i < stored.size(); ++i) EXPECT_LE(stored[i] - stored[i - 1], 11);
}

TEST(MomentsOf, HeldFramesStandAndMissingOnesAreBetweenTheirNeighbours) {
  const std::vector<PlayerMoment> moments = MomentsOf(kRepeats, {0, 3, 7});
  ASSERT_EQ(moments.size(), 8u);
  for (const int exact : {0, 1, 3, 7}) EXPECT_EQ(moments[exact].share, 0) << exact;
  EXPECT_EQ(moments[1].a, 0);
  EXPECT_EQ(moments[7].a, 2);
  EXPECT_NEAR(moments[2].share, 2.0 / 3, 1e-12);
  EXPECT_EQ(moments[4].share, moments[5].share);  // on twos
  EXPECT_EQ(moments[6].a, 1);
  EXPECT_EQ(moments[6].b, 2);
  EXPECT_NEAR(moments[6].share, 0.75, 1e-12);
}

TEST(TextureWeights, GoFromKeyToKey) {
  const std::vector<int> keys = {0, 2, 0};
  EXPECT_EQ(TextureWeights(0, keys, 3), (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(TextureWeights(0.25, keys, 3), (std::vector<double>{0.75, 0, 0.25}));
  EXPECT_EQ(TextureWeights(1, keys, 3), (std::vector<double>{0, 0, 1}));
  EXPECT_EQ(TextureWeights(2, keys, 3), (std::vector<double>{1, 0, 0}));
  EXPECT_EQ(TextureWeights(5, {}, 2), (std::vector<double>{1, 0}));
}

std::string Pixel(const Image8&) {
  return "data:image/"
         "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+"
         "M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
}

PlayerData Ball() {
  PlayerData data;
  data.mesh = MakeIcosphere(3);
  data.frames = {data.mesh.points, 1.5 * data.mesh.points};
  data.moments = {{0, 0, 0, {1, 0}}, {0, 1, 0.5, {0.5, 0.5}}, {1, 1, 0, {0, 1}}};
  data.keys = {0, 1};
  data.textures = {Image8(1, 1, 3), Image8(1, 1, 3)};
  return data;
}

std::string Decoded(const std::string& text) {
  static const std::string kDigits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned block = 0;
  int bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    block = block << 6 | static_cast<unsigned>(kDigits.find(c));
    if ((bits += 6) >= 8) bytes += static_cast<char>(block >> (bits -= 8) & 255U);
  }
  return bytes;
}

TEST(PlayerJson, PositionsComeBackWithinAStep) {
  const PlayerData data = Ball();
  const nlohmann::json json = nlohmann::json::parse(PlayerJson(data, Pixel));
  const std::string bytes = Decoded(json["positions"]);
  const auto vertices = static_cast<std::size_t>(data.mesh.points.rows());
  ASSERT_EQ(bytes.size(), 2 * 2 * 3 * vertices);
  for (std::size_t i = 0; i < 2 * 3 * vertices; ++i) {
    const unsigned word = static_cast<unsigned char>(bytes[2 * i]) |
                          static_cast<unsigned>(static_cast<unsigned char>(bytes[2 * i + 1])) << 8;
    const double value = json["low"][i % 3].get<double>() + json["step"].get<double>() * word;
    const auto row = static_cast<Eigen::Index>(i / 3);
    const double wanted = data.frames[i / (3 * vertices)](row % data.mesh.points.rows(),
                                                          static_cast<Eigen::Index>(i % 3));
    EXPECT_NEAR(value, wanted, 0.51 * json["step"].get<double>());
  }
  EXPECT_EQ(json["moments"][1]["share"], 0.5);
  EXPECT_EQ(json["textures"].size(), 2u);
}

TEST(PlayerJson, SeamsPartDrawnVerticesAndNothingElse) {
  PlayerData data = Ball();
  data.mesh.uvs = UvsX2::Zero(data.mesh.points.rows() + 1, 2);
  data.mesh.uv_faces = data.mesh.faces;
  data.mesh.uv_faces(0, 0) = static_cast<int>(data.mesh.points.rows());
  const nlohmann::json json = nlohmann::json::parse(PlayerJson(data, Pixel));
  EXPECT_EQ(Decoded(json["source"]).size(),
            2 * (static_cast<std::size_t>(data.mesh.points.rows()) + 1));
  EXPECT_EQ(Decoded(json["faces"]).size(),
            2 * 3 * static_cast<std::size_t>(data.mesh.face_count()));
}

std::string PageWithPlayer() {
  Contents contents;
  contents.run.project = "ball";
  contents.run.poses = {"rest", "up"};
  contents.player = PlayerPart{
      PlayerJson(Ball(), Pixel), 3, 2, 2, 2, true, Picture{"poster", Image8(4, 4, 3, 200)}};
  return BuildPage(contents, Pixel);
}

TEST(BuildPage, ForbidsTheBrowserToFetchAnything) {
  const std::string page = PageWithPlayer();
  EXPECT_THAT(page, HasSubstr("default-src 'none'; img-src data: blob:; style-src 'unsafe-inline'; "
                              "script-src 'unsafe-inline'"));
  for (const char* outside :
       {"src=\"http", "src=http", "href=\"http", "<link", "@import", "url(http"})
    EXPECT_EQ(page.find(outside), std::string::npos) << outside;
  EXPECT_THAT(page, HasSubstr("data-control=play"));
}

TEST(BuildPage, ThePlayersProgramLeavesRoomForPictures) {
  EXPECT_LT(std::string(PlayerScript()).size(), 700'000u);
  EXPECT_EQ(std::string(PlayerScript()).find("</script"), std::string::npos);
}

/// The page's document after a moment in a headless browser; empty if there is no Chromium.
std::string Browsed(const std::string& page, const std::string& more) {
  const TestingFolder own;
  const std::filesystem::path folder = own.path();
  std::ofstream(folder / "index.html") << page;
  const std::string command =
      "HOME=" + folder.string() +
      " timeout 100 chromium --headless --no-sandbox --use-angle=swiftshader " + more +
      " --enable-unsafe-swiftshader --disable-background-networking --virtual-time-budget=3000 "
      "--dump-dom file://" +
      (folder / "index.html").string() + " > " + (folder / "dom").string() + " 2> " +
      (folder / "log").string();
  const int code = std::system(command.c_str());
  std::ostringstream dom;
  dom << std::ifstream(folder / "dom").rdbuf();
  return code == 0 ? dom.str() : "";
}

bool HasChromium() { return std::system("command -v chromium > /dev/null 2>&1") == 0; }

TEST(Player, PlaysInABrowserWithoutAnyServer) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const std::string dom = Browsed(PageWithPlayer(), "");
  EXPECT_THAT(dom, HasSubstr("data-state=\"live\""));
  EXPECT_THAT(dom, HasSubstr("<canvas"));
  EXPECT_THAT(dom, HasSubstr("picture "));  // the clock has been written
  EXPECT_THAT(dom, HasSubstr("Pause"));     // it started by itself
}

TEST(Player, ItsPosterIsPrintedInPlaceOfTheCanvas) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const TestingFolder folder;
  const std::string pdf = (folder.path() / "page.pdf").string();
  Browsed(PageWithPlayer(), "--print-to-pdf=" + pdf);
  std::ostringstream printed;
  printed << std::ifstream(pdf).rdbuf();
  // The poster is the only picture of one pixel.
  EXPECT_THAT(printed.str(), HasSubstr("/Subtype /Image\n/Width 1\n/Height 1\n"));
}

TEST(Player, ShowsThePosterWithoutWebGl) {
  if (!HasChromium()) GTEST_SKIP() << "chromium is not installed";
  const std::string dom = Browsed(PageWithPlayer(), "--disable-gpu --disable-3d-apis");
  EXPECT_THAT(dom, HasSubstr("data-state=\"poster\""));
  EXPECT_EQ(dom.find("<canvas"), std::string::npos);
  EXPECT_THAT(dom, HasSubstr("alt=\"poster\""));
}

}  // namespace keypose::report::player_test
