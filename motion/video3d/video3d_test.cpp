// Projective texturing on small worlds with known truth.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <mutex>

#include "core/numbers/parallel.h"
#include "core/pictures/image_quality.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/testing/filmed_ball.h"
#include "motion/video3d/free_view.h"
#include "motion/video3d/texture_sequence.h"

namespace keypose::motion::video3d_test {

using Eigen::Vector3d;
using Eigen::Vector3f;

View Straight(double distance, int size) {
  View view;
  view.camera_from_world = LookAt({0, -distance, 0}, Vector3d::Zero());
  Camera& c = view.camera;
  c.width = c.height = size;
  c.fx = c.fy = size, c.cx = c.cy = 0.5 * size;
  return view;
}

/// A square across the view at depth y, facing -y.
Mesh Wall(double y, double half) {
  Mesh wall;
  wall.points.resize(4, 3);
  wall.points << -half, y, -half, half, y, -half, half, y, half, -half, y, half;
  wall.faces.resize(2, 3);
  wall.faces << 0, 1, 2, 0, 2, 3;
  return wall;
}

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both = a;
  both.points.conservativeResize(a.points.rows() + b.points.rows(), 3);
  both.points.bottomRows(b.points.rows()) = b.points;
  both.faces.conservativeResize(a.faces.rows() + b.faces.rows(), 3);
  both.faces.bottomRows(b.faces.rows()) = b.faces.array() + a.vertex_count();
  return both;
}

TEST(DepthView, NearestSurfaceCounts) {
  const Mesh scene = Joined(Wall(0, 0.5), Wall(-1, 0.1));
  const DepthView depth = MakeDepthView(scene.points, scene.faces, Straight(4, 200));
  EXPECT_NEAR(depth.At(100, 100), 1.0 / 3, 1e-6);  // the small wall, a metre nearer
  EXPECT_NEAR(depth.At(85, 100), 1.0 / 4, 1e-6);
  EXPECT_EQ(depth.box.x0 < 100 && depth.box.x1 < 130, true);
}

TEST(DepthView, MeshBehindTheCameraIsNotSeen) {
  const Mesh wall = Wall(0, 0.5);
  EXPECT_TRUE(MakeDepthView(wall.points, wall.faces, Straight(-4, 100)).box.empty() ||
              Straight(-4, 100).Center().y() > 0);
  View away = Straight(4, 100);
  away.camera_from_world = LookAt({0, -4, 0}, {0, -8, 0});
  EXPECT_TRUE(MakeDepthView(wall.points, wall.faces, away).box.empty());
}

TEST(DistanceToEdges, IsChamferDistance) {
  Image8 edges(9, 9, 1, 0);
  *edges.at(4, 4) = 1;
  const ImageF d = DistanceToEdges(edges, 20);
  EXPECT_EQ(*d.at(4, 4), 0);
  EXPECT_EQ(*d.at(7, 4), 3);
  EXPECT_NEAR(*d.at(6, 6), 2 * std::sqrt(2.0), 1e-6);
  EXPECT_EQ(*DistanceToEdges(edges, 2).at(0, 0), 2);
}

struct SeenWalls : ::testing::Test {
  Mesh scene = Joined(Wall(0, 1), Wall(-1, 0.2));
  View view = Straight(4, 200);
  Image8 picture{200, 200, 3, 128};
  Vector3f normal{0, -1, 0};
  FilmedView Film(const Image8& mask) const {
    return FilmedView(view, picture, mask, scene.points, scene.faces, {2, 4});
  }
};

TEST_F(SeenWalls, HiddenPlacesAndEdgesAreNotTrusted) {
  const FilmedView film = Film({});
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 1);
  EXPECT_NEAR(film.See({0.8f, 0, 0}, normal).color[0], 0.2158f, 1e-3f);  // of sRGB 128
  EXPECT_EQ(film.See({0, 0, 0}, normal).trust, 0) << "behind the small wall";
  EXPECT_EQ(film.See({0, -1, 0}, normal).trust, 1);
  EXPECT_EQ(film.See({0.195f, -1, 0}, normal).trust, 0) << "at the small wall's edge";
  const float near_edge = film.See({0.2f * 4 / 3 + 0.07f, 0, 0}, normal).trust;
  EXPECT_GT(near_edge, 0) << "feathered";
  EXPECT_LT(near_edge, 1);
  EXPECT_EQ(film.See({0.8f, 0, 0}, -normal).facing, 0);
}

TEST_F(SeenWalls, MaskHidesWhatItDoesNotHave) {
  Image8 mask(200, 200, 1, 255);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 80; ++x) *mask.at(x, y) = 0;
  const FilmedView film = Film(mask);
  EXPECT_EQ(film.See({-0.8f, 0, 0}, normal).trust, 0);
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 1);
  EXPECT_LT(film.covered_by_mask(), 0.75);
}

