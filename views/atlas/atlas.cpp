#include "views/atlas/atlas.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <string>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"

namespace keypose {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

double Cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

TexelTriangle TriangleOf(const Mesh& mesh, int f, int size) {
  TexelTriangle triangle;
  for (int k = 0; k < 3; ++k) {
    const auto uv = mesh.uvs.row(mesh.uv_faces(f, k));
    triangle.p[k] = {uv[0] * size, (1 - uv[1]) * size};
  }
  triangle.twice_area = Cross(triangle.p[1] - triangle.p[0], triangle.p[2] - triangle.p[0]);
  return triangle;
}

/// The texels whose centres lie in the bounding box grown by `margin`.
TexelBox BoxOf(const TexelTriangle& triangle, int size, double margin) {
  const Vector2d *p = triangle.p, low = p[0].cwiseMin(p[1]).cwiseMin(p[2]),
                 high = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
  return {std::max(0, static_cast<int>(std::ceil(low.x() - margin - 0.5))),
          std::max(0, static_cast<int>(std::ceil(low.y() - margin - 0.5))),
          std::min(size, static_cast<int>(high.x() + margin - 0.5) + 1),
          std::min(size, static_cast<int>(high.y() + margin - 0.5) + 1)};
}

/// Rows of the atlas for one thread.
class Band {
 public:
  Band(Atlas& atlas, int y0, int y1) : atlas_(atlas), y0_(y0), y1_(y1) {}

  void FillInsides() {
    for (std::size_t f = 0; f < atlas_.triangles.size(); ++f) {
      const TexelTriangle& triangle = atlas_.triangles[f];
      if (triangle.twice_area == 0) continue;
      ForBox(triangle, 0, [&](int x, int y, std::size_t texel) {
        if (atlas_.inside[texel] || triangle.Barycentric({x + 0.5, y + 0.5}).minCoeff() < -1e-9)
          return;
        atlas_.face[texel] = static_cast<int>(f);
        atlas_.inside[texel] = 1;
        ++texels_;
      });
    }
  }

  void AddRims() {
    std::vector<float> nearest(static_cast<std::size_t>(y1_ - y0_) * atlas_.size,
                               std::numeric_limits<float>::infinity());
    const std::size_t first = static_cast<std::size_t>(y0_) * atlas_.size;
    for (std::size_t f = 0; f < atlas_.triangles.size(); ++f) {
      const TexelTriangle& triangle = atlas_.triangles[f];
      ForBox(triangle, 1, [&](int x, int y, std::size_t texel) {
        if (atlas_.inside[texel]) return;
        double d2;
        triangle.ClosestOnOutline({x + 0.5, y + 0.5}, d2);
        if (d2 > 1 || static_cast<float>(d2) >= nearest[texel - first]) return;
        nearest[texel - first] = static_cast<float>(d2);
        atlas_.face[texel] = static_cast<int>(f);
      });
    }
  }

  std::int64_t texels() const { return texels_; }

 private:
  template <class Visit>
  void ForBox(const TexelTriangle& triangle, double margin, const Visit& visit) {
    const TexelBox box = BoxOf(triangle, atlas_.size, margin);
    for (int y = std::max(box.y0, y0_); y < std::min(box.y1, y1_); ++y)
      for (int x = box.x0; x < box.x1; ++x)
        visit(x, y, static_cast<std::size_t>(y) * atlas_.size + x);
  }

