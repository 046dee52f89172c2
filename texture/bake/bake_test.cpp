#include "texture/bake/bake.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::bake_test {

TEST(Bake, PaintedSphereComesBack) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  const BakeResult result = BakeAll(mesh, views, SharedPhotographs(false));
  EXPECT_EQ(result.unseen_texels(), 0);
  EXPECT_GT(result.mean_views_per_texel, 4);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Smooth), 42);
  for (const ViewQuality& q : result.quality) {
    EXPECT_TRUE(q.used);
    EXPECT_GT(q.pixels, 1000);
    EXPECT_GT(q.psnr_db, 42);
  }
}

TEST(Bake, CheckerComesBack) {
  const Mesh mesh = PatchSphere(24);
  const std::vector<View> views = AllRound(300);
  BakeOptions options = Small();
  options.texture_size = 512;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Checker), options);
  // A texel is a square with the edge through it: compared with the mean of the paint over the
  // square there must be no error. The square's middle has one colour or the other; away from edges
  // the two comparisons are equal.
  EXPECT_GT(FootprintPsnrAgainst(mesh, result.texture, Checker, 1), 41);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Checker), 34);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Checker, AwayFromCheckerEdges), 60);
}

/// The light of four of 255 levels, from below to above.
Vector3f FaintRamp(const Vector3d& x, const Vector3d&) {
  return Vector3f::Constant(0.13f + 0.006f * static_cast<float>(x.z()));
}

/// Levels of 65535 between the texture in linear light and the ramp, inside of triangles, and how
/// many different ones the texture has.
struct RampError {
  double largest = 0, mean = 0;
  std::set<int> levels;
};
RampError ErrorOfRamp(const Mesh& mesh, const ImageF& linear) {
  const Atlas atlas = RasterizeAtlas(mesh, linear.width);
  RampError error;
  int texels = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    const Vector3d w = atlas.Weights(texel).cast<double>();
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += w[k] * mesh.points.row(mesh.faces(atlas.face[texel], k)).transpose();
    const int level = Srgb16Of(linear.data[3 * texel + 1]);
    const double off = std::abs(level - Srgb16Of(FaintRamp(x, x)[1]));
    error.levels.insert(level);
    error.largest = std::max(error.largest, off);
    error.mean += off;
    ++texels;
  }
  error.mean /= texels;
  return error;
}

TEST(Bake, LevelsBetweenThoseOfEightBitsComeFromPhotographsOfSixteen) {
  const Mesh mesh = PatchSphere(8);
  const std::vector<View> views = AllRound(120, 6);
  BakeOptions options = Small();
  options.texture_size = 256;
  const auto error = [&](bool deep) {
    return ErrorOfRamp(mesh,
                       BakeAll(mesh, views, Shoot(mesh, views, FaintRamp, deep), options).linear);
  };
  const RampError deep = error(true), eight = error(false);
  // Where faces meet, a pixel's mean over the edge is not the ramp at its centre.
  EXPECT_LE(deep.largest, 8);
  EXPECT_LT(deep.mean, 1.5);
  EXPECT_GT(deep.levels.size(), 1000u) << "of the 1130 that the ramp has";
  EXPECT_GT(eight.largest, 100) << "half a step of 8 bits is 128, or this test shows nothing";
  EXPECT_GT(eight.mean, 30);
}

TEST(Bake, PhotographsOfBothDepthsAreOfOneColour) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  std::vector<Photograph> photographs = SharedPhotographs(false);
  for (std::size_t v = 0; v < views.size(); v += 2) {
    Photograph& photograph = photographs[v];
    photograph.deep = Image16(photograph.image.width, photograph.image.height, 3);
    for (std::size_t i = 0; i < photograph.image.data.size(); ++i)
      photograph.deep.data[i] = static_cast<std::uint16_t>(257 * photograph.image.data[i]);
    photograph.image = {};
  }
  const BakeResult result = BakeAll(mesh, views, photographs);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Smooth), 42);
  for (const Vector3f& gain : result.gains)
    EXPECT_LT((gain - Vector3f::Ones()).cwiseAbs().maxCoeff(), 0.01f);
}

/// Mean squared difference of neighbouring texels of one chart: lower for a blurred edge than for a
/// sharp one.
double EdgeEnergy(const Mesh& mesh, const Image8& texture) {
  const Atlas atlas = RasterizeAtlas(mesh, texture.width);
  double sum = 0, count = 0;
  for (std::size_t i = 1; i < atlas.face.size(); ++i)
    if (atlas.inside[i] && atlas.inside[i - 1])
      sum += std::pow(texture.data[3 * i] - texture.data[3 * i - 3], 2), ++count;
  return sum / count;
}

