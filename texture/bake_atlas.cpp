#include "texture/bake_atlas.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "texture/bake_view.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// A face's corners in texel units, y down.
struct TexelTriangle {
  Vector2d p[3];
  double twice_area;

  TexelTriangle(const Mesh& mesh, int f, int size) {
    for (int k = 0; k < 3; ++k) {
      const auto uv = mesh.uvs.row(mesh.uv_faces(f, k));
      p[k] = {uv[0] * size, (1 - uv[1]) * size};
    }
    twice_area = Cross(p[1] - p[0], p[2] - p[0]);
  }
  static double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }
  Vector3d Barycentric(const Vector2d& q) const {
    const double w1 = Cross(q - p[0], p[2] - p[0]) / twice_area, w2 = Cross(p[1] - p[0], q - p[0]) / twice_area;
    return {1 - w1 - w2, w1, w2};
  }
  /// Of the point of the triangle's outline that is closest to q; the squared distance to it comes along.
  Vector3d ClosestOnOutline(const Vector2d& q, double& squared_distance) const {
    Vector3d best = Vector3d::UnitX();
    squared_distance = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const Vector2d edge = p[(k + 1) % 3] - p[k];
      const double length2 = edge.squaredNorm();
      const double t = length2 > 0 ? std::clamp((q - p[k]).dot(edge) / length2, 0.0, 1.0) : 0;
      const double d2 = (p[k] + t * edge - q).squaredNorm();
      if (d2 >= squared_distance) continue;
      squared_distance = d2;
      best.setZero();
      best[k] = 1 - t;
      best[(k + 1) % 3] = t;
    }
    return best;
  }
  /// Calls visit(x, y) for the texels whose centres lie in the bounding box grown by `margin`.
  template <class Visit>
  void ForBox(int size, double margin, const Visit& visit) const {
    const TexelBox box = Box(size, margin);
    for (int y = box.y0; y < box.y1; ++y)
      for (int x = box.x0; x < box.x1; ++x) visit(x, y);
  }
  TexelBox Box(int size, double margin) const {
    const Vector2d low = p[0].cwiseMin(p[1]).cwiseMin(p[2]), high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
    return {std::max(0, static_cast<int>(std::ceil(low.x() - margin - 0.5))),
            std::max(0, static_cast<int>(std::ceil(low.y() - margin - 0.5))), std::min(size, static_cast<int>(high.x() + margin - 0.5) + 1),
            std::min(size, static_cast<int>(high.y() + margin - 0.5) + 1)};
  }
};

void Assign(Atlas& atlas, std::size_t texel, int face, const Vector3d& w) {
  atlas.face[texel] = face;
  atlas.bary[texel] = {static_cast<float>(w[1]), static_cast<float>(w[2])};
}

void AddRims(const Mesh& mesh, Atlas& atlas) {
  const int size = atlas.size;
  std::vector<float> nearest(atlas.face.size(), std::numeric_limits<float>::infinity());
  for (int f = 0; f < mesh.face_count(); ++f) {
    const TexelTriangle triangle(mesh, f, size);
    triangle.ForBox(size, 1, [&](int x, int y) {
      const std::size_t texel = static_cast<std::size_t>(y) * size + x;
      if (atlas.inside[texel]) return;
      double d2;
      const Vector3d w = triangle.ClosestOnOutline({x + 0.5, y + 0.5}, d2);
      if (d2 > 1 || static_cast<float>(d2) >= nearest[texel]) return;
      nearest[texel] = static_cast<float>(d2);
      Assign(atlas, texel, f, w);
    });
  }
}

