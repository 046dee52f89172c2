#include "texture/bake/bake_scan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "views/atlas/atlas.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr int kSmallest = 256, kLargest = 4096;  // px
constexpr int kMostSamples = 4;                  // along a texel's side
constexpr double kAtOnce = 0.05;                 // of the reach: as good as on the scan
// Beside the scan's border, the way to the closest point leads along the surface. From here on the
// cosine with its normal says that the scan goes on there.
constexpr double kBeside = 0.4, kAbove = 0.8;
constexpr int kParts = 40;                   // of the texture, for the progress
constexpr std::int64_t kTexelsAtOnce = 512;  // by one thread
constexpr float kGrey = 0.2f;                // where there is no scan, in linear light
constexpr int kAsked = 2000;      // vertices, for the side that the scan's faces are seen from
constexpr int kMostSurfaces = 4;  // that a ray passes through
constexpr double kStep = 1e-3;    // of the reach, from one of them to the next
constexpr int kSurely = 3;        // times as many votes

struct ScanColor {
  Vector3f color = Vector3f::Zero();  // linear light
  double sure = 0;                    // in [0, 1]
};

/// The colour of a texture, bilinear; beyond its border it repeats.
Vector3f ColorAt(const Image8& texture, const Vector2d& uv) {
  const double u = uv.x() - std::floor(uv.x()), v = uv.y() - std::floor(uv.y());
  const double x = std::clamp(u * texture.width - 0.5, 0.0, texture.width - 1.0),
               y = std::clamp((1 - v) * texture.height - 0.5, 0.0, texture.height - 1.0);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y),
            x1 = std::min(x0 + 1, texture.width - 1), y1 = std::min(y0 + 1, texture.height - 1);
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  const auto at = [&](int column, int row) {
    const std::uint8_t* p = texture.at(column, row);
    return Vector3f(LinearOf(p[0]), LinearOf(p[1]), LinearOf(p[2]));
  };
  return (1 - fy) * ((1 - fx) * at(x0, y0) + fx * at(x1, y0)) +
         fy * ((1 - fx) * at(x0, y1) + fx * at(x1, y1));
}

class ScanSampler {
 public:
  ScanSampler(const Mesh& scan, const Image8& texture, double reach)
      : scan_(scan),
        texture_(texture),
        rays_(scan.points, scan.faces),
        normals_(FaceNormals(scan.points, scan.faces)),
        reach_(reach) {}

  /// Of scans whose faces look inwards, the side that the mesh's normals tell. On thin parts the
  /// closest point may be the other side's, so that votes must be clear.
  void FaceAs(const Mesh& mesh, const PointsX3& normals) {
    int same = 0, other = 0;
    const int step = std::max(1, mesh.vertex_count() / kAsked);
    for (int v = 0; v < mesh.vertex_count(); v += step) {
      const RayScene::Foot foot = rays_.ClosestPoint(mesh.points.row(v).transpose(), reach_);
      if (foot.face < 0) continue;
      (normals_.row(foot.face).dot(normals.row(v)) >= 0 ? same : other) += 1;
    }
    if (other > kSurely * same) normals_ = -normals_;
  }

  ScanColor At(const Vector3d& point, const Vector3d& normal) const {
    const RayScene::Foot foot = rays_.ClosestPoint(point, reach_);
    if (foot.face < 0) return {};
    const Vector3d facing = normals_.row(foot.face).transpose();
    if (facing.dot(normal) <= 0) return Along(point, normal);
    const double distance = std::sqrt(foot.squared_distance), near = distance / reach_;
    double sure = 1 - near * near;
    if (near > kAtOnce) {
      const double above = std::abs((point - foot.point).dot(facing)) / distance;
      sure *= std::clamp((above - kBeside) / (kAbove - kBeside), 0.0, 1.0);
    }
    return {ColorOf(foot.face, foot.barycentric), sure};
  }

