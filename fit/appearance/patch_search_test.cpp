#include "fit/appearance/patch_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/values/size_of.h"

namespace keypose::fit::patch_search_test {

constexpr int kSize = 200;
constexpr double kRadius = 70;
const Eigen::Vector2d kMiddle(90, 100);

/// A value that looks random, for each cell of a grid.
double Noise(int x, int y) {
  const double value = std::sin(127.1 * x + 311.7 * y) * 43758.5453;
  return value - std::floor(value);
}

/// Smooth noise with cells of this size [px], 0 to 1.
double SmoothNoise(const Eigen::Vector2d& at, double cell) {
  const int x = static_cast<int>(std::floor(at.x() / cell)),
            y = static_cast<int>(std::floor(at.y() / cell));
  const double u = at.x() / cell - x, v = at.y() / cell - y;
  const double s = u * u * (3 - 2 * u), t = v * v * (3 - 2 * v);
  return (1 - t) * ((1 - s) * Noise(x, y) + s * Noise(x + 1, y)) +
         t * ((1 - s) * Noise(x, y + 1) + s * Noise(x + 1, y + 1));
}

/// Blotches of several sizes.
double Texture(const Eigen::Vector2d& at) {
  return 60 + 60 * SmoothNoise(at, 24) + 40 * SmoothNoise(at, 11) + 25 * SmoothNoise(at, 5);
}

bool OnDisc(const Eigen::Vector2d& at) { return (at - kMiddle).norm() < kRadius; }

/// The textured disc as it lies.
TexturedRender Render() {
  TexturedRender render{ImageT<int>(kSize, kSize, 1, -1), ImageF(kSize, kSize, 1, 5.0f),
                        ImageF(kSize, kSize, 1)};
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (OnDisc({x, y})) {
        *render.face.at(x, y) = 0;
        *render.grey.at(x, y) = static_cast<float>(Texture({x, y}));
      }
  return render;
}

/// The disc turned by 10 degrees and moved by 15 pixels.
Eigen::Vector2d Moved(const Eigen::Vector2d& at) {
  return Eigen::Rotation2Dd(10 * M_PI / 180) * (at - kMiddle) + kMiddle + Eigen::Vector2d(12, -9);
}

Eigen::Vector2d MovedBack(const Eigen::Vector2d& at) {
  return Eigen::Rotation2Dd(-10 * M_PI / 180) * (at - kMiddle - Eigen::Vector2d(12, -9)) + kMiddle;
}

struct Photo {
  ImageF grey{kSize, kSize, 1};
  GreyMask mask{kSize, kSize, 1};
};

/// The moved disc under a light that falls off to one side, before a bright set.
Photo Photographed(double (*texture)(const Eigen::Vector2d&)) {
  Photo photo;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const Eigen::Vector2d from = MovedBack({x, y});
      *photo.mask.at(x, y) = OnDisc(from) ? 1 : 0;
      *photo.grey.at(x, y) =
          static_cast<float>(OnDisc(from) ? (0.7 + 0.002 * x) * texture(from) - 0.1 * y : 240.0);
    }
  return photo;
}

std::vector<SeenVertex> Grid() {
  std::vector<SeenVertex> seen;
  for (int y = 30; y < kSize; y += 8)
    for (int x = 20; x < kSize; x += 8)
      if ((Eigen::Vector2d(x, y) - kMiddle).norm() < kRadius - 5)
        seen.push_back({SizeOf(seen), {x, y}, 5, 1});
  return seen;
}

/// At half the resolution: every second pixel.
template <class T>
ImageT<T> Halved(const ImageT<T>& image) {
  ImageT<T> half(image.width / 2, image.height / 2, 1);
  for (int y = 0; y < half.height; ++y)
    for (int x = 0; x < half.width; ++x) *half.at(x, y) = *image.at(2 * x, 2 * y);
  return half;
}

struct Search {
  TexturedRender render = Render(),
                 half{Halved(render.face), Halved(render.depth), Halved(render.grey)};
  std::vector<SeenVertex> seen = Grid(), half_seen = seen;

  std::vector<FoundPatch> Of(const Photo& photo) {
    for (SeenVertex& one : half_seen) one.pixel /= 2;
    const ImageF grey = Halved(photo.grey);
    const GreyMask mask = Halved(photo.mask);
    const std::vector<FoundPatch> coarse = SearchPatches(half_seen, {half, grey, mask, 100}, {});
    return RefinePatches(seen, coarse, {render, photo.grey, photo.mask, 200}, {});
  }
};

int CountFound(const std::vector<FoundPatch>& patches) {
  int count = 0;
  for (const FoundPatch& patch : patches) count += patch.found;
  return count;
}

TEST(SearchPatches, FollowALargeMoveAndTurnUnderAnotherLight) {
  Search search;
  const std::vector<FoundPatch> found = search.Of(Photographed(Texture));
  EXPECT_GT(CountFound(found), SizeOf(found) / 2);
  double sum = 0;
  for (int i = 0; i < SizeOf(found); ++i) {
    if (!found[i].found) continue;
    const Eigen::Vector2d at = search.seen[i].pixel;
    const double error = (at + found[i].shift - Moved(at)).norm();
    EXPECT_LT(error, 3) << at.transpose();
    EXPECT_NEAR(found[i].turn, 10 * M_PI / 180, 0.2);
    sum += error;
  }
  EXPECT_LT(sum / CountFound(found), 0.8);  // whole pixels; moves are 6 to 25 pixels
}

TEST(SearchPatches, FindLittleInAnotherTexture) {
  const auto other = [](const Eigen::Vector2d& at) {
    return Texture(Eigen::Vector2d(1000, 500) - at);
  };
  EXPECT_LT(CountFound(Search().Of(Photographed(other))), SizeOf(Grid()) / 4);
}

TEST(SearchPatches, ATextureThatRepeatsIsNotFound) {
  const auto stripes = [](const Eigen::Vector2d& at) {
    return 120 + 50 * std::sin(0.8 * at.x()) * std::sin(0.8 * at.y());
  };
  Search search;
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      if (OnDisc({x, y})) *search.render.grey.at(x, y) = static_cast<float>(stripes({x, y}));
  search.half.grey = Halved(search.render.grey);
  EXPECT_EQ(CountFound(search.Of(Photographed(stripes))), 0);
}

TEST(SearchPatches, NothingOutsideOfTheMask) {
  Photo photo = Photographed(Texture);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kMiddle.x(); ++x) *photo.mask.at(x, y) = 0;
  Search search;
  const std::vector<FoundPatch> found = search.Of(photo);
  ASSERT_GT(CountFound(found), 0);
  // its middle is inside at half the resolution; then it is moved by two pixels at most
  for (int i = 0; i < SizeOf(found); ++i)
    if (found[i].found) {
      EXPECT_GT(search.seen[i].pixel.x() + found[i].shift.x(), kMiddle.x() - 4);
    }
}

}  // namespace keypose::fit::patch_search_test
