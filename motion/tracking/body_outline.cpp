#include "motion/tracking/body_outline.h"

#include <cmath>

namespace keypose::motion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Beyond a contour point, so many cells outwards, no other segment may be seen.
constexpr double kOutward = 1.3;

std::vector<std::array<int, 3>> DrawnTriangles(int ring_step, int around_step) {
  std::vector<std::array<int, 3>> triangles;
  const int first = kSegmentVertices - 2, last = kSegmentVertices - 1;
  for (int a = 0; a < kAround; a += around_step) {
    const int b = a + around_step;
    triangles.push_back({first, RingVertex(0, b), RingVertex(0, a)});
    for (int r = 0; r < kRings - 1; r += ring_step) {
      const int next = std::min(r + ring_step, kRings - 1);
      triangles.push_back({RingVertex(r, a), RingVertex(r, b), RingVertex(next, b)});
      triangles.push_back({RingVertex(r, a), RingVertex(next, b), RingVertex(next, a)});
    }
    triangles.push_back({last, RingVertex(kRings - 1, a), RingVertex(kRings - 1, b)});
  }
  return triangles;
}

internal::DrawnSurface MakeDrawn(int ring_step, int around_step) {
  internal::DrawnSurface drawn{DrawnTriangles(ring_step, around_step), {}};
  std::array<bool, kSegmentVertices> used = {};
  for (const std::array<int, 3>& triangle : drawn.triangles)
    for (const int v : triangle) used[v] = true;
  for (int v = 0; v < kSegmentVertices; ++v)
    if (used[v]) drawn.vertices.push_back(v);
  return drawn;
}

/// Moves points of one segment into a silhouette's pixels.
class SegmentProjector {
 public:
  SegmentProjector(const Silhouette& silhouette, const PosedBody& body, int joint)
      : k_(silhouette.pinhole),
        rotation_(silhouette.camera_from_world.rotation.toRotationMatrix() * body.rotation[joint]),
        offset_(silhouette.camera_from_world * body.position[joint]) {}

  void operator()(const PointsX3& points, int v, int row, ProjectedBody* projected) const {
    const Vector3d x = rotation_ * points.row(v).transpose() + offset_;
    if (x.z() < 0.05) projected->before_camera = false;
    const double inverse = 1 / std::max(x.z(), 0.05);
    projected->pixels.row(row) << k_.fx * x.x() * inverse + k_.cx, k_.fy * x.y() * inverse + k_.cy;
  }

 private:
  const Pinhole& k_;
  Eigen::Matrix3d rotation_;
  Vector3d offset_;
};

/// Looks for contour points of one segment.
class ContourFinder {
 public:
  ContourFinder(const Silhouette& silhouette, const LocalSurface& surface, const PosedBody& body,
                const ProjectedBody& projected, const SegmentRaster& raster, int segment,
                std::vector<OutlineSample>* samples)
      : silhouette_(silhouette),
        points_(surface.points[segment]),
        normals_(surface.normals[segment]),
        body_(body),
        projected_(projected),
        raster_(raster),
        segment_(segment),
        joint_(Segments()[segment].joint),
        samples_(samples) {
    // The camera's place in the joint's frame: then no vertex has to be moved.
    eye_ = body.rotation[joint_].transpose() * (silhouette.center - body.position[joint_]);
    for (int v = 0; v < kSegmentVertices; ++v) facing_[v] = Normal(v).dot(eye_ - Point(v));
  }

  void Find() {
    for (int r = 0; r < kRings; ++r)
      for (int a = 0; a < kAround; ++a) {
        Cross(RingVertex(r, a), RingVertex(r, a + 1), RingLength(r, a));
        const int next = r + 1 < kRings ? RingVertex(r + 1, a) : kSegmentVertices - 1;
        Cross(RingVertex(r, a), next, AroundLength(r, a));
        if (r == 0) Cross(kSegmentVertices - 2, RingVertex(0, a), AroundLength(0, a));
      }
  }

 private:
  Vector3d Point(int v) const { return points_.row(v).transpose(); }
  Vector3d Normal(int v) const { return normals_.row(v).transpose(); }
  Vector2d Pixel(int v) const {
    return projected_.pixels.row(segment_ * kSegmentVertices + v).transpose();
  }
  /// Half of the way from the ring before to the ring after, in the picture.
  double RingLength(int r, int a) const {
    const int before = r > 0 ? RingVertex(r - 1, a) : kSegmentVertices - 2;
    const int after = r + 1 < kRings ? RingVertex(r + 1, a) : kSegmentVertices - 1;
    return (Pixel(after) - Pixel(before)).norm() / 2;
  }
  double AroundLength(int r, int a) const {
    return (Pixel(RingVertex(r, a + 1)) - Pixel(RingVertex(r, a - 1))).norm() / 2;
  }