TEST(Bake, DetailStaysSharpWhenCamerasAreAPixelOff) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> truth = AllRound(240);
  const std::vector<Photograph>& photographs = SharedPhotographs(true);
  std::vector<View> off = truth;
  for (std::size_t v = 0; v < off.size(); ++v) {
    off[v].camera.cx += 1.3 * std::sin(5.0 * static_cast<double>(v));
    off[v].camera.cy += 1.3 * std::cos(7.0 * static_cast<double>(v));
  }
  const double exact = EdgeEnergy(mesh, BakeAll(mesh, truth, photographs).texture);
  EXPECT_GT(EdgeEnergy(mesh, BakeAll(mesh, off, photographs).texture),
            0.85 * exact);  // the mean of these views has 0.6 of it
}

TEST(Bake, PhotographsFarFinerThanTheAtlasAreAveragedNotAliased) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(360, 4);
  const Paint noisy = [](const Vector3d& x, const Vector3d&) {
    const float s = static_cast<float>(0.3 + 0.25 * std::sin(120 * x.x()) * std::sin(120 * x.y()) *
                                                 std::sin(120 * x.z()));
    return Vector3f(s, s, s);
  };
  BakeOptions options = Small();
  options.texture_size = 64;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, noisy), options);
  const Paint mean = [](const Vector3d&, const Vector3d&) { return Vector3f(0.3f, 0.3f, 0.3f); };
  EXPECT_GT(PsnrAgainst(mesh, result.texture, mean), 27);  // the noise itself is at 19 dB
}

TEST(Bake, OccluderIsNotPaintedOnWhatItHides) {
  Mesh mesh = PatchSphere(12);
  Mesh ball = PatchSphere(8, 0.3, {1.6, 0, 0});
  const int first = mesh.vertex_count(), first_uv = static_cast<int>(mesh.uvs.rows()),
            first_face = mesh.face_count();
  const auto append = [](auto& to, const auto& rows) {
    to.conservativeResize(to.rows() + rows.rows(), to.cols());
    to.bottomRows(rows.rows()) = rows;
  };
  mesh.uvs.col(0) *= 0.5;
  ball.uvs.col(0) = ball.uvs.col(0) * 0.5 + UvsX2::Constant(ball.uvs.rows(), 2, 0.5).col(0);
  append(mesh.points, ball.points);
  append(mesh.uvs, ball.uvs);
  append(mesh.faces, FacesX3((ball.faces.array() + first).matrix()));
  append(mesh.uv_faces, FacesX3((ball.uv_faces.array() + first_uv).matrix()));
  const Paint paint = [](const Vector3d& x, const Vector3d&) {
    return x.norm() < 1.1 ? Vector3f(0.1f, 0.5f, 0.1f) : Vector3f(0.6f, 0.05f, 0.05f);
  };
  const std::vector<View> views = AllRound(240);
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, paint));
  const Atlas atlas = RasterizeAtlas(mesh, 384);
  int wrong = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    const bool is_ball = atlas.face[texel] >= first_face;
    wrong += (result.texture.data[3 * texel] > result.texture.data[3 * texel + 1]) != is_ball;
  }
  EXPECT_EQ(wrong, 0);
  EXPECT_LT(result.unseen_texels(), result.texels / 10);
}

TEST(Bake, WanderingHighlightIsAbsentFromTheMap) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(180, 12);
  // The lamp is above the camera, so its reflection moves over the sphere with the view.
  const Paint glossy = [](const Vector3d& x, const Vector3d& eye) {
    const Vector3d n = x.normalized(),
                   half = ((eye + Vector3d(0, 0, 2)).normalized() + eye.normalized()).normalized();
    return (Smooth(x, eye) + Vector3f::Constant(n.dot(half) > 0.985 ? 0.6f : 0.0f))
        .cwiseMin(1.0f)
        .eval();
  };
  const std::vector<Photograph> photographs = Shoot(mesh, views, glossy);
  const BakeResult robust = BakeAll(mesh, views, photographs);
  BakeOptions trusting = Small();
  trusting.strictness = 0;
  EXPECT_GT(PsnrAgainst(mesh, robust.texture, Smooth), 32);
  EXPECT_LT(PsnrAgainst(mesh, BakeAll(mesh, views, photographs, trusting).texture, Smooth), 30);
}