/// Texels around `done` ones, ring by ring, take the mean of their done neighbours' values times `decay`.
template <class Allowed, class Value>
void Grow(int size, std::vector<Vector3f>& color, std::vector<char>& done, int rings, float decay, const Allowed& allowed,
          const Value& value) {
  const auto neighbors = [&](int texel, const auto& visit) {
    const int x = texel % size, y = texel / size;
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx)
        if ((dx || dy) && x + dx >= 0 && y + dy >= 0 && x + dx < size && y + dy < size) visit((y + dy) * size + x + dx);
  };
  std::vector<int> ring;
  std::vector<char> queued(done.size(), 0);
  const auto queue_around = [&](int texel) {
    neighbors(texel, [&](int n) {
      if (done[n] || queued[n] || !allowed(n)) return;
      queued[n] = 1;
      ring.push_back(n);
    });
  };
  for (int texel = 0; texel < size * size; ++texel)
    if (done[texel]) queue_around(texel);
  for (int round = 0; round < rings && !ring.empty(); ++round) {
    for (const int texel : ring) {
      Vector3f sum = Vector3f::Zero();
      int count = 0;
      neighbors(texel, [&](int n) {
        if (!done[n]) return;
        sum += value(n);
        ++count;
      });
      color[texel] = sum * (decay / static_cast<float>(count));
    }
    std::vector<int> finished;
    finished.swap(ring);
    for (const int texel : finished) done[texel] = 1;
    for (const int texel : finished) queue_around(texel);
  }
}

/// Mean painted colour at each vertex; `known` is 0 where nothing was painted near it.
void VertexColors(const Mesh& mesh, const Atlas& atlas, const Painting& painting, std::vector<Vector3f>& color, std::vector<char>& known) {
  std::vector<float> weight(mesh.vertex_count(), 0);
  color.assign(mesh.vertex_count(), Vector3f::Zero());
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel) {
    if (!painting.painted[texel]) continue;
    const Vector3f w = atlas.Weights(texel);
    for (int k = 0; k < 3; ++k) {
      const int v = mesh.faces(atlas.face[texel], k);
      color[v] += w[k] * w[k] * painting.color[texel];
      weight[v] += w[k] * w[k];
    }
  }
  known.assign(mesh.vertex_count(), 0);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (!(weight[v] > 1e-6f)) continue;
    color[v] /= weight[v];
    known[v] = 1;
  }
}

/// Unknown vertices become the mean of their neighbours (a harmonic function on the edges of the mesh).
void SpreadOverSurface(const Mesh& mesh, const Vector3f& fallback, std::vector<Vector3f>& color, const std::vector<char>& known) {
  std::vector<int> row(mesh.vertex_count(), -1);
  int unknowns = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (!known[v]) row[v] = unknowns++;
  if (unknowns == 0) return;
  // A grain of the fallback keeps parts that touch nothing known from being singular.
  constexpr double kGrain = 1e-6;
  Eigen::MatrixXd right = (kGrain * fallback.cast<double>().transpose()).replicate(unknowns, 1);
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(unknowns, kGrain);
  std::vector<Eigen::Triplet<double>> entries;
  for (const auto& [a, b] : UndirectedEdges(mesh.faces)) {
    for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
      if (row[i] < 0) continue;
      diagonal[row[i]] += 1;
      if (row[j] < 0) right.row(row[i]) += color[j].cast<double>().transpose();
      if (row[j] >= 0 && row[i] > row[j]) entries.emplace_back(row[i], row[j], -1.0);
    }
  }
  for (int i = 0; i < unknowns; ++i) entries.emplace_back(i, i, diagonal[i]);
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::MatrixXd solved = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>(matrix).solve(right);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (row[v] >= 0) color[v] = solved.row(row[v]).cast<float>().transpose();
}

Vector3f MeanPainted(const Painting& painting) {
  Vector3d sum = Vector3d::Zero();
  std::int64_t count = 0;
  for (std::size_t i = 0; i < painting.color.size(); ++i) {
    if (!painting.painted[i]) continue;
    sum += painting.color[i].cast<double>();
    ++count;
  }
  return count > 0 ? (sum / static_cast<double>(count)).cast<float>().eval() : Vector3f::Constant(0.5f);
}

}  // namespace

void CheckUvs(const Mesh& mesh) {
  if (!mesh.has_uvs())
    throw InputError(
        "bake: the mesh has no texture coordinates; pass the output of unwrap, or a registered mesh that kept the template's UVs");
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int t = mesh.uv_faces(f, k);
      if (t < 0 || t >= mesh.uvs.rows())
        throw InputError("bake: face " + std::to_string(f) + " names texture coordinate " + std::to_string(t) + ", but the mesh has " +
                         std::to_string(mesh.uvs.rows()) + "; the file is damaged");
      const auto uv = mesh.uvs.row(t);
      if (!(uv.minCoeff() >= -1e-6 && uv.maxCoeff() <= 1 + 1e-6))
        throw InputError("bake: face " + std::to_string(f) + " has texture coordinates (" + std::to_string(uv[0]) + ", " +
                         std::to_string(uv[1]) + ") outside 0..1; tiled or several-page layouts cannot be baked: unwrap the mesh again");
    }
}

