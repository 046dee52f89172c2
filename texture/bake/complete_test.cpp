// Textures with known colours under another light and with holes: completed ones are compared with
// the truth.
#include "texture/bake/complete.h"

#include <gmock/gmock.h>

#include "core/values/errors.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::complete_test {

constexpr int kSize = 256;

/// The colours of a pose: confidence in [0, 1] at a point, and its light there.
using Sure = std::function<double(const Vector3d&)>;
using Light = std::function<Vector3f(const Vector3d&)>;
const Light kWhite = [](const Vector3d&) { return Vector3f(1, 1, 1); };

class CompleteTextureTest : public ::testing::Test {
 protected:
  Vector3d PointOf(std::size_t texel) const {
    const Vector3f w = atlas_.Weights(texel);
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += static_cast<double>(w[k]) *
           mesh_.points.row(mesh_.faces(atlas_.face[texel], k)).transpose();
    return x;
  }

  /// Painted by Smooth where the confidence is positive; red elsewhere, so that colours taken from
  /// there are visible.
  PoseTexture Pose(const Sure& sure, const Light& light) const {
    PoseTexture pose{Image8(kSize, kSize, 3), Image8(kSize, kSize, 1)};
    for (std::size_t texel = 0; texel < atlas_.face.size(); ++texel) {
      if (atlas_.face[texel] < 0) continue;
      const Vector3d x = PointOf(texel);
      const double s = std::clamp(sure(x), 0.0, 1.0);
      const Vector3f color =
          s > 0 ? Smooth(x, x).cwiseProduct(light(x)).eval() : Vector3f(0.9f, 0, 0);
      for (int c = 0; c < 3; ++c) pose.texture.data[3 * texel + c] = SrgbOf(color[c]);
      pose.confidence.data[texel] = static_cast<std::uint8_t>(std::lround(255 * s));
    }
    return pose;
  }

  /// Largest and mean difference from the truth in steps of 8-bit sRGB, over the texels for which
  /// `where` is true.
  struct Error {
    int largest = 0, texels = 0;
    double mean = 0;
  };
  Error ErrorOf(const Image8& texture, const std::function<bool(const Vector3d&)>& where) const {
    Error error;
    for (std::size_t texel = 0; texel < atlas_.face.size(); ++texel) {
      if (!atlas_.inside[texel]) continue;
      const Vector3d x = PointOf(texel);
      if (!where(x)) continue;
      const Vector3f truth = Smooth(x, x);
      for (int c = 0; c < 3; ++c) {
        const int apart = std::abs(texture.data[3 * texel + c] - SrgbOf(truth[c]));
        error.largest = std::max(error.largest, apart), error.mean += apart / 3.0;
      }
      ++error.texels;
    }
    error.mean /= std::max(1, error.texels);
    return error;
  }

  Mesh mesh_ = PatchSphere(16);
  Atlas atlas_ = RasterizeAtlas(mesh_, kSize);
  const Sure upper_ = [](const Vector3d& x) {
    return (x.z() + 0.1) / 0.2;
  };  // fades out around the equator
  const Sure lower_ = [](const Vector3d& x) { return (0.5 - x.z()) / 0.2; };  // overlaps it
};

TEST_F(CompleteTextureTest, WhatOnlyTheOtherPoseShowsComesInTheOwnLightWithoutASeam) {
  const auto dim = [](const Vector3d& x) -> Vector3f {
    return Vector3f(0.7f, 0.8f, 0.95f) * (1 + 0.1f * static_cast<float>(x.x()));
  };
  const PoseTexture own = Pose(upper_, kWhite), other = Pose(lower_, dim);
  const Completed alone = CompleteTexture(mesh_, own, {own}, 4),
                  completed = CompleteTexture(mesh_, own, {own, other}, 4);
  const auto hidden = [](const Vector3d& x) { return x.z() < -0.1; };
  EXPECT_GT(ErrorOf(alone.texture, hidden).mean, 15)
      << "a guess is far off, or this test shows nothing";
  // The remaining error: beyond the overlap the light's slope continues as a constant, 10 % over
  // the sphere, about 5 steps at its foot.
  EXPECT_LT(ErrorOf(completed.texture, hidden).mean, 4);
  // Without levelling, the seam would be 24 to 29 steps high. The factor is smooth over some faces,
  // so a part of the slope remains.
  EXPECT_LT(
      ErrorOf(completed.texture, [](const Vector3d& x) { return std::abs(x.z()) < 0.15; }).largest,
      12)
      << "a seam shows";
  EXPECT_NEAR(static_cast<double>(completed.filled_texels) / static_cast<double>(completed.texels),
              0.5, 0.03);
  EXPECT_EQ(completed.taken[0], 0) << "the own texture gives nothing to itself";
  EXPECT_EQ(completed.unseen_texels(), 0);
}

TEST_F(CompleteTextureTest, WhatTheOwnPhotographsShowStaysAsItIs) {
  const PoseTexture own = Pose(upper_, kWhite),
                    other =
                        Pose(lower_, [](const Vector3d&) { return Vector3f(0.5f, 0.5f, 0.5f); });
  const Completed completed = CompleteTexture(mesh_, own, {other}, 4);
  for (std::size_t texel = 0; texel < atlas_.face.size(); ++texel) {
    if (!atlas_.inside[texel] || own.confidence.data[texel] < 255) continue;
    for (int c = 0; c < 3; ++c)
      ASSERT_EQ(completed.texture.data[3 * texel + c], own.texture.data[3 * texel + c]) << texel;
  }
}