  Atlas& atlas_;
  int y0_, y1_;
  std::int64_t texels_ = 0;
};

/// Chosen on the painted spheres of bake_parts_test and the demo character; no record of the
/// trials.
struct InpaintTuning {
  /// square root of linear light: hues that differ by this conduct half
  KEYPOSE_TUNED(float, kSameHue, 0.02f);
  /// share of full confidence from which on a vertex keeps its colour
  KEYPOSE_TUNED(float, kKept, 0.9f);
  /// weight of an unsure vertex's own colour at half confidence, in edges that conduct fully
  KEYPOSE_TUNED(double, kPull, 0.2);
  /// one over the share of full confidence from which on a texel keeps all of its detail: colours
  /// seen only near photographs' edges may be background
  KEYPOSE_TUNED(float, kKeptOfSure, 8);
  /// factor of the painted part's detail per texel into the unseen part
  KEYPOSE_TUNED(float, kDecay, 0.85f);
};

/// Rows per task of a thread.
constexpr int kRows = 128;

template <class Visit>
void ForNeighbors(int size, int texel, const Visit& visit) {
  const int x = texel % size, y = texel / size;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx)
      if ((dx || dy) && x + dx >= 0 && y + dy >= 0 && x + dx < size && y + dy < size)
        visit((y + dy) * size + x + dx);
}

/// Allowed texels that are not done but adjacent to one that is.
template <class Allowed>
std::vector<int> FirstRing(int size, const std::vector<char>& done, const Allowed& allowed) {
  std::vector<std::vector<int>> bands((size + kRows - 1) / kRows);
  ParallelBlocks(size, kRows, [&](std::int64_t begin, std::int64_t end) {
    for (int texel = static_cast<int>(begin) * size; texel < static_cast<int>(end) * size;
         ++texel) {
      if (done[texel] || !allowed(texel)) continue;
      bool touches = false;
      ForNeighbors(size, texel, [&](int n) { touches |= done[n] != 0; });
      if (touches) bands[begin / kRows].push_back(texel);
    }
  });
  std::vector<int> ring;
  for (const auto& band : bands) ring.insert(ring.end(), band.begin(), band.end());
  return ring;
}

/// Ring by ring, texels around `done` ones get the mean of their done neighbours' values times
/// `decay`.
template <class Allowed, class Value>
void Grow(int size, Painting& painting, std::vector<char>& done, int rings, float decay,
          const Allowed& allowed, const Value& value) {
  if (rings <= 0) return;
  std::vector<int> ring = FirstRing(size, done, allowed), next;
  constexpr char kQueued = 2;  // neither done nor to be queued again; not counted as done
  std::vector<char> state = done;
  for (const int texel : ring) state[texel] = kQueued;
  for (int round = 0; round < rings && !ring.empty(); ++round) {
    ParallelFor(
        std::ssize(ring),
        [&](std::int64_t i) {
          Vector3f sum = Vector3f::Zero();
          int count = 0;
          ForNeighbors(size, ring[i], [&](int n) {
            if (!done[n]) return;
            sum += value(n);
            ++count;
          });
          painting.At(ring[i]) = sum * (decay / static_cast<float>(count));
        },
        1024);
    next.clear();
    for (const int texel : ring) done[texel] = state[texel] = 1;
    for (const int texel : ring)
      ForNeighbors(size, texel, [&](int n) {
        if (state[n] || !allowed(n)) return;
        state[n] = kQueued;
        next.push_back(n);
      });
    ring.swap(next);
  }
}

/// For the corners of a face, one column each: weighted sums of its colours, of their weights, and
/// of the weights at full confidence.
using CornerSums = Eigen::Matrix<float, 5, 3>;
CornerSums SumCorners(const Atlas& atlas, const Painting& painting, int face) {
  CornerSums sums = CornerSums::Zero();
  const TexelBox box = TexelsAround(atlas, face);
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      const std::size_t texel = static_cast<std::size_t>(y) * atlas.size + x;
      if (atlas.face[texel] != face) continue;
      const Vector3f w = atlas.Weights(texel).cwiseAbs2();
      const float sure = static_cast<float>(painting.sure[texel]) / 255;
      sums.topRows<3>() += sure * painting.At(texel) * w.transpose();
      sums.row(3) += sure * w.transpose();
      sums.row(4) += w.transpose();
    }
  return sums;
}

