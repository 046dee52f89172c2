#include "texture/bake/paint.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <utility>

#include "texture/bake/testing_spheres.h"

namespace keypose::texture::paint_test {

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

}  // namespace keypose::texture::paint_test
