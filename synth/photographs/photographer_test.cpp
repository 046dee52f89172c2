#include "synth/photographs/photographer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "synth/photographs/testing/small_photographs.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth::photographer_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

// A grey ball without grain, with one red spot.
World SpottedBall(const Vector3d& center, const Vector3d& spot) {
  World world;
  world.clay.lumps.push_back({center, center, 0.05, 0.05, 0.005, {0.4, 0.4, 0.4}, false});
  world.clay.spots.push_back({spot, 0.006, {0.8, 0.02, 0.02}});
  world.clay.grain = world.clay.dent_depth = world.clay.ridge_height = 0;
  world.clay.flat_base = false;
  Vector3d low, high;
  world.clay.Bounds(&low, &high);
  world.rest =
      Polygonize([&](const Vector3d& x) { return world.clay.Distance(x); }, low, high, 0.004);
  world.poses = {{"rest", {}}};
  return world;
}

TEST(Photographer, PaintAppearsWhereTheCameraProjectsIt) {
  PhotographerOptions options = Small(1);
  options.elevations_deg = {20};
  options.width = 480, options.height = 360;
  options.k1 = -0.25, options.k2 = 0.1,
  options.p1 = 0.002;  // strong, so that a wrong model is noticed
  options.noise = options.gloss = options.vignetting = 0;
  options.supersampling = 4;
  // Off the axis, where distortion matters, and facing the camera, so that the spot's outline is
  // centred on it.
  const Vector3d ball(0.05, 0, 0.06);
  World world = SpottedBall(ball, ball + Vector3d(0, -0.05, 0));
  const Vector3d eye = Photographer(world, world.poses[0], options).ViewAt(0).Center();
  const Vector3d spot = ball + 0.05 * (eye - ball).normalized();
  world = SpottedBall(ball, spot);
  const SyntheticView photograph = Photographer(world, world.poses[0], options).Take(0);
  ASSERT_LT((photograph.view.Center() - eye).norm(), 1e-12);
  Vector2d sum = Vector2d::Zero();
  int count = 0;
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x) {
      const std::uint8_t* p = photograph.image.at(x, y);
      if (p[0] < 1.8 * p[1]) continue;
      sum += Vector2d(x + 0.5, y + 0.5);
      ++count;
    }
  ASSERT_GT(count, 100);
  const Vector2d offset = sum / count - photograph.view.Project(spot);
  EXPECT_LT(offset.norm(), 0.12)
      << offset.transpose();  // the spot has about 400 pixels, counted whole
  Camera pinhole = photograph.view.camera;
  pinhole.k1 = pinhole.k2 = pinhole.p1 = pinhole.p2 = 0;
  EXPECT_GT(
      (pinhole.Project(photograph.view.camera_from_world * spot) - photograph.view.Project(spot))
          .norm(),
      0.3);  // a wrong distortion would be noticed
}

TEST(Photographer, MaskIsTheSilhouette) {
  const Photographer photographer(Creature(), Creature().PoseNamed("bent"), Small());
  const Mesh& surface = photographer.surface();
  const RayScene scene(surface.points, surface.faces);
  for (int i = 0; i < photographer.view_count(); ++i) {
    const SyntheticView photograph = photographer.Take(i);
    const Raster raster = Rasterize(surface, scene, photograph.view);
    int mask_pixels = 0, different = 0;
    for (std::size_t p = 0; p < photograph.mask.data.size(); ++p) {
      mask_pixels += photograph.mask.data[p] > 0;
      different += (photograph.mask.data[p] > 0) != (raster.face.data[p] >= 0);
    }
    EXPECT_GT(mask_pixels, 3000);
    // "Half of the pixel covered" and "centre covered" differ only at the edge: about 600 pixels
    // here.
    EXPECT_LT(different, 0.02 * mask_pixels) << "view " << i;
  }
}

TEST(Photographer, CharacterFillsTheWantedShareAndStaysInside) {
  PhotographerOptions options = Small(8);
  options.fill = 0.8;
  options.aim_jitter = 0;
  const Photographer photographer(Creature(), Creature().PoseNamed("rest"), options);
  double reach = 0;
  for (int i = 0; i < photographer.view_count(); ++i)
    for (Eigen::Index v = 0; v < photographer.surface().points.rows(); v += 3) {
      const Vector2d pixel = photographer.ViewAt(i).Project(photographer.surface().points.row(v));
      reach = std::max({reach, std::abs(pixel[0] / 120 - 1), std::abs(pixel[1] / 90 - 1)});
    }
  EXPECT_NEAR(reach, 0.8, 0.06);
}