  void Cross(int a, int b, double length) {
    if ((facing_[a] > 0) == (facing_[b] > 0)) return;
    OutlineSample sample;
    sample.share = facing_[a] / (facing_[a] - facing_[b]);
    sample.segment = segment_;
    sample.a = a;
    sample.b = b;
    sample.length = length;
    const auto mix = [&](const Vector3d& p, const Vector3d& q) {
      return Vector3d((1 - sample.share) * p + sample.share * q);
    };
    sample.local = mix(Point(a), Point(b));
    sample.world = body_.ToWorld(joint_, sample.local);
    const Vector3d normal = body_.rotation[joint_] * mix(Normal(a), Normal(b));
    const Vector3d in_camera = silhouette_.camera_from_world.rotation * normal;
    // A line of the picture has the coordinates K^-T n.
    sample.normal =
        Vector2d(in_camera.x() / silhouette_.pinhole.fx, in_camera.y() / silhouette_.pinhole.fy);
    const double size = sample.normal.norm();
    if (!(size > 0)) return;
    sample.normal /= size;
    sample.pixel = silhouette_.Project(sample.world);
    const Vector2d beyond = sample.pixel + kOutward * SegmentRaster::kCell * sample.normal;
    if (raster_.At(beyond) & ~(1u << segment_)) return;
    samples_->push_back(sample);
  }

  const Silhouette& silhouette_;
  const PointsX3& points_;
  const PointsX3& normals_;
  const PosedBody& body_;
  const ProjectedBody& projected_;
  const SegmentRaster& raster_;
  int segment_, joint_;
  std::vector<OutlineSample>* samples_;
  Vector3d eye_;
  std::array<double, kSegmentVertices> facing_;
};

}  // namespace

namespace internal {
const DrawnSurface& Drawn(Detail detail) {
  static const DrawnSurface fine = MakeDrawn(2, 1), coarse = MakeDrawn(4, 2);
  return detail == Detail::kFine ? fine : coarse;
}
}  // namespace internal

std::uint16_t SegmentRaster::At(const Vector2d& pixel) const {
  const Vector2d cell = CellOf(pixel);
  const int x = static_cast<int>(std::lround(cell.x())),
            y = static_cast<int>(std::lround(cell.y()));
  if (x < 0 || y < 0 || x >= width || y >= height) return 0;
  return bits[static_cast<std::size_t>(y) * width + x];
}

ProjectedBody Project(const Silhouette& silhouette, const LocalSurface& surface,
                      const PosedBody& body, std::uint32_t segments) {
  ProjectedBody projected;
  projected.pixels.resize(kBodyVertices, 2);
  for (int s = 0; s < kSegments; ++s) {
    if (!(segments >> s & 1)) continue;
    const SegmentProjector project(silhouette, body, Segments()[s].joint);
    for (int v = 0; v < kSegmentVertices; ++v)
      project(surface.points[s], v, s * kSegmentVertices + v, &projected);
  }
  return projected;
}

void ProjectDrawn(const Silhouette& silhouette, const LocalSurface& surface, const PosedBody& body,
                  int segment, Detail detail, ProjectedBody* projected) {
  const SegmentProjector project(silhouette, body, Segments()[segment].joint);
  for (const int v : internal::Drawn(detail).vertices)
    project(surface.points[segment], v, segment * kSegmentVertices + v, projected);
}

SegmentRaster MakeRaster(const Silhouette& silhouette) {
  SegmentRaster raster;
  raster.width = silhouette.pinhole.width / SegmentRaster::kCell + 2 * SegmentRaster::kMargin;
  raster.height = silhouette.pinhole.height / SegmentRaster::kCell + 2 * SegmentRaster::kMargin;
  raster.bits.assign(static_cast<std::size_t>(raster.width) * raster.height, 0);
  return raster;
}

void Draw(const ProjectedBody& projected, std::uint32_t segments, SegmentRaster* raster) {
  for (int s = 0; s < kSegments; ++s) {
    if (!(segments >> s & 1)) continue;
    const auto bit = static_cast<std::uint16_t>(1u << s);
    VisitSpans(*raster, projected, s, Detail::kFine, [&](int first, int end) {
      for (int cell = first; cell < end; ++cell) raster->bits[cell] |= bit;
    });
  }
}

std::vector<std::uint8_t> MaskCells(const Silhouette& silhouette, const SegmentRaster& raster) {
  std::vector<std::uint8_t> cells(raster.bits.size(), 0);
  const MaskField& field = silhouette.field;
  for (int y = 0; y < raster.height; ++y)
    for (int x = 0; x < raster.width; ++x) {
      const int px = (x - SegmentRaster::kMargin) * SegmentRaster::kCell;
      const int py = (y - SegmentRaster::kMargin) * SegmentRaster::kCell;
      if (px < 0 || py < 0 || px + 1 >= field.width || py + 1 >= field.height) continue;
      const float sum =
          field.At(px, py) + field.At(px + 1, py) + field.At(px, py + 1) + field.At(px + 1, py + 1);
      cells[static_cast<std::size_t>(y) * raster.width + x] = sum < 0;
    }
  return cells;
}

std::vector<OutlineSample> FindOutline(const Silhouette& silhouette, const LocalSurface& surface,
                                       const PosedBody& body, const ProjectedBody& projected,
                                       const SegmentRaster& raster) {
  std::vector<OutlineSample> samples;
  for (int s = 0; s < kSegments; ++s)
    ContourFinder(silhouette, surface, body, projected, raster, s, &samples).Find();
  return samples;
}

}  // namespace keypose::motion
