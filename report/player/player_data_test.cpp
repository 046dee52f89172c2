#include "report/player/player_data.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "report/testing/page_with_player.h"

namespace keypose::report::player_data_test {

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

}  // namespace keypose::report::player_data_test