 private:
  /// Where a thin part's other side is closer: the closest point that faces the same way, up or
  /// down the normal.
  ScanColor Along(const Vector3d& point, const Vector3d& normal) const {
    ScanColor best;
    double closest = std::numeric_limits<double>::infinity();
    for (const double side : {1.0, -1.0}) {
      const RayScene::Hit hit = FirstFacing(point, side * normal, normal);
      if (hit.face < 0 || hit.distance >= closest) continue;
      closest = hit.distance;
      const double near = hit.distance / reach_;
      best = {ColorOf(hit.face, {1 - hit.u - hit.v, hit.u, hit.v}), 1 - near * near};
    }
    return best;
  }

  RayScene::Hit FirstFacing(const Vector3d& point, const Vector3d& direction,
                            const Vector3d& normal) const {
    double from = 0;
    for (int surface = 0; surface < kMostSurfaces; ++surface) {
      const RayScene::Hit hit = rays_.Cast(point, direction, from, reach_);
      if (hit.face < 0 || normals_.row(hit.face).dot(normal.transpose()) > 0) return hit;
      from = hit.distance + kStep * reach_;
    }
    return {};
  }

  Vector3f ColorOf(int face, const Vector3d& weights) const {
    if (!texture_.empty()) {
      Vector2d uv = Vector2d::Zero();
      for (int k = 0; k < 3; ++k)
        uv += weights[k] * scan_.uvs.row(scan_.uv_faces(face, k)).transpose();
      return ColorAt(texture_, uv);
    }
    Vector3f color = Vector3f::Zero();
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 3; ++c)
        color[c] +=
            static_cast<float>(weights[k]) * LinearOf(scan_.colors(scan_.faces(face, k), c));
    return color;
  }

  const Mesh& scan_;
  const Image8& texture_;
  RayScene rays_;
  PointsX3 normals_;
  double reach_;
};

double UvArea(const Mesh& mesh) {
  double area = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const Vector2d a = mesh.uvs.row(mesh.uv_faces(f, 0)).transpose(),
                   b = mesh.uvs.row(mesh.uv_faces(f, 1)).transpose() - a,
                   c = mesh.uvs.row(mesh.uv_faces(f, 2)).transpose() - a;
    area += 0.5 * std::abs(b.x() * c.y() - b.y() * c.x());
  }
  return area;
}

/// The size [px] at which the mesh has as many texels as the scan has, on the same area.
double SizeOfScan(const Mesh& mesh, const Mesh& scan, const Image8& texture) {
  const double texels = texture.empty() ? static_cast<double>(scan.points.rows())
                                        : UvArea(scan) * texture.width * texture.height,
               area = SurfaceArea(scan.points, scan.faces), layout = UvArea(mesh);
  if (area <= 0 || layout <= 0) return 0;
  constexpr double kEnough = 1e6;  // of scans that are all but points
  return std::min(kEnough,
                  std::sqrt(texels / area * SurfaceArea(mesh.points, mesh.faces) / layout));
}

int PowerOfTwo(double wanted) {
  int size = kSmallest;
  while (size < kLargest && 1.1 * size < wanted) size *= 2;
  return size;
}

/// Paints the texels of an atlas.
class ScanPainter {
 public:
  ScanPainter(const Mesh& mesh, const Atlas& atlas, const ScanSampler& scan, int samples)
      : mesh_(mesh),
        atlas_(atlas),
        scan_(scan),
        normals_(VertexNormals(mesh.points, mesh.faces)),
        samples_(samples) {}

  /// The mean over the texel, of what the scan shows there.
  ScanColor Texel(std::size_t texel) const {
    if (!atlas_.inside[texel] || samples_ == 1)
      return Point(atlas_.face[texel], atlas_.Weights(texel).cast<double>());
    const auto size = static_cast<std::size_t>(atlas_.size);
    const Vector2d corner(static_cast<double>(texel % size), static_cast<double>(texel / size));
    const TexelTriangle& triangle = atlas_.triangles[atlas_.face[texel]];
    Vector3d color = Vector3d::Zero();
    double sure = 0;
    for (int i = 0; i < samples_; ++i)
      for (int j = 0; j < samples_; ++j) {
        const Vector2d at = corner + (Vector2d(i, j).array() + 0.5).matrix() / samples_;
        const Vector3d weights = triangle.Barycentric(at).cwiseMax(0);
        const ScanColor sample = Point(atlas_.face[texel], weights / weights.sum());
        color += sample.sure * sample.color.cast<double>();
        sure += sample.sure;
      }
    if (sure <= 0) return {};
    return {(color / sure).cast<float>(), sure / (samples_ * samples_)};
  }