TEST(Photographer, SameBitsAtOneAndManyThreads) {
  SetThreadCount(1);
  const SyntheticView one = Photographer(Creature(), Creature().PoseNamed("rest"), Small()).Take(2);
  SetThreadCount(4);
  const SyntheticView many =
      Photographer(Creature(), Creature().PoseNamed("rest"), Small()).Take(2);
  SetThreadCount(0);
  EXPECT_EQ(one.image.data, many.image.data);
  EXPECT_EQ(one.mask.data, many.mask.data);
}

TEST(Photographer, BackgroundIsStaticAndEqualsTheCleanPlate) {
  PhotographerOptions options = Small();
  options.noise = 0;
  options.blur_px = 0;
  options.shadows = false;
  const Photographer photographer(Creature(), Creature().PoseNamed("rest"), options);
  const Image8 empty = photographer.CleanPlate();
  for (const int i : {0, 3}) {
    const SyntheticView photograph = photographer.Take(i);
    int compared = 0;
    for (int y = 0; y < options.height; ++y)
      for (int x = 0; x < options.width; ++x) {
        bool clear = true;  // pixels at the silhouette are mixed
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx)
            clear &= *photograph.mask.at(std::clamp(x + dx, 0, options.width - 1),
                                         std::clamp(y + dy, 0, options.height - 1)) == 0;
        if (!clear) continue;
        ++compared;
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(photograph.image.at(x, y)[c], empty.at(x, y)[c]) << x << " " << y;
      }
    EXPECT_GT(compared, options.width * options.height / 2);
  }
}

TEST(Photographer, ShadowFallsAwayFromTheLamp) {
  PhotographerOptions options = Small();
  options.noise = 0;
  options.table_shadow = 1;
  const Photographer photographer(Creature(), Creature().PoseNamed("rest"), options);
  const Image8 empty = photographer.CleanPlate();
  const SyntheticView photograph = photographer.Take(0);
  double left = 0, right = 0;
  for (int y = options.height / 2; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x)
      if (!*photograph.mask.at(x, y))
        (x < options.width / 2 ? left : right) += empty.at(x, y)[1] - photograph.image.at(x, y)[1];
  EXPECT_GT(right, 2 * std::max(left, 1.0));  // the lamp is to the left of the camera
}

TEST(Photographer, NoiseAndVignettingAreAsAsked) {
  PhotographerOptions options = Small();
  options.background = "plain";
  options.blur_px = 0;
  options.vignetting = 0;
  const Image8 noisy = Photographer(Creature(), Creature().PoseNamed("rest"), options).CleanPlate();
  double sum = 0, squares = 0;
  const double count = static_cast<double>(noisy.width) * noisy.height;
  for (int i = 0; i < noisy.width * noisy.height; ++i) {
    const double v = noisy.data[3 * i + 1];
    sum += v, squares += v * v;
  }
  // Linear 0.495 has sigma sqrt(1.2e-4 * 0.495 + 4e-6) = 0.0080; the slope of sRGB there is 0.439 *
  // 0.495^(-0.583) = 0.661; plus rounding.
  const double expected = std::sqrt(std::pow(255 * 0.661 * 0.0080, 2) + 1.0 / 12);
  EXPECT_NEAR(std::sqrt(squares / count - std::pow(sum / count, 2)), expected, 0.1 * expected);

  options.noise = 0;
  options.vignetting = 0.3;
  const Image8 dark = Photographer(Creature(), Creature().PoseNamed("rest"), options).CleanPlate();
  const auto linear = [](std::uint8_t v) { return std::pow((v / 255.0 + 0.055) / 1.055, 2.4); };
  EXPECT_NEAR(linear(dark.at(0, 0)[1]) / linear(dark.at(dark.width / 2, dark.height / 2)[1]), 0.7,
              0.02);
}

TEST(TruthScene, PointsProjectIntoTheMasksOfTheViewsThatSeeThem) {
  const Pose& pose = Creature().PoseNamed("rest");
  const std::vector<SyntheticView> photographs = Photograph(Creature(), pose, Small(6));
  const Scene scene = TruthScene(Creature(), pose, photographs, 500);
  ASSERT_GT(scene.points.size(), 200u);
  int inside = 0, total = 0;
  for (const SparsePoint& point : scene.points)
    for (const int v : point.views) {
      const Vector2d pixel = scene.views[v].Project(point.position);
      inside +=
          *photographs[v].mask.at(static_cast<int>(pixel[0]), static_cast<int>(pixel[1])) == 255;
      ++total;
    }
  EXPECT_GT(
      inside,
      0.99 * total);  // a point at the silhouette may lie in a pixel that is less than half covered
}

}  // namespace keypose::synth::photographer_test