/// Conductance of colour along an edge of the mesh. It is small between different hues, so that two
/// paints at the border of the unseen part do not mix to grey within it. Differences of brightness
/// do not reduce it.
double Flow(const Vector3f& a, const Vector3f& b) {
  const float same_hue = InpaintTuning::kSameHue;
  const Vector3f root = a.cwiseMax(0.0f).cwiseSqrt() - b.cwiseMax(0.0f).cwiseSqrt();
  const float apart = (root.array() - root.mean()).matrix().squaredNorm();
  return same_hue * same_hue / (same_hue * same_hue + apart);
}

/// Colours with low confidence become the weighted mean of their neighbours (a harmonic function on
/// the edges of the mesh), mixed with their own colour by its confidence.
void SpreadOverSurface(const Mesh& mesh, const std::vector<std::pair<int, int>>& edges,
                       const std::vector<double>& flows, const Vector3f& fallback,
                       VertexColors& colors) {
  // A small weight of the fallback makes parts without known neighbours non-singular.
  constexpr double kGrain = 1e-6;
  std::vector<int> row(mesh.vertex_count(), -1);
  int unknowns = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (colors.sure[v] < InpaintTuning::kKept) row[v] = unknowns++;
  if (unknowns == 0) return;
  Eigen::MatrixXd right = (kGrain * fallback.cast<double>().transpose()).replicate(unknowns, 1);
  Eigen::VectorXd diagonal = Eigen::VectorXd::Constant(unknowns, kGrain);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (row[v] < 0) continue;
    const double pull = InpaintTuning::kPull * colors.sure[v] / (1 - colors.sure[v]);
    diagonal[row[v]] += pull;
    right.row(row[v]) += pull * colors.color[v].cast<double>().transpose();
  }
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const auto& [a, b] = edges[e];
    for (const auto& [i, j] : {std::pair(a, b), std::pair(b, a)}) {
      if (row[i] < 0) continue;
      diagonal[row[i]] += flows[e];
      if (row[j] < 0) right.row(row[i]) += flows[e] * colors.color[j].cast<double>().transpose();
      if (row[j] >= 0 && row[i] > row[j]) entries.emplace_back(row[i], row[j], -flows[e]);
    }
  }
  for (int i = 0; i < unknowns; ++i) entries.emplace_back(i, i, diagonal[i]);
  Eigen::SparseMatrix<double> matrix(unknowns, unknowns);
  matrix.setFromTriplets(entries.begin(), entries.end());
  const Eigen::MatrixXd solved =
      Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>(matrix).solve(right);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (row[v] >= 0) colors.color[v] = solved.row(row[v]).cast<float>().transpose();
}

/// The vertices' colours after spreading into those with low confidence. Iterative, since hues can
/// only be compared when all vertices have a colour.
VertexColors SpreadVertices(const Mesh& mesh, const VertexColors& read, const Vector3f& fallback) {
  constexpr int kRounds = 4;
  const std::vector<std::pair<int, int>> edges = UndirectedEdges(mesh.faces);
  std::vector<double> flows(edges.size(), 1);
  VertexColors spread = read;
  for (int round = 0; round < kRounds; ++round) {
    for (std::size_t e = 0; round > 0 && e < edges.size(); ++e)
      flows[e] = Flow(spread.color[edges[e].first], spread.color[edges[e].second]);
    spread = read;
    SpreadOverSurface(mesh, edges, flows, fallback, spread);
  }
  return spread;
}

Vector3f MeanPainted(const Painting& painting) {
  Vector3d sum = Vector3d::Zero();
  std::int64_t count = 0;
  for (std::size_t i = 0; i < painting.sure.size(); ++i) {
    if (!painting.sure[i]) continue;
    sum += painting.At(i).cast<double>();
    ++count;
  }
  return count > 0 ? (sum / static_cast<double>(count)).cast<float>().eval()
                   : Vector3f::Constant(0.5f);
}

}  // namespace

