#include "texture/bake/bake_scan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::bake_scan_test {

/// The scan's own texture, painted where its surface points are.
Image8 Painted(const Mesh& scan, int size, const Paint& paint) {
  const Atlas atlas = RasterizeAtlas(scan, size);
  Painting painting(size);
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (atlas.face[texel] < 0) continue;
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += atlas.Weights(texel)[k] * scan.points.row(scan.faces(atlas.face[texel], k)).transpose();
    painting.At(texel) = paint(x, {});
    painting.sure[texel] = 255;
  }
  return SrgbImage(FinishTexture(atlas, std::move(painting), 12));
}

Mesh WithColors(Mesh mesh, const Paint& paint) {
  mesh.uvs.resize(0, 2);
  mesh.uv_faces.resize(0, 3);
  mesh.colors.resize(mesh.points.rows(), 3);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3f color = paint(mesh.points.row(v).transpose(), {});
    for (int c = 0; c < 3; ++c) mesh.colors(v, c) = SrgbOf(color[c]);
  }
  return mesh;
}

/// Without the faces for which `gone` holds at a corner.
Mesh Without(const Mesh& mesh, const std::function<bool(const Vector3d&)>& gone) {
  std::vector<int> kept;
  for (int f = 0; f < mesh.face_count(); ++f) {
    bool keep = true;
    for (int k = 0; k < 3; ++k) keep &= !gone(mesh.points.row(mesh.faces(f, k)).transpose());
    if (keep) kept.push_back(f);
  }
  Mesh rest = mesh;
  rest.faces = mesh.faces(kept, Eigen::all);
  if (mesh.has_uvs()) rest.uv_faces = mesh.uv_faces(kept, Eigen::all);
  return rest;
}

class BakeScanTest : public ::testing::Test {
 protected:
  BakeScanTest() : mesh_(PatchSphere(10)), scan_(PatchSphere(23)) { options_.texture_size = 256; }
  ScanBake Bake(const Mesh& scan, const Image8& texture) const {
    return BakeScan(mesh_, scan, texture, options_);
  }
  Mesh mesh_, scan_;
  ScanBakeOptions options_;
};

TEST_F(BakeScanTest, ColoursComeFromTheTextureInItsOwnLayout) {
  scan_.uvs.col(0).swap(scan_.uvs.col(1));
  for (auto corners : scan_.uv_faces.rowwise()) std::swap(corners[1], corners[2]);
  for (auto corners : scan_.faces.rowwise()) std::swap(corners[1], corners[2]);
  const ScanBake result = Bake(scan_, Painted(scan_, 512, Smooth));
  EXPECT_EQ(result.seen_texels, result.texels);
  EXPECT_GT(PsnrAgainst(mesh_, result.texture, Smooth), 38)
      << "and that its faces look inwards makes no difference";
}

TEST_F(BakeScanTest, ColoursOfVerticesServeWhereThereIsNoTexture) {
  const ScanBake result = Bake(WithColors(scan_, Smooth), {});
  EXPECT_GT(PsnrAgainst(mesh_, result.texture, Smooth), 36);
}

TEST_F(BakeScanTest, WhereTheScanHasAHoleNothingIsSureAndColoursGoOnFromAround) {
  const auto gone = [](const Vector3d& x) { return x.z() > 0.6; };
  const ScanBake result = Bake(Without(scan_, gone), Painted(scan_, 512, Smooth));
  EXPECT_NEAR(static_cast<double>(result.seen_texels) / static_cast<double>(result.texels), 0.8,
              0.05)
      << "of a sphere that lacks a cap of 0.2 of its surface";
  const Atlas atlas = RasterizeAtlas(mesh_, result.texture.width);
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!atlas.inside[texel]) continue;
    double z = 0;
    for (int k = 0; k < 3; ++k)
      z += atlas.Weights(texel)[k] * mesh_.points(mesh_.faces(atlas.face[texel], k), 2);
    if (z > 0.75) {
      ASSERT_EQ(result.confidence.data[texel], 0);
    } else if (z < 0.4) {
      ASSERT_GT(result.confidence.data[texel], 240);
    }
  }
  EXPECT_GT(PsnrAgainst(mesh_, result.texture, Smooth), 20);
}

TEST_F(BakeScanTest, AThinPartHasEachSidesColour) {
  const Paint sides = [](const Vector3d& x, const Vector3d&) {
    return x.z() > 0 ? Vector3f(0.8f, 0.1f, 0.1f) : Vector3f(0.1f, 0.1f, 0.8f);
  };
  Image8 texture = Painted(scan_, 512, sides);
  scan_.points.col(2) *= 0.004, mesh_.points.col(2) *= 0.004;
  mesh_.points.col(2).array() += 0.006;  // its lower side lies closer to the scan's upper one
  const ScanBake result = Bake(scan_, texture);
  const auto away = [](const Vector3d& x) { return std::hypot(x.x(), x.y()) < 0.9; };
  const Paint shifted = [&](const Vector3d& x, const Vector3d& eye) {
    return sides(x - Vector3d(0, 0, 0.006), eye);
  };
  EXPECT_GT(PsnrAgainst(mesh_, result.texture, shifted, away), 30);
}

TEST_F(BakeScanTest, AFinerTextureIsAveragedAndTellsTheSizeThatItNeeds) {
  const Paint checks = [](const Vector3d& x, const Vector3d&) {
    const long parity = std::lround(60 * x.x()) + std::lround(60 * x.y()) + std::lround(60 * x.z());
    return Vector3f::Constant(parity % 2 ? 0.6f : 0.2f);
  };
  const Paint grey = [](const Vector3d&, const Vector3d&) { return Vector3f::Constant(0.4f); };
  options_.texture_size = 64;
  const Image8 texture = Painted(scan_, 1024, checks);
  const ScanBake small = Bake(scan_, texture);
  EXPECT_EQ(small.advised_size, 1024);
  EXPECT_GT(PsnrAgainst(mesh_, small.texture, grey), 22) << "single texels would give 14";
  options_.texture_size = 0;
  EXPECT_EQ(Bake(scan_, texture).texture.width, 1024);
}

TEST_F(BakeScanTest, AScanThatLiesElsewhereGivesGreyAndNoConfidence) {
  scan_.points.col(0).array() += 5;
  const ScanBake result = Bake(scan_, Painted(scan_, 512, Smooth));
  EXPECT_EQ(result.seen_texels, 0);
  EXPECT_THAT(result.confidence.data, ::testing::Each(0));
  EXPECT_THAT(result.texture.data, ::testing::Each(result.texture.data[0]));
}

TEST_F(BakeScanTest, SameBitsForAnyThreadCount) {
  const Image8 texture = Painted(scan_, 512, Checker);
  SetThreadCount(1);
  const ScanBake one = Bake(scan_, texture);
  SetThreadCount(3);
  const ScanBake three = Bake(scan_, texture);
  SetThreadCount(0);
  EXPECT_EQ(one.texture.data, three.texture.data);
  EXPECT_EQ(one.confidence.data, three.confidence.data);
}

TEST_F(BakeScanTest, AScanWithoutColoursGivesNoneAndATextureNeedsCoordinates) {
  EXPECT_EQ(Bake(scan_, {}).seen_texels, 0);
  const Image8 texture = Painted(scan_, 64, Smooth);
  EXPECT_THROW(Bake(WithColors(scan_, Smooth), texture), InputError);
}

}  // namespace keypose::texture::bake_scan_test