TEST(Bake, BackgroundBehindOneWrongMaskIsOutvoted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  std::vector<Photograph> photographs = SharedPhotographs(false);
  for (int y = 90; y < 150; ++y)
    for (int x = 130; x < 190; ++x)
      photographs[3].image.at(x, y)[0] = photographs[3].image.at(x, y)[1] = 240;
  EXPECT_GT(PsnrAgainst(mesh, BakeAll(mesh, views, photographs).texture, Smooth), 36);
}

TEST(Bake, MaskedPixelsAreNotPainted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = {At({4, 0, 0}, 240)};
  std::vector<Photograph> photographs = Shoot(
      mesh, views, [](const Vector3d&, const Vector3d&) { return Vector3f(0.2f, 0.4f, 0.2f); });
  const BakeResult before = BakeAll(mesh, views, photographs);
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 160; ++x) {
      *photographs[0].mask.at(x, y) = 0;
      photographs[0].image.at(x, y)[0] = 255;
    }
  const BakeResult after = BakeAll(mesh, views, photographs);
  EXPECT_NEAR(static_cast<double>(after.seen_texels) / static_cast<double>(before.seen_texels), 0.5,
              0.06);
  for (std::size_t i = 0; i < after.texture.data.size(); i += 3)
    ASSERT_LT(after.texture.data[i], after.texture.data[i + 1]);
}

TEST(Bake, UnseenTexelsAreCountedAndInpaintedFromWhatTheyTouch) {
  const Mesh mesh = PatchSphere(16);
  const std::vector<View> views = {At({4, 0, 0}, 300)};
  // Red above, blue below: the unseen back must follow, smoothly.
  const Paint halves = [](const Vector3d& x, const Vector3d&) {
    return x.z() > 0 ? Vector3f(0.5f, 0.1f, 0.1f) : Vector3f(0.1f, 0.1f, 0.5f);
  };
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, halves));
  // Seen where the angle to the eye is below max_angle: cos(angle) = (4 cos t - 1) / sqrt(17 - 8
  // cos t) = cos 75.
  double cap = 0;
  for (double t = 0; t < M_PI; t += 1e-4)
    if ((4 * std::cos(t) - 1) / std::sqrt(17 - 8 * std::cos(t)) > std::cos(75 * M_PI / 180))
      cap = t;
  const double seen = static_cast<double>(result.seen_texels) / static_cast<double>(result.texels);
  EXPECT_NEAR(seen, (1 - std::cos(cap)) / 2, 0.03);
  EXPECT_EQ(result.unseen_texels() + result.seen_texels, result.texels);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, halves,
                        [](const Vector3d& x) { return x.x() < 0.1 && std::abs(x.z()) > 0.6; }),
            14);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, halves,
                        [](const Vector3d& x) { return x.x() > 0.55 && std::abs(x.z()) > 0.1; }),
            38);
  // At the border of the seen part, with one photograph's edge only, texels are mixed with the
  // colours around: this blurs within a face.
  EXPECT_GT(PsnrAgainst(mesh, result.texture, halves,
                        [](const Vector3d& x) { return x.x() > 0.4 && std::abs(x.z()) > 0.1; }),
            34);
}

TEST(Bake, GuttersContinueTheChart) {
  const Mesh mesh = PatchSphere(8);
  const std::vector<View> views = AllRound(160);
  BakeOptions options = Small();
  options.gutter = 8;
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Smooth), options);
  const Atlas atlas = RasterizeAtlas(mesh, 384);
  for (int y = 20; y < 380; ++y)
    for (int x = 20; x < 380; ++x) {
      if (atlas.face[y * 384 + x] >= 0 || atlas.face[y * 384 + x - 4] < 0)
        continue;  // four texels right of a chart
      for (int k = 0; k < 3; ++k)
        ASSERT_NEAR(result.texture.at(x, y)[k], result.texture.at(x - 4, y)[k], 14)
            << x << " " << y;
    }
}

