#include "capture/salience/salience_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>

#include "core/numbers/parallel.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::capture::salience_network_test {

bool InBall(double x, double y) {
  const double dx = x - 190, dy = y - 130;
  return dx * dx + dy * dy < 70 * 70;
}

/// A shaded red ball before a wall and a floor.
Image8 BallInARoom() {
  Image8 picture(360, 240, 3);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      std::uint8_t* const pixel = picture.at(x, y);
      const bool floor = y > 170;
      for (int c = 0; c < 3; ++c)
        pixel[c] = static_cast<std::uint8_t>((floor ? 120 : 190) + (x * 7 + y * 13) % 9 - c * 8);
      if (!InBall(x + 0.5, y + 0.5)) continue;
      const double light = std::hypot(x - 165, y - 105);
      pixel[0] = static_cast<std::uint8_t>(240 - light * 1.4);
      pixel[1] = pixel[2] = static_cast<std::uint8_t>(std::max(0.0, 90 - light));
    }
  return picture;
}

double OverlapWithBall(const Image8& salience) {
  int both = 0, either = 0;
  for (int y = 0; y < salience.height; ++y)
    for (int x = 0; x < salience.width; ++x) {
      const bool truth = InBall(x + 0.5, y + 0.5), found = *salience.at(x, y) > 127;
      both += truth && found;
      either += truth || found;
    }
  return static_cast<double>(both) / either;
}

class SalienceNetworkTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto file = FindSalienceNetwork();
    if (!file) GTEST_SKIP() << kNoSalience;
    file_ = *file;
  }
  std::filesystem::path file_;
};

TEST_F(SalienceNetworkTest, FindsABallWithTheSameBitsForAnyThreadCount) {
  const auto network = SalienceNetwork::Open(file_);
  const Image8 picture = BallInARoom();
  SetThreadCount(1);
  const Image8 alone = network->Of(picture);
  SetThreadCount(3);
  const Image8 three = network->Of(picture);
  SetThreadCount(0);
  EXPECT_EQ(alone.data, three.data);
  ASSERT_EQ(alone.width, picture.width);
  ASSERT_EQ(alone.height, picture.height);
  EXPECT_GT(OverlapWithBall(alone), 0.9);
  for (const std::uint8_t value : alone.data) ASSERT_EQ(value % kSalienceStep, 0);
  EXPECT_GT(OverlapWithBall(network->Of(picture, SalienceFit::kMirrored)), 0.9);
}

TEST_F(SalienceNetworkTest, RefusesPicturesThatItCannotSee) {
  const auto network = SalienceNetwork::Open(file_);
  EXPECT_THROW(network->Of(Image8{}), InputError);
  EXPECT_THROW(network->Of(Image8(8, 8, 1)), InputError);
  EXPECT_EQ(network->Of(Image8(1, 1, 3)).data.size(), 1U);
}

TEST_F(SalienceNetworkTest, RefusesAnotherSquare) {
  EXPECT_THROW(SalienceNetwork::Open(file_, {.side_px = 500}), UsageError);
}

TEST(SalienceNetwork, DamagedFileIsRefusedWithTheCure) {
  const TestingFolder folder;
  const std::filesystem::path file = folder.path() / "isnet.onnx";
  std::ofstream(file) << "not the network";
  try {
    SalienceNetwork::Open(file);
    FAIL() << "a damaged file was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("./dev setup"), std::string::npos);
  }
}

TEST(FindSalienceNetwork, SaysNothingWhereItIsNotInstalled) {
  setenv("KEYPOSE_ISNET_ONNX", "/nowhere/isnet.onnx", 1);
  EXPECT_FALSE(FindSalienceNetwork());
  unsetenv("KEYPOSE_ISNET_ONNX");
}

}  // namespace keypose::capture::salience_network_test
