// The parts of baking: selection of photographs, levelling, measures, splitting.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <map>
#include <utility>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "texture/bake/face_split.h"
#include "texture/bake/labels.h"
#include "texture/bake/lattice.h"
#include "texture/bake/paint.h"
#include "texture/bake/seam_levelling.h"
#include "texture/bake/testing_spheres.h"

namespace keypose::texture::bake_parts_test {

/// Colours on both sides of the middles of the mesh's edges: mean difference over edges between two
/// views, and over the others.
std::pair<double, double> JumpsAtBordersAndWithin(const Mesh& mesh, const ImageF& texture,
                                                  const std::vector<int>& labels) {
  std::map<std::pair<int, int>, std::vector<std::pair<int, Vector3f>>> sides;  // edge: face, colour
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
      const Eigen::RowVector2d uv =
          0.42 * (mesh.uvs.row(mesh.uv_faces(f, k)) + mesh.uvs.row(mesh.uv_faces(f, (k + 1) % 3))) +
          0.16 * mesh.uvs.row(mesh.uv_faces(f, (k + 2) % 3));
      const int x = static_cast<int>(uv[0] * texture.width),
                y = static_cast<int>((1 - uv[1]) * texture.height);
      sides[{std::min(a, b), std::max(a, b)}].emplace_back(
          f, Eigen::Map<const Vector3f>(texture.at(x, y)));
    }
  double sum[2] = {0, 0}, count[2] = {0, 0};
  for (const auto& [edge, s] : sides) {
    if (s.size() != 2) continue;
    const int within = labels[s[0].first] == labels[s[1].first];
    sum[within] += (s[0].second.cwiseSqrt() - s[1].second.cwiseSqrt()).norm();
    ++count[within];
  }
  EXPECT_GT(count[0], 50);
  return {sum[0] / count[0], sum[1] / count[1]};
}

/// BakeAll's steps for all views, keeping the labels.
struct PaintedSphere {
  std::vector<int> labels;
  ImageF texture;
};
PaintedSphere PaintAll(const Mesh& mesh, const std::vector<View>& views,
                       const std::vector<Photograph>& photographs, double to_mean) {
  const RayScene scene(mesh.points, mesh.faces);
  const Atlas atlas = RasterizeAtlas(mesh, 512);
  std::vector<BakeView> loaded;
  for (std::size_t v = 0; v < views.size(); ++v)
    loaded.emplace_back(views[v], photographs[v], mesh, scene, BakeViewOptions());
  const std::vector<Vector3f> gains(views.size(), Vector3f::Ones());
  PaintResult result = PaintTexels(
      ColorSampler(mesh, loaded, gains, {}, std::vector<char>(views.size(), 1), 512, 75, 3), atlas,
      {to_mean, 0.05f}, nullptr);
  return {result.labels, FinishTexture(atlas, std::move(result.painting), 4)};
}

/// A painting of a sphere's atlas, texel by texel.
Painting PaintedBy(
    const Mesh& mesh, const Atlas& atlas,
    const std::function<std::pair<Vector3f, int>(int, const Vector3d&)>& color_and_sure) {
  Painting painting(atlas.size);
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    const int f = atlas.face[texel];
    if (f < 0) continue;
    Vector3d x = Vector3d::Zero();
    for (int k = 0; k < 3; ++k)
      x += static_cast<double>(atlas.Weights(texel)[k]) *
           mesh.points.row(mesh.faces(f, k)).transpose();
    const auto [color, sure] = color_and_sure(f, x);
    painting.At(texel) = color;
    painting.sure[texel] = static_cast<std::uint8_t>(sure);
  }
  return painting;
}