void CheckUvs(const Mesh& mesh) {
  if (!mesh.has_uvs())
    throw InputError(
        "bake: the mesh has no texture coordinates; pass the output of unwrap, or a registered "
        "mesh that kept the template's UVs");
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int t = mesh.uv_faces(f, k);
      if (t < 0 || t >= mesh.uvs.rows())
        throw InputError("bake: face " + std::to_string(f) + " names texture coordinate " +
                         std::to_string(t) + ", but the mesh has " +
                         std::to_string(mesh.uvs.rows()) + "; the file is damaged");
      const auto uv = mesh.uvs.row(t);
      if (!(uv.minCoeff() >= -1e-6 && uv.maxCoeff() <= 1 + 1e-6))
        throw InputError(
            "bake: face " + std::to_string(f) + " has texture coordinates (" +
            std::to_string(uv[0]) + ", " + std::to_string(uv[1]) +
            ") outside 0..1; tiled or several-page layouts cannot be baked: unwrap the mesh again");
    }
}

Vector3d TexelTriangle::Barycentric(const Vector2d& q) const {
  const double w1 = Cross(q - p[0], p[2] - p[0]) / twice_area,
               w2 = Cross(p[1] - p[0], q - p[0]) / twice_area;
  return {1 - w1 - w2, w1, w2};
}

Vector3d TexelTriangle::ClosestOnOutline(const Vector2d& q, double& squared_distance) const {
  int side = 0;
  double along = 0;
  squared_distance = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const Vector2d edge = p[(k + 1) % 3] - p[k];
    const double length2 = edge.squaredNorm();
    const double t = length2 > 0 ? std::clamp((q - p[k]).dot(edge) / length2, 0.0, 1.0) : 0;
    const double d2 = (p[k] + t * edge - q).squaredNorm();
    if (d2 >= squared_distance) continue;
    squared_distance = d2;
    side = k;
    along = t;
  }
  Vector3d weights = Vector3d::Zero();
  weights[side] = 1 - along;
  weights[(side + 1) % 3] = along;
  return weights;
}

Vector3f Atlas::Weights(std::size_t texel) const {
  const Vector2d center(static_cast<double>(texel % size) + 0.5,
                        static_cast<double>(texel / size) + 0.5);
  const TexelTriangle& triangle = triangles[face[texel]];
  double d2;
  return (inside[texel] ? triangle.Barycentric(center) : triangle.ClosestOnOutline(center, d2))
      .cast<float>();
}

Atlas RasterizeAtlas(const Mesh& mesh, int size) {
  CheckUvs(mesh);
  Atlas atlas;
  atlas.size = size;
  const std::size_t count = static_cast<std::size_t>(size) * size;
  atlas.face.assign(count, -1);
  atlas.inside.assign(count, 0);
  for (int f = 0; f < mesh.face_count(); ++f) atlas.triangles.push_back(TriangleOf(mesh, f, size));
  std::vector<std::int64_t> texels((size + kRows - 1) / kRows, 0);
  ParallelBlocks(size, kRows, [&](std::int64_t begin, std::int64_t end) {
    Band band(atlas, static_cast<int>(begin), static_cast<int>(end));
    band.FillInsides();
    band.AddRims();
    texels[begin / kRows] = band.texels();
  });
  for (const std::int64_t some : texels) atlas.texels += some;
  if (atlas.texels == 0)
    throw InputError("bake: the texture coordinates cover not one texel of " +
                     std::to_string(size) + " x " + std::to_string(size) +
                     "; unwrap the mesh again");
  return atlas;
}

TexelBox TexelsAround(const Atlas& atlas, int face) {
  return BoxOf(atlas.triangles[face], atlas.size, 1);
}