TEST(Bake, HeldOutPhotographsArePredictedAndStillPainted) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  const std::vector<Photograph>& photographs = SharedPhotographs(false);
  const BakeResult result = BakeAll(mesh, views, photographs);
  int held_out = 0;
  for (const ViewQuality& q : result.quality) {
    held_out += q.held_out;
    EXPECT_TRUE(q.used);
    EXPECT_GT(q.ssim, 0.98);
    if (!q.held_out) continue;
    EXPECT_GT(q.held_out_psnr_db, 38);
    EXPECT_LT(q.held_out_psnr_db, q.psnr_db);
    EXPECT_GT(q.held_out_psnr_gain_db, 38);
    EXPECT_GT(q.held_out_ssim, 0.97);
  }
  EXPECT_EQ(held_out, 3);
  BakeOptions options = Small();
  options.leave_out = true;
  const BakeResult without = BakeAll(mesh, views, photographs, options);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_NE(without.quality[v].held_out, without.quality[v].used);
    // Held-out photographs must not be used for the prediction: both ways of measuring paint the
    // same texture.
    if (without.quality[v].held_out) {
      EXPECT_EQ(without.quality[v].held_out_psnr_db, result.quality[v].held_out_psnr_db);
    }
  }
  const std::vector<View> few(views.begin(), views.begin() + 8);
  for (const ViewQuality& q : BakeAll(mesh, few, photographs).quality) EXPECT_FALSE(q.held_out);
}

TEST(Bake, ATexelIsTheSameSpotInEveryPose) {
  const Mesh rest = PatchSphere(16);
  // The other pose: same vertices, faces and layout, bent and twisted. The paint is fixed to the
  // clay, so it is looked up at rest.
  Mesh bent = rest;
  for (int v = 0; v < bent.vertex_count(); ++v) {
    const Vector3d x = rest.points.row(v);
    const double turn = 0.5 * x.z();
    bent.points.row(v) << x.x() * std::cos(turn) - x.y() * std::sin(turn) + 0.3 * x.z() * x.z(),
        x.x() * std::sin(turn) + x.y() * std::cos(turn), 1.15 * x.z();
  }
  const std::vector<View> views = AllRound(180);
  const RayScene bent_scene(bent.points, bent.faces);
  const Paint on_bent = [&](const Vector3d& x, const Vector3d& eye) {
    const RayScene::Foot foot = bent_scene.ClosestPoint(x);
    Vector3d at_rest = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      at_rest += foot.barycentric[k] * rest.points.row(rest.faces(foot.face, k)).transpose();
    return Smooth(at_rest, eye);
  };
  const BakeResult a = BakeAll(rest, views, Shoot(rest, views, Smooth)),
                   b = BakeAll(bent, views, Shoot(bent, views, on_bent));
  double sum = 0;
  for (std::size_t i = 0; i < a.texture.data.size(); ++i)
    sum += std::pow(a.texture.data[i] - static_cast<double>(b.texture.data[i]), 2);
  EXPECT_GT(Psnr(sum, static_cast<double>(a.texture.data.size())), 38);
}

TEST(Bake, SameBitsAtOneAndTwoThreads) {
  const Mesh mesh = PatchSphere(8);
  const std::vector<View> views = AllRound(120);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Checker);
  SetThreadCount(1);
  const BakeResult one = BakeAll(mesh, views, photographs);
  SetThreadCount(2);
  const BakeResult two = BakeAll(mesh, views, photographs);
  SetThreadCount(0);
  EXPECT_EQ(one.texture.data, two.texture.data);
  EXPECT_EQ(one.seen_texels, two.seen_texels);
  for (std::size_t v = 0; v < views.size(); ++v) {
    EXPECT_EQ(one.gains[v], two.gains[v]);
    EXPECT_EQ(one.quality[v].psnr_db, two.quality[v].psnr_db);
  }
}

template <class Function>
std::string InputErrorOf(const Function& function) {
  try {
    function();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no InputError";
}

TEST(Bake, AWiderGuardLeavesMoreTexelsUnseen) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240, 3);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  BakeOptions wide = Small();
  wide.edge_guard = 60;
  EXPECT_GT(BakeAll(mesh, views, photographs, wide).unseen_texels(),
            BakeAll(mesh, views, photographs, Small()).unseen_texels());
}

TEST(Bake, ExposuresAreEvenedOnlyWhereAsked) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  std::vector<Photograph> photographs = SharedPhotographs(false);
  for (std::size_t v = 0; v < photographs.size(); v += 2)
    for (std::uint8_t& value : photographs[v].image.data) value = value * 9 / 10;
  BakeOptions as_they_are = Small();
  as_they_are.harmonize = false;
  const BakeResult even = BakeAll(mesh, views, photographs, Small()),
                   uneven = BakeAll(mesh, views, photographs, as_they_are);
  const auto spread = [](const BakeResult& result) {
    double low = 1, high = 1;
    for (const Vector3f& gain : result.gains) {
      low = std::min<double>(low, gain.minCoeff());
      high = std::max<double>(high, gain.maxCoeff());
    }
    return high / low;
  };
  EXPECT_GT(spread(even), 1.15) << "the darker half of the views is brightened";
  EXPECT_EQ(spread(uneven), 1);
}

