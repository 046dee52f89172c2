#include "synth/scores/texel_score.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

constexpr int kAcross = 512;  // number of sampled texels per row
constexpr double kEqualDb = 99;

// A texel and its place on the template.
struct Texel {
  int x, y, face;
  Eigen::Vector3d barycentric;
};

void Check(const Mesh& truth_a, const Mesh& truth_b, const Mesh& template_a,
           const PointsX3& registered_b, const Image8& a, const Image8& b) {
  if (truth_a.points.rows() != truth_b.points.rows() || !SameFaces(truth_a.faces, truth_b.faces))
    throw InputError(
        "synth: the true surfaces are not two poses of one world; render them together");
  RequireOnePerVertex(registered_b.rows(), template_a.points.rows(),
                      "synth: the registered mesh has", "vertices", "the template",
                      "; compare it with the template that it was registered from");
  if (!template_a.has_uvs())
    throw InputError(
        "synth: the template has no texture coordinates; pass the mesh that unwrap wrote");
  if (a.width != b.width || a.height != b.height || a.channels != 3 || b.channels != 3 || a.empty())
    throw InputError(
        "synth: the textures differ in size or do not have three channels; bake both poses with "
        "the same options");
}

// Texels whose centres lie in a face's part of the layout. On a shared border, the first face gets
// the texel.
std::vector<Texel> CoveredTexels(const Mesh& mesh, int width, int height) {
  const int step = std::max(1, width / kAcross);
  std::vector<char> taken(static_cast<std::size_t>(width) * height, 0);
  std::vector<Texel> texels;
  for (int f = 0; f < mesh.face_count(); ++f) {
    std::array<Eigen::Vector2d, 3> p;
    for (int k = 0; k < 3; ++k) {
      const auto uv = mesh.uvs.row(mesh.uv_faces(f, k));
      p[k] = {uv[0] * width - 0.5, (1 - uv[1]) * height - 0.5};
    }
    const auto cross = [](const Eigen::Vector2d& u, const Eigen::Vector2d& v) {
      return u.x() * v.y() - u.y() * v.x();
    };
    const double area = cross(p[1] - p[0], p[2] - p[0]);
    if (area == 0) continue;
    const Eigen::Vector2d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]),
                          high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    const auto first = [&](double at) {
      return std::max(0, static_cast<int>(std::ceil(at / step))) * step;
    };
    for (int y = first(low.y()); y <= std::min<double>(high.y(), height - 1); y += step)
      for (int x = first(low.x()); x <= std::min<double>(high.x(), width - 1); x += step) {
        const Eigen::Vector2d at(x, y);
        const double b = cross(at - p[0], p[2] - p[0]) / area,
                     c = cross(p[1] - p[0], at - p[0]) / area;
        char& done = taken[static_cast<std::size_t>(y) * width + x];
        if (b < 0 || c < 0 || b + c > 1 || done) continue;
        done = 1;
        texels.push_back({x, y, f, {1 - b - c, b, c}});
      }
  }
  return texels;
}

Eigen::Vector3d Place(const PointsX3& points, const FacesX3& faces, int f,
                      const Eigen::Vector3d& barycentric) {
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) place += barycentric[k] * points.row(faces(f, k)).transpose();
  return place;
}

// Straight distances in the rest pose between the spots that each texel shows in the two poses.
std::vector<double> ClayDistances(const Mesh& truth_a, const Mesh& truth_b, const Mesh& mesh,
                                  const PointsX3& registered_b, const std::vector<Texel>& texels) {
  const RayScene scene_a(truth_a.points, truth_a.faces), scene_b(truth_b.points, truth_b.faces);
  std::vector<double> distances(texels.size());
  ParallelFor(
      std::ssize(texels),
      [&](std::int64_t i) {
        const Texel& t = texels[i];
        const RayScene::Foot a =
            scene_a.ClosestPoint(Place(mesh.points, mesh.faces, t.face, t.barycentric));
        const RayScene::Foot b =
            scene_b.ClosestPoint(Place(registered_b, mesh.faces, t.face, t.barycentric));
        distances[i] =
            (a.point - Place(truth_a.points, truth_a.faces, b.face, b.barycentric)).norm();
      },
      256);
  return distances;
}

double Psnr(double squares, double count) {
  return squares > 0 ? std::min(kEqualDb, 10 * std::log10(255 * 255 / (squares / count)))
                     : kEqualDb;
}

void CompareColors(const Image8& a, const Image8& b, const std::vector<Texel>& texels,
                   TexelScore& score) {
  double difference = 0, squares = 0, squares_gain = 0;
  for (int c = 0; c < 3; ++c) {
    double aa = 0, ab = 0, bb = 0;
    for (const Texel& t : texels) {
      const double p = a.at(t.x, t.y)[c], q = b.at(t.x, t.y)[c];
      difference += std::abs(p - q);
      aa += p * p;
      ab += p * q;
      bb += q * q;
    }
    squares += aa - 2 * ab + bb;
    squares_gain += bb > 0 ? aa - ab * ab / bb : aa;  // of a against b times the best-fitting gain
  }
  const double count = 3.0 * static_cast<double>(texels.size());
  score.mean_difference = difference / count;
  score.psnr_db = Psnr(squares, count);
  score.psnr_gain_db = Psnr(squares_gain, count);
}

double LayoutTexels(const Mesh& mesh, int width, int height) {
  double area = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const Eigen::RowVector2d p = mesh.uvs.row(mesh.uv_faces(f, 0)),
                             q = mesh.uvs.row(mesh.uv_faces(f, 1)) - p,
                             r = mesh.uvs.row(mesh.uv_faces(f, 2)) - p;
    area += std::abs(q[0] * r[1] - q[1] * r[0]) / 2;
  }
  return area * width * height;
}

}  // namespace

TexelScore ScoreTexels(const Mesh& truth_a, const Mesh& truth_b, const Mesh& template_a,
                       const PointsX3& registered_b, const Image8& texture_a,
                       const Image8& texture_b) {
  Check(truth_a, truth_b, template_a, registered_b, texture_a, texture_b);
  const std::vector<Texel> texels = CoveredTexels(template_a, texture_a.width, texture_a.height);
  if (texels.empty())
    throw InputError("synth: the template's layout covers no texel; are these its textures?");
  const double diagonal = BoundingDiagonal(truth_a.points);
  std::vector<double> distances = ClayDistances(truth_a, truth_b, template_a, registered_b, texels);
  std::sort(distances.begin(), distances.end());
  TexelScore score;
  score.texels = SizeOf(texels);
  score.mean = std::accumulate(distances.begin(), distances.end(), 0.0) /
               static_cast<double>(distances.size()) / diagonal;
  score.p95 = distances[(distances.size() - 1) * 95 / 100] / diagonal;
  score.max = distances.back() / diagonal;
  const double area = SurfaceArea(template_a.points, template_a.faces);
  score.texel =
      std::sqrt(area / LayoutTexels(template_a, texture_a.width, texture_a.height)) / diagonal;
  CompareColors(texture_a, texture_b, texels, score);
  return score;
}

}  // namespace keypose::synth