/// The same pose with 16 bits, each level moved by up to half a step of 8.
PoseTexture Deep(const PoseTexture& pose) {
  PoseTexture deep{{}, pose.confidence, Image16(kSize, kSize, 3)};
  for (std::size_t i = 0; i < pose.texture.data.size(); ++i)
    deep.deep.data[i] = static_cast<std::uint16_t>(
        std::clamp<int>(257 * pose.texture.data[i] + static_cast<int>(i % 257) - 128, 0, 65535));
  return deep;
}

TEST_F(CompleteTextureTest, SixteenBitsStayAndFillAsEightDo) {
  const PoseTexture own = Pose(upper_, kWhite), other = Pose(lower_, kWhite);
  const PoseTexture deep = Deep(own);
  const Completed eight = CompleteTexture(mesh_, own, {own, other}, 4),
                  completed = CompleteTexture(mesh_, deep, {deep, Deep(other)}, 4);
  for (std::size_t texel = 0; texel < atlas_.face.size(); ++texel) {
    if (!atlas_.inside[texel] || own.confidence.data[texel] < 255) continue;
    for (std::size_t i = 3 * texel; i < 3 * texel + 3; ++i)
      ASSERT_EQ(Srgb16Of(completed.linear.data[i]), deep.deep.data[i]) << texel;
  }
  EXPECT_EQ(completed.filled_texels, eight.filled_texels);
  EXPECT_EQ(completed.taken[0], 0) << "the own texture gives nothing to itself";
  EXPECT_LT(ErrorOf(completed.texture, [](const Vector3d&) { return true; }).mean,
            ErrorOf(eight.texture, [](const Vector3d&) { return true; }).mean + 0.5);
  EXPECT_NO_THROW(CompleteTexture(mesh_, own, {Deep(other)}, 4));
  EXPECT_NO_THROW(CompleteTexture(mesh_, Deep(own), {other}, 4));
}

TEST_F(CompleteTextureTest, SpotsThatShowSomethingElseDoNotTintWhatIsTaken) {
  // In the overlap a spot of the other pose is in deep shadow: a cast shadow.
  const auto shade = [](const Vector3d& x) {
    return Vector3f((x - Vector3d(0.97, 0, 0.22)).norm() < 0.2 ? Vector3f(0.3f, 0.3f, 0.3f)
                                                               : Vector3f(1, 1, 1));
  };
  const Completed completed =
      CompleteTexture(mesh_, Pose(upper_, kWhite), {Pose(lower_, shade)}, 4);
  EXPECT_LT(ErrorOf(completed.texture, [](const Vector3d& x) { return x.z() < -0.25; }).largest, 8);
}

TEST_F(CompleteTextureTest, EachPlaceComesFromThePoseThatShowsItBest) {
  const Sure east = [](const Vector3d& x) { return x.z() < 0.5 && x.x() > -0.1 ? 1 : 0; };
  const Sure west = [](const Vector3d& x) { return x.z() < 0.5 && x.x() < 0.1 ? 1 : 0; };
  const Completed completed =
      CompleteTexture(mesh_, Pose(upper_, kWhite), {Pose(east, kWhite), Pose(west, kWhite)}, 4);
  EXPECT_LT(ErrorOf(completed.texture, [](const Vector3d& x) { return x.z() < 0; }).largest, 4);
  EXPECT_NEAR(static_cast<double>(completed.taken[0]), static_cast<double>(completed.taken[1]),
              0.1 * static_cast<double>(completed.texels));
}

TEST_F(CompleteTextureTest, WhatNoPoseShowsIsCountedAndPaintedSmoothly) {
  const Sure band = [](const Vector3d& x) { return x.z() < 0.5 && x.z() > -0.7 ? 1 : 0; };
  const Completed completed = CompleteTexture(mesh_, Pose(upper_, kWhite), {Pose(band, kWhite)}, 4);
  EXPECT_NEAR(
      static_cast<double>(completed.unseen_texels()) / static_cast<double>(completed.texels), 0.15,
      0.03);
  // The red of unseen places must not appear; a smooth interpolation only lacks the pattern.
  EXPECT_LT(ErrorOf(completed.texture, [](const Vector3d& x) { return x.z() < -0.75; }).mean, 45);
}

TEST_F(CompleteTextureTest, SameBitsForAnyThreadCount) {
  const PoseTexture own = Pose(upper_, kWhite),
                    other =
                        Pose(lower_, [](const Vector3d&) { return Vector3f(0.8f, 0.9f, 1.0f); });
  SetThreadCount(1);
  const auto one = CompleteTexture(mesh_, own, {other}, 4).texture.data;
  SetThreadCount(4);
  const auto four = CompleteTexture(mesh_, own, {other}, 4).texture.data;
  SetThreadCount(0);
  EXPECT_TRUE(one == four);
}

TEST_F(CompleteTextureTest, AnotherSizeThrowsInputErrorThatNamesTheTexture) {
  const PoseTexture own = Pose(upper_, kWhite), small{Image8(64, 64, 3), Image8(64, 64, 1)};
  try {
    CompleteTexture(mesh_, own, {small}, 4);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("texture 1 of the others is 64 x 64"));
  }
  EXPECT_THROW(CompleteTexture(mesh_, {own.texture, small.confidence}, {}, 4), InputError);
}

}  // namespace keypose::texture::complete_test