TEST_F(SeenWalls, NoPictureSeesNothing) {
  const FilmedView film(view, {}, {}, scene.points, scene.faces, {});
  EXPECT_TRUE(film.sees_nothing());
  EXPECT_EQ(film.See({0.8f, 0, 0}, normal).trust, 0);
}

TEST(LevelExposures, FindsGainsAndIgnoresWhatDisagrees) {
  std::vector<ColorPair> pairs;
  for (int i = 0; i < 300; ++i) {
    const Vector3f color = Vector3f(0.2f, 0.3f, 0.25f) * (1 + 0.4f * std::sin(0.7f * i));
    // Camera 1 takes 1.2 times the light of camera 0; every tenth pair shows a highlight.
    pairs.push_back({0, 1, color, (i % 10 ? 1.2f : 2.6f) * color, 1});
  }
  const CameraExposures exposure = LevelExposures(pairs, 3);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(exposure.gains[0][c] / exposure.gains[1][c], 1.2, 0.012);
    EXPECT_NEAR(exposure.gains[0][c] * exposure.gains[1][c], 1, 1e-3);
    EXPECT_EQ(exposure.gains[2][c], 1);
  }
  EXPECT_TRUE(exposure.compared[0] && exposure.compared[1]);
  EXPECT_FALSE(exposure.compared[2]);
}

/// One texel a vertex would do; here each face has some.
struct Ball : ::testing::Test {
  BallWorld world{6};
  Atlas atlas = RasterizeAtlas(world.mesh, 512);
  SurfaceTexels texels = ListTexels(atlas);
  std::vector<Vector3f> even = std::vector<Vector3f>(6, Vector3f::Ones());

  std::vector<FilmedView> Views(int frame, int spoiled = -1) const {
    std::vector<FilmedView> views;
    const PointsX3 points = world.Points(frame);
    for (int v = 0; v < SizeOf(world.views); ++v) {
      Image8 picture = world.Picture(world.views[v], frame);
      if (v == spoiled) std::fill(picture.data.begin(), picture.data.end(), 250);
      views.emplace_back(world.views[v], picture, world.Mask(world.views[v], frame), points,
                         world.mesh.faces, FilmedViewOptions{});
    }
    return views;
  }
  /// Root of the mean square difference of well seen texels [levels].
  double Difference(const TexelColors& a, const TexelColors& b) const {
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < a.sure.size(); ++i) {
      if (a.sure[i] < 255 || b.sure[i] < 255) continue;
      for (int c = 0; c < 3; ++c) sum += std::pow(a.color[3 * i + c] - b.color[3 * i + c], 2.0);
      count += 3;
    }
    return count > 0 ? std::sqrt(sum / count) : 1e9;
  }
};

TEST_F(Ball, OneCameraThatContradictsTheOthersIsOutvoted) {
  world = BallWorld(10);
  even.assign(10, Vector3f::Ones());
  ViewBlender agreeing(world.mesh.faces, texels, 10, {0, true}),
      trusting(world.mesh.faces, texels, 10, {0, false}), clean(world.mesh.faces, texels, 10, {});
  const PointsX3 points = world.Points(0);
  const TexelColors truth = clean.Next(points, Views(0), even);
  const std::vector<FilmedView> views = Views(0, 2);
  const double with = Difference(agreeing.Next(points, views, even), truth),
               without = Difference(trusting.Next(points, views, even), truth);
  EXPECT_GT(without, 20);
  EXPECT_LT(with, 0.5 * without);
}

TEST_F(Ball, SameBitsForAnyThreadCount) {
  const PointsX3 points = world.Points(0);
  const std::vector<FilmedView> views = Views(0);
  SetThreadCount(1);
  ViewBlender one(world.mesh.faces, texels, 6, {});
  const TexelColors first = one.Next(points, views, even);
  SetThreadCount(3);
  ViewBlender many(world.mesh.faces, texels, 6, {});
  EXPECT_EQ(many.Next(points, views, even).color, first.color);
  SetThreadCount(0);
}