 private:
  ScanColor Point(int face, const Vector3d& weights) const {
    Vector3d point = Vector3d::Zero(), normal = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      point += weights[k] * mesh_.points.row(mesh_.faces(face, k)).transpose();
      normal += weights[k] * normals_.row(mesh_.faces(face, k)).transpose();
    }
    return scan_.At(point, normal.stableNormalized());
  }

  const Mesh& mesh_;
  const Atlas& atlas_;
  const ScanSampler& scan_;
  PointsX3 normals_;
  int samples_;
};

void PaintAtlas(const Atlas& atlas, const ScanPainter& painter, Painting& painting,
                Progress* progress) {
  const std::int64_t count = std::ssize(atlas.face), part = (count + kParts - 1) / kParts;
  for (std::int64_t begin = 0; begin < count; begin += part) {
    ReportProgress(progress, 0.05 + 0.75 * static_cast<double>(begin) / static_cast<double>(count),
                   "colours of the scan");
    ParallelFor(
        std::min(part, count - begin),
        [&](std::int64_t i) {
          const std::size_t texel = begin + i;
          if (atlas.face[texel] < 0) return;
          const ScanColor sample = painter.Texel(texel);
          painting.At(texel) = sample.color;
          painting.sure[texel] = static_cast<std::uint8_t>(std::lround(255 * sample.sure));
        },
        kTexelsAtOnce);
  }
}

/// Nothing is known anywhere.
ScanBake Left(int size, ScanBake result) {
  result.linear = ImageF(size, size, 3, kGrey);
  result.texture = SrgbImage(result.linear);
  return result;
}

}  // namespace

ScanBake BakeScan(const Mesh& mesh, const Mesh& scan, const Image8& texture,
                  const ScanBakeOptions& options, Progress* progress) {
  CheckUvs(mesh);
  if (!texture.empty() && !scan.has_uvs())
    throw InputError(
        "bake: the scan has a texture, but no texture coordinates; pass the mesh as its scanning "
        "program wrote it");
  const double wanted = SizeOfScan(mesh, scan, texture);
  ScanBake result;
  result.advised_size = PowerOfTwo(wanted);
  const int size = options.texture_size > 0 ? options.texture_size : result.advised_size;
  const Atlas atlas = RasterizeAtlas(mesh, size);
  result.texels = atlas.texels;
  result.confidence = Image8(size, size, 1);
  if (texture.empty() && scan.colors.rows() == 0) return Left(size, std::move(result));
  ScanSampler sampler(scan, texture, options.reach * BoundingDiagonal(mesh.points));
  sampler.FaceAs(mesh, VertexNormals(mesh.points, mesh.faces));
  const int samples = std::clamp(static_cast<int>(std::lround(wanted / size)), 1, kMostSamples);
  Painting painting(size);
  PaintAtlas(atlas, ScanPainter(mesh, atlas, sampler, samples), painting, progress);
  for (std::size_t texel = 0; texel < atlas.face.size(); ++texel)
    result.seen_texels += atlas.inside[texel] && painting.sure[texel] > 0;
  if (result.seen_texels == 0) return Left(size, std::move(result));
  ReportProgress(progress, 0.8, "unseen texels and gutters");
  result.confidence.data = painting.sure;
  InpaintUnseen(mesh, atlas, painting);
  result.linear = FinishTexture(atlas, std::move(painting), options.gutter);
  result.texture = SrgbImage(result.linear);
  return result;
}

}  // namespace keypose::texture
