// Pictures with alpha, the shadow in them, and PNG as read by another program.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "export/film/film.h"

namespace keypose::exporting::picture_test {

const std::vector<Image8> kNoTextures;

/// A unit sphere on the plane z = 0, in grey of 200.
std::vector<Mesh> RestingSphere() {
  Mesh sphere = MakeIcosphere(4);
  sphere.points.col(2).array() += 1;
  sphere.colors = ColorsX3::Constant(sphere.vertex_count(), 3, 200);
  return {sphere};
}

struct Rendered {
  View view;
  Image8 picture;
};

Rendered RenderSphere(bool shadow) {
  const std::vector<Mesh> frames = RestingSphere();
  const FilmOptions options{320, 240, 0, true, true};
  const Ground ground = GroundUnder(frames, Eigen::Vector3d::UnitZ());
  const View view = FilmView(frames, options);
  return {view, RenderPicture({frames, kNoTextures, {}}, 0, view, shadow ? &ground : nullptr)};
}

/// The alpha at a point of the table.
int AlphaAt(const Rendered& rendered, double x, double y) {
  const Eigen::Vector2d pixel = rendered.view.Project({x, y, 0});
  return rendered.picture.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))[3];
}

TEST(RenderPicture, ShadowIsBlackWithAlphaDarkBesideTheContactAndNoneInTheSky) {
  const Rendered rendered = RenderSphere(true);
  const int beside = AlphaAt(rendered, 0.7, -0.9), farther = AlphaAt(rendered, 1.1, -0.9);
  EXPECT_GT(beside, 10);
  EXPECT_LT(beside, 200);
  EXPECT_GT(beside, farther + 5);
  EXPECT_EQ(rendered.picture.at(2, 2)[3], 0) << "sky";
  int shadow_pixels = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const std::uint8_t* rgba = rendered.picture.at(x, y);
      if (rgba[3] == 0 || rgba[3] > 60) continue;
      ++shadow_pixels;
      // A pixel that the figure covers for the most part would have more alpha than these.
      EXPECT_LT(rgba[0], 200);
    }
  EXPECT_GT(shadow_pixels, 2000);
}

TEST(RenderPicture, LaidOverGreyTheShadowTakesTheLightThatItHides) {
  const Rendered rendered = RenderSphere(true);
  const Image8 flat = LaidOver(rendered.picture, {200, 200, 200});
  const double hidden = 1 / std::pow(1 + 0.7 * 0.7 + 0.9 * 0.9, 1.5);  // the sphere's form factor
  const double seen = (hidden - 0.06) / 0.94, dark = seen * seen * (3 - 2 * seen);
  const Eigen::Vector2d pixel = rendered.view.Project({0.7, -0.9, 0});
  const double shown = flat.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()))[0];
  EXPECT_NEAR(std::pow(shown / 200, 2.2), 1 - 0.85 * dark, 0.03);
}

TEST(RenderPicture, WithoutATableOnlyTheFigureHasAlpha) {
  const Rendered rendered = RenderSphere(false);
  EXPECT_EQ(AlphaAt(rendered, 1.1, -0.9), 0);
  const Eigen::Vector2d centre = rendered.view.Project({0, 0, 1});
  EXPECT_EQ(rendered.picture.at(static_cast<int>(centre.x()), static_cast<int>(centre.y()))[3],
            255);
}

TEST(RenderPicture, HardlyAnyShadowReachesThePicturesBorder) {
  const Rendered rendered = RenderSphere(true);
  int most = 0;
  for (int x = 0; x < 320; ++x) most = std::max<int>(most, rendered.picture.at(x, 239)[3]);
  EXPECT_LE(most, 6);
}

TEST(RenderPicture, SlowGradientsHaveNoBands) {
  const Rendered rendered = RenderSphere(true);
  const int row = static_cast<int>(rendered.view.Project({0, -1.1, 0}).y());
  ASSERT_LT(row, 240);
  int longest = 0, run = 0, pixels = 0;
  for (int x = 1; x < 320; ++x) {
    const int alpha = rendered.picture.at(x, row)[3], before = rendered.picture.at(x - 1, row)[3];
    const bool faint = alpha > 0 && alpha < 60;
    pixels += faint;
    run = faint && alpha == before ? run + 1 : 0;
    longest = std::max(longest, run);
  }
  EXPECT_GT(pixels, 100);
  EXPECT_LT(longest, 24) << "pixels of one value in a row where the shadow fades";
}

TEST(RenderPicture, SameBitsForAnyThreadCount) {
  SetThreadCount(1);
  const Image8 one = RenderSphere(true).picture;
  SetThreadCount(3);
  const Image8 three = RenderSphere(true).picture;
  SetThreadCount(0);
  EXPECT_EQ(one.data, three.data);
}

TEST(LaidOver, MixesStoredValuesByAlpha) {
  Image8 picture(3, 1, 4);
  const std::uint8_t pixels[3][4] = {{10, 20, 30, 0}, {10, 20, 30, 255}, {100, 0, 255, 51}};
  for (int x = 0; x < 3; ++x) std::copy(pixels[x], pixels[x] + 4, picture.at(x, 0));
  const Image8 flat = LaidOver(picture, {200, 100, 0});
  EXPECT_EQ(flat.channels, 3);
  EXPECT_EQ(flat.data, (std::vector<std::uint8_t>{200, 100, 0, 10, 20, 30, 180, 80, 51}));
  EXPECT_EQ(LaidOver(flat, {1, 2, 3}).data, flat.data);
  EXPECT_THROW(LaidOver(Image8(2, 2, 1), {0, 0, 0}), InputError);
}

cv::Mat ReadBack(const std::string& bytes) {
  const std::vector<std::uint8_t> buffer(bytes.begin(), bytes.end());
  return cv::imdecode(buffer, cv::IMREAD_UNCHANGED);
}

TEST(EncodePng, AnotherProgramReadsColourAndAlphaExactly) {
  const Image8 picture = RenderSphere(true).picture;
  const cv::Mat read = ReadBack(EncodePng(picture));
  ASSERT_EQ(read.type(), CV_8UC4);
  ASSERT_EQ(read.cols, 320);
  ASSERT_EQ(read.rows, 240);
  int different = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const cv::Vec4b bgra = read.at<cv::Vec4b>(y, x);
      const std::uint8_t* rgba = picture.at(x, y);
      different +=
          bgra[0] != rgba[2] || bgra[1] != rgba[1] || bgra[2] != rgba[0] || bgra[3] != rgba[3];
    }
  EXPECT_EQ(different, 0);
  EXPECT_EQ(ReadBack(EncodePng(LaidOver(picture, kFilmBackground))).type(), CV_8UC3);
}

TEST(EncodePng, OtherChannelsAndNoPixelsThrowInputError) {
  EXPECT_THROW(EncodePng(Image8(4, 4, 1)), InputError);
  EXPECT_THROW(EncodePng(Image8()), InputError);
}

}  // namespace keypose::exporting::picture_test