TEST_F(Ball, HoleTakesTheColoursOfTheFramesAroundInItsOwnLight) {
  TexelColors bright;
  bright.color.assign(3 * static_cast<std::size_t>(texels.count()), 0);
  bright.sure.assign(static_cast<std::size_t>(texels.count()), 255);
  for (std::size_t i = 0; i < bright.color.size(); ++i)
    bright.color[i] = static_cast<std::uint8_t>(100 + 60 * std::sin(0.01 * static_cast<double>(i)));
  TexelColors dark = bright;
  for (std::uint8_t& c : dark.color) c = static_cast<std::uint8_t>(std::lround(0.7 * c));
  TexelColors torn = dark;  // a cap of the ball is not seen in the dark frame
  std::vector<int> hole;
  for (int i = 0; i < texels.count(); ++i)
    if (world.mesh.points(world.mesh.faces(texels.face[i], 0), 2) > 0.6) {
      hole.push_back(i);
      torn.sure[i] = 0, torn.color[3 * i] = 255;
    }
  ASSERT_GT(hole.size(), 1000u);
  MeanTexture mean(texels);
  mean.Add(bright);
  TextureFiller filler(world.mesh, atlas, texels, mean.Completed(world.mesh, atlas, {}), {});
  const std::map<int, const TexelColors*> frames{{0, &bright}, {1, &torn}};
  const FilledTexture filled = filler.Fill(1, [&](int f) {
    const auto found = frames.find(f);
    return found == frames.end() ? nullptr : found->second;
  });
  double off = 0;
  for (const int i : hole)
    off += std::abs(filled.texture.data[3 * static_cast<std::size_t>(texels.texel[i])] -
                    static_cast<double>(dark.color[3 * static_cast<std::size_t>(i)]));
  EXPECT_LT(off / static_cast<double>(hole.size()), 5);  // of about 75; 32 if not levelled
  EXPECT_NEAR(filled.own + filled.neighbours, 1, 1e-9);
}

TEST_F(Ball, WhatNoFrameShowsIsTheTemplatesTexture) {
  TexelColors seen;
  seen.color.assign(3 * static_cast<std::size_t>(texels.count()), 60);
  seen.sure.assign(static_cast<std::size_t>(texels.count()), 255);
  for (int i = 0; i < texels.count(); ++i)
    if (world.mesh.points(world.mesh.faces(texels.face[i], 0), 2) > 0.6)
      seen.sure[static_cast<std::size_t>(i)] = 0;
  MeanTexture mean(texels);
  mean.Add(seen);
  EXPECT_LT(mean.seen(), 0.9);
  Image8 own(512, 512, 3, 120);  // twice as bright as in the films
  const TexelColors completed = mean.Completed(world.mesh, atlas, own);
  for (int i = 0; i < texels.count(); i += 97)
    EXPECT_NEAR(completed.color[3 * static_cast<std::size_t>(i)], 60, 4) << i;
}

/// Films of the ball, painted, and the held-out camera's picture of it.
struct Sequence : Ball {
  std::map<int, TexelColors> store;
  std::map<int, Image8> textures;
  std::vector<double> gains = std::vector<double>(6, 1.0);
  int ends = 1000;  // frames that camera 1 has

  SequenceReport Make(int frames, const SequenceOptions& options) {
    const SequenceInput input{
        world.mesh,
        world.views,
        frames,
        [this](int f) {
          FilmedFrame frame;
          frame.points = world.Points(f);
          for (std::size_t v = 0; v < world.views.size(); ++v) {
            const bool over = v == 1 && f >= ends;
            frame.pictures.push_back(over ? Image8() : world.Picture(world.views[v], f, gains[v]));
            frame.masks.push_back({});
          }
          return frame;
        },
        {}};
    return MakeTextures(input, options,
                        {[this](int f, const TexelColors& colors) { store[f] = colors; },
                         [this](int f) { return store.at(f); }},
                        [this](int f, const Image8& texture) {
                          static std::mutex mutex;
                          const std::lock_guard<std::mutex> lock(mutex);
                          textures[f] = texture;
                        });
  }
  /// PSNR in the held-out camera, and the share of the background's colour at the rim.
  struct Score {
    double psnr = 0, rim_psnr = 0, halo = 0;
  };
  Score HeldOut(int frame) const {
    Mesh mesh = world.mesh;
    mesh.points = world.Points(frame);
    RenderOptions look;
    look.shading = 0, look.texture = &textures.at(frame);
    const Image8 made = RenderCutout(mesh, RayScene(mesh.points, mesh.faces), world.held_out, look),
                 truth = world.Picture(world.held_out, frame),
                 mask = world.Mask(world.held_out, frame);
    Image8 outside = mask;
    for (std::uint8_t& m : outside.data) m = m ? 0 : 1;
    const ImageF inner = DistanceToEdges(outside, 10);
    double sum = 0, count = 0, rim = 0, rim_count = 0, with = 0, full = 0;
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      if (inner.data[i] < 2 || made.data[4 * i + 3] < 255) continue;
      const bool at_rim = inner.data[i] < 5;
      for (int c = 0; c < 3; ++c) {
        const double off = made.data[4 * i + c] - static_cast<double>(truth.data[3 * i + c]),
                     to_back = 255 * world.background[c] - truth.data[3 * i + c];
        sum += off * off, ++count;
        if (at_rim) rim += off * off, ++rim_count, with += off * to_back, full += to_back * to_back;
      }
    }
    return {Psnr(sum, count), Psnr(rim, rim_count), with / full};
  }
};

