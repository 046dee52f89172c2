#include "capture/shoot/develop/white_balance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pictures/srgb.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::white_balance_test {

/// sRGB byte of linear light.
std::uint8_t Byte(double linear) {
  return static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(std::min(1.0, linear))));
}

void Fill(Image8& image, const PixelBox& box, double red, double green, double blue) {
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      image.at(x, y)[0] = Byte(red), image.at(x, y)[1] = Byte(green),
                  image.at(x, y)[2] = Byte(blue);
    }
}

/// A coloured, uneven set with a card of 18 % grey under light of the given colour.
Image8 SetWithCard(const PixelBox& card, double red, double blue) {
  Image8 image(400, 300, 3);
  for (int y = 0; y < 300; ++y)
    for (int x = 0; x < 400; ++x)
      Fill(image, {x, y, 1, 1}, red * (0.2 + 0.15 * ((x / 5 + y / 7) % 2)),
           0.1 + 0.1 * ((x / 3) % 2), 0.05);
  Fill(image, card, 0.18 * red, 0.18, 0.18 * blue);
  return image;
}

TEST(GainsFromCard, UndoTheColourOfTheLight) {
  const PixelBox card{100, 80, 90, 60};
  const WhiteGains gains = GainsFromCard(SetWithCard(card, 1.5, 0.6), {120, 95, 40, 30});
  // Of 8 bits: half a grey level of 92 is 1.3 % of linear light, in each of two channels.
  EXPECT_NEAR(gains[0], 1 / 1.5, 0.02 / 1.5);
  EXPECT_EQ(gains[1], 1);
  EXPECT_NEAR(gains[2], 1 / 0.6, 0.02 / 0.6);
}

TEST(WithGains, MakesTheCardGrey) {
  const PixelBox card{100, 80, 90, 60};
  const Image8 image = SetWithCard(card, 1.4, 0.7);
  const Image8 white = WithGains(image, GainsFromCard(image, card));
  const std::uint8_t* pixel = white.at(140, 110);
  EXPECT_NEAR(pixel[0], pixel[1], 1);
  EXPECT_NEAR(pixel[2], pixel[1], 1);
  EXPECT_EQ(pixel[1], image.at(140, 110)[1]);
}

TEST(FindCard, FindsTheCardOnAnUnevenSet) {
  const PixelBox card{150, 100, 90, 60};
  const auto found = FindCard(SetWithCard(card, 1.3, 0.8));
  ASSERT_TRUE(found);
  EXPECT_GE(found->x, card.x);
  EXPECT_GE(found->y, card.y);
  EXPECT_LE(found->x + found->width, card.x + card.width);
  EXPECT_LE(found->y + found->height, card.y + card.height);
}

TEST(FindCard, FindsNothingWhereThereIsNoCard) {
  EXPECT_FALSE(FindCard(SetWithCard({0, 0, 1, 1}, 1, 1)));
  EXPECT_FALSE(FindCard(Image8(400, 300, 3, 128)));  // an even backdrop reaches the border
}

TEST(GainsFromCard, RefusesWhatIsNoCard) {
  const PixelBox all{0, 0, 400, 300};
  Image8 image(400, 300, 3);
  EXPECT_THROW(GainsFromCard(image, all), InputError);  // black
  Fill(image, all, 1, 1, 1);
  EXPECT_THROW(GainsFromCard(image, all), InputError);  // burnt out
  Fill(image, all, 0.5, 0.02, 0.02);
  EXPECT_THROW(GainsFromCard(image, all), InputError);  // red
  Fill(image, all, 0.2, 0.2, 0.2);
  EXPECT_NO_THROW(GainsFromCard(image, all));
  EXPECT_THROW(GainsFromCard(image, {390, 0, 20, 20}), InputError);
  EXPECT_THROW(GainsFromCard(image, {-1, 0, 20, 20}), InputError);
  EXPECT_THROW(GainsFromCard(image, {0, 0, 2, 2}), InputError);
}

}  // namespace keypose::capture::shoot::white_balance_test