// A bright spot that wanders with the camera is detail of single photographs. With a large step it
// is painted from the photograph that sees a face best, with none it is left to the mean of all.
TEST(Bake, LightAndDetailComeFromWhereTheOptionsSay) {
  const Mesh mesh = PatchSphere(12);
  const std::vector<View> views = AllRound(240);
  const std::vector<Photograph> photographs =
      Shoot(mesh, views, [](const Vector3d& x, const Vector3d& eye) {
        const double facing = x.normalized().dot(eye.normalized());
        return Vector3f::Constant(0.2f + 0.3f * static_cast<float>(std::pow(facing, 40)));
      });
  const auto energy = [&](const BakeOptions& options) {
    return EdgeEnergy(mesh, BakeAll(mesh, views, photographs, options).texture);
  };
  BakeOptions options = Small();
  options.detail_step = 10;
  const double step = energy(options);
  options.detail_step = 0;
  EXPECT_LT(energy(options), step);
  const Image8 plain = BakeAll(mesh, views, photographs, Small()).texture;
  options = Small();
  options.common_light = false;
  EXPECT_GT(energy(options), EdgeEnergy(mesh, plain));
  options = Small();
  options.edge_feather = 1000;
  EXPECT_NE(BakeAll(mesh, views, photographs, options).texture.data, plain.data);
}

TEST(Bake, MeshWithoutUsableUvsIsAnInputError) {
  const std::vector<View> views = {At({4, 0, 0}, 60)};
  Mesh mesh = PatchSphere(4);
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  Mesh bare = mesh;
  bare.uvs.resize(0, 2);
  bare.uv_faces.resize(0, 3);
  EXPECT_THAT(InputErrorOf([&] { BakeAll(bare, views, photographs); }),
              ::testing::HasSubstr("no texture coordinates"));
  Mesh tiled = mesh;
  tiled.uvs(tiled.uv_faces(7, 1), 0) = 1.5;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(tiled, views, photographs); }),
              ::testing::HasSubstr("outside 0..1"));
  Mesh damaged = mesh;
  damaged.uv_faces(5, 2) = 100000;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(damaged, views, photographs); }),
              ::testing::HasSubstr("face 5"));
}

TEST(Bake, MeshOutOfEveryViewIsAnInputError) {
  const Mesh mesh = PatchSphere(4);
  std::vector<View> views = {At({4, 0, 0}, 60)};
  const std::vector<Photograph> photographs = Shoot(mesh, views, Smooth);
  Mesh away = mesh;
  away.points.col(1).array() += 50;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(away, views, photographs); }),
              ::testing::HasSubstr("none of the 1 views"));
  EXPECT_THAT(InputErrorOf([&] { BakeAll(mesh, {}, {}); }), ::testing::HasSubstr("no views"));
  views[0].camera.width = 61;
  EXPECT_THAT(InputErrorOf([&] { BakeAll(mesh, views, photographs); }),
              ::testing::HasSubstr("pixels"));
}

TEST(Bake, TexelsFarFinerThanThePhotographsAreWhatTheyWouldBeOneByOne) {
  const Mesh mesh = PatchSphere(6);
  const std::vector<View> views = AllRound(80);
  BakeOptions options = Small();
  options.texture_size = 768;
  options.hold_out = 0;
  // 20 texels per pixel: nodes. The reference is the bilinear value of the same photographs, read
  // one by one, which have 80 lines at best.
  const BakeResult result = BakeAll(mesh, views, Shoot(mesh, views, Smooth), options);
  EXPECT_GT(PsnrAgainst(mesh, result.texture, Smooth), 38);
  EXPECT_EQ(result.unseen_texels(), 0);
}

TEST(AdviseTextureSize, DoublesWithTheFocalLength) {
  const Mesh mesh = PatchSphere(12);
  std::vector<View> views = AllRound(240);
  const int size = AdviseTextureSize(mesh, views);
  // From 3 radii away a pixel is 1 / 124 of the radius. A quarter of the way round, 195 pixels, has
  // 29 % of the layout's width, 44 % of its height.
  EXPECT_EQ(size, 512);
  for (View& view : views) view.camera.fx *= 2, view.camera.fy *= 2;
  EXPECT_EQ(AdviseTextureSize(mesh, views), 2 * size);
}

}  // namespace keypose::texture::bake_test