TEST_F(Sequence, HeldOutCameraIsPredictedWithoutARimOfBackground) {
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  ASSERT_EQ(textures.size(), 2u);
  for (const int f : {0, 1}) {
    const Score score = HeldOut(f);
    EXPECT_GT(score.psnr, 36) << f;
    EXPECT_GT(score.rim_psnr, 32) << f;
    EXPECT_LT(std::abs(score.halo), 0.01) << f;
  }
  EXPECT_GT(report.seen_ever, 0.85);  // the ball's top is not
  EXPECT_EQ(report.frames_seen, std::vector<int>(6, 2));
}

TEST_F(Sequence, ExposuresOfCamerasAreLevelled) {
  gains = {1.15, 0.9, 1.05, 0.95, 1.0, 1 / (1.15 * 0.9 * 1.05 * 0.95)};
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  for (int v = 0; v < 6; ++v)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(report.exposure.gains[v][c] * gains[v], 1, 0.015) << v << " " << c;
  const double levelled = HeldOut(1).psnr;
  EXPECT_GT(levelled, 35);
  options.level_exposure = false;
  Make(2, options);
  EXPECT_LT(HeldOut(1).psnr, levelled - 3);
}

TEST_F(Sequence, FilmThatEndsEarlyLeavesItsPartToTheOthers) {
  ends = 1;
  SequenceOptions options;
  options.texture_size = 512;
  const SequenceReport report = Make(2, options);
  EXPECT_EQ(report.frames_seen[1], 1);
  EXPECT_GT(HeldOut(1).psnr, 32);
}

TEST(AdviseSequenceSize, DoublesWithTheResolutionOfTheFilms) {
  const BallWorld small(6, 160), large(6, 640);
  const int size = AdviseSequenceSize(small.mesh, small.views);
  EXPECT_GE(size, 256);
  EXPECT_EQ(AdviseSequenceSize(large.mesh, large.views), std::min(2048, 4 * size));
}

TEST(FreeView, OrbitKeepsTheActorInThePicture) {
  const BallWorld world(3);
  std::vector<Mesh> frames(20, world.mesh);
  for (int f = 0; f < 20; ++f) frames[f].points = world.Points(f);
  const std::vector<View> views = OrbitViews(frames, {});
  ASSERT_EQ(views.size(), 20u);
  for (int f = 0; f < 20; ++f)
    for (Eigen::Index v = 0; v < frames[f].points.rows(); v += 50) {
      const Eigen::Vector2d p = views[f].Project(frames[f].points.row(v));
      EXPECT_TRUE(p.x() > 0 && p.y() > 0 && p.x() < 960 && p.y() < 720) << f;
    }
  const Vector3d a = views[0].Center(), b = views[5].Center();
  EXPECT_LT(a.y(), -1) << "begins in front";
  EXPECT_GT(b.x(), 1) << "a quarter later it stands at the side";
}

TEST(FreeView, PathGoesThroughItsKeysAndStandsAtItsEnds) {
  const std::vector<CameraKey> keys =
      ParseCameraPath(R"({"keys": [{"frame": 2, "eye": [4, 0, 1], "look_at": [0, 0, 0]},
                                   {"frame": 6, "eye": [0, 4, 1], "look_at": [0, 0, 0]},
                                   {"frame": 8, "eye": [-4, 0, 1], "look_at": [0, 0, 1],
                                    "fov_deg": 60}]})",
                      "path.json");
  const std::vector<View> views = PathViews(keys, 12, {});
  EXPECT_LT((views[6].Center() - Vector3d(0, 4, 1)).norm(), 1e-9);
  EXPECT_LT((views[0].Center() - Vector3d(4, 0, 1)).norm(), 1e-9);
  EXPECT_LT((views[11].Center() - Vector3d(-4, 0, 1)).norm(), 1e-9);
  EXPECT_NEAR(views[11].camera.fy, 360 / std::tan(30 * kDegree), 1e-9);
  EXPECT_LT((views[4].Center() - views[3].Center()).norm(), 2.5);
}

TEST(FreeView, FaultsOfAPathAreNamed) {
  for (const char* text :
       {"[]", R"({"keys": []})", R"({"keys": [{"eye": [0, 0, 0], "look_at": [1, 0, 0]}]})",
        R"({"keys": [{"frame": 0, "eye": [0, 0], "look_at": [1, 0, 0]}]})",
        R"({"keys": [{"frame": 0, "eye": [0, 0, 0], "look_at": [1, 0, 0], "fov_deg": 200}]})",
        R"({"keys": [{"frame": 1, "eye": [0, 0, 0], "look_at": [1, 0, 0]},
                     {"frame": 1, "eye": [0, 0, 0], "look_at": [1, 0, 0]}]})"})
    EXPECT_THROW(ParseCameraPath(text, "path.json"), InputError) << text;
}

}  // namespace keypose::motion::video3d_test