// A face that one photograph shows only beside its edge, where half of a pixel is the white
// backdrop.
TEST(InpaintUnseen, TakesWhatIsSeenBesideEdgesOnlyFromAround) {
  const Mesh mesh = PatchSphere(8);
  const Atlas atlas = RasterizeAtlas(mesh, 192);
  const Vector3f green(0.1f, 0.4f, 0.1f), white(0.8f, 0.8f, 0.8f);
  for (const int sure : {1, 255}) {
    Painting painting = PaintedBy(mesh, atlas, [&](int f, const Vector3d&) {
      return f == 10 ? std::pair(white, sure) : std::pair(green, 255);
    });
    InpaintUnseen(mesh, atlas, painting);
    for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
      if (atlas.face[texel] != 10) continue;
      ASSERT_NEAR(painting.At(texel)[0], sure == 1 ? 0.1f : 0.8f,
                  0.03);  // 8/255 of the difference remain
    }
  }
}

// A glove and a sleeve meet in front and behind; below, in a strip that no photograph shows, they
// do not mix to grey.
TEST(InpaintUnseen, PaintsThatMeetDoNotRunIntoEachOther) {
  const Mesh mesh = PatchSphere(16);
  const Atlas atlas = RasterizeAtlas(mesh, 256);
  const Vector3f glove(0.5f, 0.3f, 0.05f), sleeve(0.05f, 0.13f, 0.25f);
  const auto unseen = [](const Vector3d& x) { return x.x() > 0 && std::abs(x.y()) < 0.4; };
  Painting painting = PaintedBy(mesh, atlas, [&](int, const Vector3d& x) {
    return std::pair(x.z() > 0 ? glove : sleeve, unseen(x) ? 0 : 255);
  });
  const Painting before = painting;
  InpaintUnseen(mesh, atlas, painting);
  double mixed = 0, all = 0;
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (atlas.face[texel] < 0 || before.sure[texel]) continue;
    all += 1;
    mixed +=
        std::min((painting.At(texel) - glove).norm(), (painting.At(texel) - sleeve).norm()) > 0.1f;
  }
  EXPECT_GT(all, 1000);
  EXPECT_LT(mixed / all, 0.1);
}

