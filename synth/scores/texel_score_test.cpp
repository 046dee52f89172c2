#include "synth/scores/texel_score.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::synth::texel_score_test {

// A flat square of side 1 with n x n cells that fills the whole texture.
Mesh Sheet(int n) {
  Mesh mesh;
  mesh.points.resize((n + 1) * (n + 1), 3);
  mesh.uvs.resize((n + 1) * (n + 1), 2);
  mesh.faces.resize(2 * n * n, 3);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      mesh.points.row(j * (n + 1) + i) << static_cast<double>(i) / n, static_cast<double>(j) / n, 0;
      mesh.uvs.row(j * (n + 1) + i) << static_cast<double>(i) / n, static_cast<double>(j) / n;
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.faces.row(2 * (j * n + i)) << a, b, d;
      mesh.faces.row(2 * (j * n + i) + 1) << a, d, c;
    }
  mesh.uv_faces = mesh.faces;
  return mesh;
}

// The sheet of pose B stands upright.
PointsX3 Upright(const PointsX3& points) {
  PointsX3 out = points;
  out.col(2) = points.col(1);
  out.col(1).setConstant(3);
  return out;
}

struct World {
  Mesh truth_a = Sheet(8), truth_b = Sheet(8), mesh = Sheet(5);
  PointsX3 registered = Upright(mesh.points);
  Image8 texture_a{40, 40, 3, 100}, texture_b{40, 40, 3, 100};
  World() { truth_b.points = Upright(truth_a.points); }
  TexelScore Score() const {
    return ScoreTexels(truth_a, truth_b, mesh, registered, texture_a, texture_b);
  }
};

TEST(ScoreTexels, ExactRegistrationShowsTheSameSpots) {
  const TexelScore score = World().Score();
  EXPECT_EQ(score.texels, 1600);
  EXPECT_LT(score.max, 1e-12);
  EXPECT_NEAR(score.texel, 1.0 / 40 / std::sqrt(2.0), 1e-12);
  EXPECT_EQ(score.mean_difference, 0);
  EXPECT_EQ(score.psnr_db, 99);
}

TEST(ScoreTexels, ASlideAlongTheClayIsMeasuredOnTheClay) {
  World world;
  world.registered.col(2).array() *= 0.9;  // texels at height h show the clay at height 0.9 h
  const TexelScore score = world.Score();
  EXPECT_NEAR(score.mean, 0.05 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(score.max, 0.1 * (1 - 0.5 / 40) / std::sqrt(2.0), 1e-9);
}

TEST(ScoreTexels, ColoursOfTheSameTexelAreCompared) {
  World world;
  world.texture_b = Image8(40, 40, 3, 80);
  EXPECT_NEAR(world.Score().mean_difference, 20, 1e-12);
  EXPECT_NEAR(world.Score().psnr_db, 20 * std::log10(255.0 / 20), 1e-9);
  EXPECT_EQ(world.Score().psnr_gain_db, 99);  // the difference is light, not clay
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 20; ++x) world.texture_b.at(x, y)[1] = 120;
  EXPECT_LT(world.Score().psnr_gain_db, 40);
}

TEST(ScoreTexels, RowsOfTheTextureRunDownwards) {
  World world;
  world.mesh.faces.conservativeResize(10, 3);  // the lowest row of cells: v below 0.2
  world.mesh.uv_faces.conservativeResize(10, 3);
  for (int x = 0; x < 40; ++x) world.texture_b.at(x, 39)[0] = 255;
  const TexelScore score = world.Score();
  EXPECT_EQ(score.texels, 320);
  EXPECT_NEAR(score.mean_difference, 155.0 / 3 / 8, 1e-9);
}

TEST(ScoreTexels, SameBitsForAnyThreadCount) {
  World world;
  world.registered.col(2).array() *= 0.97;
  SetThreadCount(1);
  const TexelScore one = world.Score();
  SetThreadCount(3);
  const TexelScore three = world.Score();
  SetThreadCount(0);
  EXPECT_EQ(one.mean, three.mean);
  EXPECT_EQ(one.p95, three.p95);
}

TEST(ScoreTexels, WhatDoesNotBelongTogetherThrowsInputError) {
  World world;
  EXPECT_THROW(ScoreTexels(world.truth_a, Sheet(3), world.mesh, world.registered, world.texture_a,
                           world.texture_b),
               InputError);
  EXPECT_THROW(ScoreTexels(world.truth_a, world.truth_b, world.mesh, world.registered.topRows(4),
                           world.texture_a, world.texture_b),
               InputError);
  EXPECT_THROW(ScoreTexels(world.truth_a, world.truth_b, world.mesh, world.registered,
                           world.texture_a, Image8(20, 40, 3)),
               InputError);
  Mesh bare = world.mesh;
  bare.uvs.resize(0, 2);
  EXPECT_THROW(ScoreTexels(world.truth_a, world.truth_b, bare, world.registered, world.texture_a,
                           world.texture_b),
               InputError);
  Mesh aside = world.mesh;
  aside.uvs.array() += 5;
  EXPECT_THROW(ScoreTexels(world.truth_a, world.truth_b, aside, world.registered, world.texture_a,
                           world.texture_b),
               InputError);
}

}  // namespace keypose::synth::texel_score_test
