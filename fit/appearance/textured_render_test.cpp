#include "fit/appearance/textured_render.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::fit::textured_render_test {

/// A unit square that faces the camera at z = 2, with its texture upright.
Mesh Square() {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << -0.5, -0.5, 2, 0.5, -0.5, 2, 0.5, 0.5, 2, -0.5, 0.5, 2;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 2, 1, 0, 3, 2;
  mesh.uvs.resize(4, 2);
  mesh.uvs << 0, 1, 1, 1, 1, 0, 0, 0;
  mesh.uv_faces = mesh.faces;
  return mesh;
}

constexpr int kSide = 64;
const Pinhole kCamera{kSide, kSide, 64, 64, 31.5, 31.5};

TEST(RenderGrey, ShowsDepthAndTextureWhereTheSurfaceIs) {
  const Mesh mesh = Square();
  Image8 texture(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) *texture.at(x, y) = static_cast<std::uint8_t>(3 * x);
  const SurfaceTexture surface(mesh, texture);
  const TexturedRender render = RenderGrey(mesh.points, mesh.faces, surface, 0,
                                           RayScene(mesh.points, mesh.faces), kCamera, Rigid3());
  int seen = 0;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      if (*render.face.at(x, y) < 0) {
        EXPECT_TRUE(std::isinf(*render.depth.at(x, y)));
        continue;
      }
      ++seen;
      EXPECT_NEAR(*render.depth.at(x, y), 2, 1e-5);
      const double texel = (((x - 31.5) / 64 * 2) + 0.5) * 64 - 0.5;
      if (texel > 0 && texel < 63) {
        EXPECT_NEAR(*render.grey.at(x, y), 3 * texel, 0.05);
      }
    }
  EXPECT_NEAR(seen, 32 * 32, 64);
}

TEST(SurfaceTexture, ALargerFootprintTakesACoarserLevel) {
  const Mesh mesh = Square();
  const SurfaceTexture surface(mesh, Image8(64, 64, 1, 50));
  EXPECT_EQ(surface.LevelFor(1, 1.0 / 64), 0);
  EXPECT_EQ(surface.LevelFor(1, 2.0 / 64), 1);
  EXPECT_EQ(surface.LevelFor(1, 4.0 / 64), 2);
  EXPECT_EQ(surface.LevelFor(1, 1e9), 3);  // the last one, of 8 texels
  EXPECT_TRUE(SurfaceTexture(mesh, Image8()).blank());
}

TEST(Overlap, IsTheSharedPartOverBothTogether) {
  const Mesh mesh = Square();
  const TexturedRender render =
      RenderShape(mesh.points, RayScene(mesh.points, mesh.faces), kCamera, Rigid3());
  GreyMask same(kSide, kSide, 1), half(kSide, kSide, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      if (*render.face.at(x, y) < 0) continue;
      *same.at(x, y) = 65535;
      if (x < kSide / 2) *half.at(x, y) = 65535;
    }
  EXPECT_EQ(Overlap(render, same), 1);
  EXPECT_NEAR(Overlap(render, half), 0.5, 0.02);
}

}  // namespace keypose::fit::textured_render_test
