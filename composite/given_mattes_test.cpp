#include "composite/given_mattes.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/pictures/png_io.h"
#include "core/testing/folder.h"

namespace keypose::composite::given_mattes_test {

/// 40 x 30: a block that is `inside` on `outside`.
Image8 Block(int outside, int inside) {
  Image8 block(40, 30, 1, static_cast<std::uint8_t>(outside));
  for (int y = 10; y < 20; ++y) std::fill_n(block.at(12, y), 16, static_cast<std::uint8_t>(inside));
  return block;
}

class GivenMattesFiles : public ::testing::Test, public TestingFolder {
 protected:
  bool AreInverted(const std::vector<Image8>& mattes) const {
    GivenMattes given("locate", "matte");
    for (const Image8& matte : mattes) {
      WritePng(path() / "m.png", matte);
      given.Read(path() / "m.png", {40, 30, 1, "p.jpg"});
    }
    return given.AreInverted();
  }
};

TEST_F(GivenMattesFiles, WhiteRoundTheFigureIsInvertedAlsoWithFramesOfNobody) {
  const Image8 nobody(40, 30, 1, 255), black(40, 30, 1);
  EXPECT_TRUE(AreInverted({Block(255, 0), Block(255, 0)}));
  EXPECT_TRUE(AreInverted({nobody, Block(255, 0), Block(255, 0)}));
  EXPECT_TRUE(AreInverted({Block(255, 0), black, nobody}));
  EXPECT_FALSE(AreInverted({Block(255, 0), Block(0, 255)}));
  EXPECT_FALSE(AreInverted({Block(0, 255), nobody})) << "the figure fills a picture";
  EXPECT_FALSE(AreInverted({nobody, nobody})) << "nothing tells";
}

}  // namespace keypose::composite::given_mattes_test