Atlas RasterizeAtlas(const Mesh& mesh, int size) {
  CheckUvs(mesh);
  Atlas atlas;
  atlas.size = size;
  const std::size_t count = static_cast<std::size_t>(size) * size;
  atlas.face.assign(count, -1);
  atlas.bary.assign(count, Eigen::Vector2f::Zero());
  atlas.inside.assign(count, 0);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const TexelTriangle triangle(mesh, f, size);
    if (triangle.twice_area == 0) continue;
    triangle.ForBox(size, 0, [&](int x, int y) {
      const std::size_t texel = static_cast<std::size_t>(y) * size + x;
      if (atlas.inside[texel]) return;
      const Vector3d w = triangle.Barycentric({x + 0.5, y + 0.5});
      if (w.minCoeff() < -1e-9) return;
      Assign(atlas, texel, f, w);
      atlas.inside[texel] = 1;
      ++atlas.texels;
    });
  }
  if (atlas.texels == 0)
    throw InputError("bake: the texture coordinates cover not one texel of " + std::to_string(size) + " x " + std::to_string(size) +
                     "; unwrap the mesh again");
  AddRims(mesh, atlas);
  return atlas;
}

TexelBox TexelsAround(const Mesh& mesh, const Atlas& atlas, int face) { return TexelTriangle(mesh, face, atlas.size).Box(atlas.size, 1); }

void InpaintUnseen(const Mesh& mesh, const Atlas& atlas, Painting& painting) {
  std::vector<Vector3f> at_vertex;
  std::vector<char> known;
  VertexColors(mesh, atlas, painting, at_vertex, known);
  SpreadOverSurface(mesh, MeanPainted(painting), at_vertex, known);
  const auto smooth = [&](std::size_t texel) {
    const Vector3f w = atlas.Weights(texel);
    const auto f = mesh.faces.row(atlas.face[texel]);
    return (w[0] * at_vertex[f[0]] + w[1] * at_vertex[f[1]] + w[2] * at_vertex[f[2]]).eval();
  };
  // What a painted texel has beyond the smooth colour is carried a little way into the unseen part, so that no edge shows there. Until the
  // end unseen texels hold this grain only.
  std::vector<char> done = painting.painted;
  Grow(
      atlas.size, painting.color, done, 24, 0.85f, [&](int texel) { return atlas.face[texel] >= 0; },
      [&](int texel) { return painting.painted[texel] ? (painting.color[texel] - smooth(texel)).eval() : painting.color[texel]; });
  for (std::size_t texel = 0; texel < done.size(); ++texel)
    if (atlas.face[texel] >= 0 && !painting.painted[texel]) painting.color[texel] = (smooth(texel) + painting.color[texel]).cwiseMax(0.0f);
}

ImageF FinishTexture(const Atlas& atlas, Painting&& painting, int gutter) {
  const Vector3f rest = MeanPainted(painting);
  std::vector<Vector3f> color = std::move(painting.color);
  std::vector<char> done(color.size());
  for (std::size_t texel = 0; texel < color.size(); ++texel) done[texel] = atlas.face[texel] >= 0;
  Grow(
      atlas.size, color, done, gutter, 1.0f, [](int) { return true; }, [&](int texel) { return color[texel]; });
  ImageF texture(atlas.size, atlas.size, 3);
  for (std::size_t texel = 0; texel < color.size(); ++texel)
    for (int k = 0; k < 3; ++k) texture.data[3 * texel + k] = done[texel] ? color[texel][k] : rest[k];
  return texture;
}

Image8 SrgbImage(const ImageF& linear) {
  Image8 srgb(linear.width, linear.height, linear.channels);
  ParallelBlocks(static_cast<std::int64_t>(linear.data.size()), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) srgb.data[i] = SrgbOf(linear.data[i]);
  });
  return srgb;
}

}  // namespace keypose::texture