TEST(FaceLattice, GivesLinearFunctionsBackAndCutsTheTriangleWithoutGaps) {
  const auto linear = [](const Vector3f& w) { return 3 * w[0] - 2 * w[1] + 7 * w[2]; };
  for (const int parts : {1, 2, 5, 16}) {
    const FaceLattice lattice(parts);
    std::vector<float> values;
    lattice.ForNodes([&](const Vector3f& w) { values.push_back(linear(w)); });
    ASSERT_EQ(SizeOf(values), FaceLattice::CountOf(parts));
    // Corners, sides, nodes, and points a rounding outside are among these.
    for (int i = 0; i <= 60; ++i)
      for (int j = 0; i + j <= 60; ++j) {
        const Vector3f w(static_cast<float>(60 - i - j) / 60 + (i == 0 ? 1e-6f : 0),
                         static_cast<float>(i) / 60 - (i == 0 ? 1e-6f : 0),
                         static_cast<float>(j) / 60);
        const FaceLattice::Corners at = lattice.Between(w);
        float value = 0, sum = 0;
        for (int k = 0; k < 3; ++k) {
          ASSERT_GE(at.weight[k], -1e-6f);
          sum += at.weight[k];
          value += at.weight[k] * values[at.node[k]];
        }
        ASSERT_NEAR(sum, 1, 1e-5);
        ASSERT_NEAR(value, linear(w), 1e-4) << parts << " " << w.transpose();
      }
  }
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

TEST(PaintTexels, BordersBetweenViewsShowNoMoreThanTheInside) {
  const Mesh mesh = PatchSphere(20);
  const std::vector<View> views = AllRound(240);
  // The lamp is fixed while the sphere turns, and every photograph has another exposure.
  const Paint lit = [](const Vector3d& x, const Vector3d& eye) {
    const double shade = 0.75 + 0.25 * x.normalized().dot((eye + Vector3d(0, 0, 3)).normalized());
    return (Smooth(x, eye) *
            static_cast<float>(shade * (1 + 0.15 * std::sin(7 * eye.x() + 3 * eye.y()))))
        .eval();
  };
  const std::vector<Photograph> photographs = Shoot(mesh, views, lit);
  for (const double to_mean : {0.0, 1.0}) {
    const PaintedSphere painted = PaintAll(mesh, views, photographs, to_mean);
    const auto [borders, within] = JumpsAtBordersAndWithin(mesh, painted.texture, painted.labels);
    EXPECT_LT(borders, 1.2 * within) << "to_mean " << to_mean;
  }
}

TEST(LevelSeams, ViewsThatDifferByAConstantMeetHalfWay) {
  const Mesh mesh = PatchSphere(6);
  std::vector<FaceViews> faces(mesh.face_count());
  std::vector<int> labels(mesh.face_count());
  for (int f = 0; f < mesh.face_count(); ++f) {
    labels[f] = mesh.points(mesh.faces(f, 0), 2) + mesh.points(mesh.faces(f, 1), 2) +
                    mesh.points(mesh.faces(f, 2), 2) >
                0;
    faces[f].mean = Vector3f(0.4f, 0.4f, 0.4f);
    for (const int view : {0, 1}) {
      const Vector3f color = Vector3f::Constant(view ? 0.6f : 0.3f);
      faces[f].candidates.push_back({view, 1, color.cwiseSqrt(), color, 1, 1});
    }
  }
  const auto shares = VertexShares(mesh, labels);
  for (const double to_mean : {0.0, 1000.0})
    for (const auto& list : LevelSeams(mesh, faces, labels, shares, to_mean)) {
      if (list.size() < 2) continue;
      // At the border both have one colour; with a large weight, the mean.
      EXPECT_NEAR(0.3 + list[0].color[1], 0.6 + list[1].color[1], 0.02);
      if (to_mean > 0) {
        EXPECT_NEAR(0.3 + list[0].color[1], 0.4, 1e-3);
      }
    }
}

TEST(ChooseLabels, OneViewThatIsNearlyTheBestEverywhereTakesAll) {
  const Mesh mesh = PatchSphere(6);
  std::vector<std::vector<LabelCandidate>> candidates(mesh.face_count());
  const Vector3f grey = Vector3f::Constant(0.5f);
  // View 5 is 5 % worse than whichever of nine others is best; but on one patch it is a thousandth
  // as good.
  for (int f = 0; f < mesh.face_count(); ++f) {
    candidates[f].push_back({f % 5, 1.0, grey, grey, 1, 1});
    candidates[f].push_back({5, f < 72 ? 0.001 : 0.95, grey, grey, 1, 1});
  }
  const std::vector<int> labels = ChooseLabels(mesh, candidates);
  for (int f = 0; f < mesh.face_count(); ++f) EXPECT_EQ(labels[f], f >= 72 ? 5 : f % 5) << f;
  candidates[100].clear();
  EXPECT_EQ(ChooseLabels(mesh, candidates)[100], -1);
}

TEST(SplitLargeFaces, KeepsTheSurfaceAndItsLayout) {
  const Mesh mesh = PatchSphere(3);
  const std::vector<View> views = AllRound(240);
  const Mesh split = SplitLargeFaces(mesh, views);
  ASSERT_GT(split.face_count(), mesh.face_count());
  EXPECT_TRUE(CheckClosed(split).closed());
  EXPECT_NEAR(SurfaceArea(split.points, split.faces), SurfaceArea(mesh.points, mesh.faces), 1e-9);
  const Atlas before = RasterizeAtlas(mesh, 128), after = RasterizeAtlas(split, 128);
  for (std::size_t t = 0; t < before.face.size(); ++t) {
    ASSERT_EQ(before.inside[t], after.inside[t]);
    if (!before.inside[t]) continue;
    Vector3d x = Vector3d::Zero(), y = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      x += static_cast<double>(before.Weights(t)[k]) *
           mesh.points.row(mesh.faces(before.face[t], k)).transpose();
      y += static_cast<double>(after.Weights(t)[k]) *
           split.points.row(split.faces(after.face[t], k)).transpose();
    }
    ASSERT_LT((x - y).norm(), 1e-5);
  }
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

}  // namespace keypose::texture::bake_parts_test