VertexColors ReadVertices(const Mesh& mesh, const Atlas& atlas, const Painting& painting) {
  std::vector<CornerSums> corners(mesh.face_count());
  ParallelFor(
      mesh.face_count(),
      [&](std::int64_t f) { corners[f] = SumCorners(atlas, painting, static_cast<int>(f)); }, 64);
  std::vector<Eigen::Matrix<float, 5, 1>> sums(mesh.vertex_count(),
                                               Eigen::Matrix<float, 5, 1>::Zero());
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) sums[mesh.faces(f, k)] += corners[f].col(k);
  VertexColors read;
  for (const auto& sum : sums) {
    const bool known = sum[3] > 1e-6f;
    read.color.push_back(known ? (sum.head<3>() / sum[3]).eval() : Vector3f::Zero());
    read.sure.push_back(known ? sum[3] / sum[4] : 0);
  }
  return read;
}

void InpaintUnseen(const Mesh& mesh, const Atlas& atlas, Painting& painting) {
  const VertexColors vertices =
      SpreadVertices(mesh, ReadVertices(mesh, atlas, painting), MeanPainted(painting));
  const auto smooth = [&](std::size_t texel) {
    const Vector3f w = atlas.Weights(texel);
    const auto f = mesh.faces.row(atlas.face[texel]);
    return (w[0] * vertices.color[f[0]] + w[1] * vertices.color[f[1]] + w[2] * vertices.color[f[2]])
        .eval();
  };
  const auto kept = [&](std::size_t texel) {
    return std::min(1.0f,
                    InpaintTuning::kKeptOfSure * static_cast<float>(painting.sure[texel]) / 255);
  };
  // The difference of a painted texel from the smooth colour is continued a little way into the
  // unseen part, so that no edge is visible. Up to the end unseen texels contain this difference
  // only.
  std::vector<char> done(painting.sure.size());
  std::vector<std::pair<std::size_t, Vector3f>> unsure;
  for (std::size_t texel = 0; texel < done.size(); ++texel) {
    done[texel] = kept(texel) >= 1;
    if (done[texel] || !painting.sure[texel]) continue;
    unsure.emplace_back(texel, painting.At(texel));
    painting.At(texel).setZero();
  }
  const auto grain = [&](int texel) -> Vector3f {
    return kept(texel) >= 1 ? (painting.At(texel) - smooth(texel)).eval()
                            : Vector3f(painting.At(texel));
  };
  Grow(
      atlas.size, painting, done, 24, InpaintTuning::kDecay,
      [&](int texel) { return atlas.face[texel] >= 0; }, grain);
  ParallelFor(
      std::ssize(atlas.face),
      [&](std::int64_t texel) {
        if (atlas.face[texel] >= 0 && kept(texel) < 1)
          painting.At(texel) = (smooth(texel) + painting.At(texel)).cwiseMax(0.0f);
      },
      1 << 16);
  for (const auto& [texel, color] : unsure)
    painting.At(texel) += kept(texel) * (color - painting.At(texel));
}

ImageF FinishTexture(const Atlas& atlas, Painting&& given, int gutter) {
  Painting painting = std::move(given);
  const Vector3f rest = MeanPainted(painting);
  std::vector<char> done(painting.sure.size());
  for (std::size_t texel = 0; texel < done.size(); ++texel) done[texel] = atlas.face[texel] >= 0;
  Grow(
      atlas.size, painting, done, gutter, 1.0f, [](int) { return true; },
      [&](int texel) -> Vector3f { return painting.At(texel); });
  ParallelFor(
      std::ssize(done),
      [&](std::int64_t texel) {
        if (!done[texel]) painting.At(texel) = rest;
      },
      1 << 16);
  return std::move(painting.color);
}

Image8 SrgbImage(const ImageF& linear) {
  Image8 srgb(linear.width, linear.height, linear.channels);
  ParallelBlocks(std::ssize(linear.data), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) srgb.data[i] = SrgbOf(linear.data[i]);
  });
  return srgb;
}

}  // namespace keypose
