#include "motion/body/body_surface.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/angles.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

/// The share of the way from a segment's first pole to its last, closer together at the poles.
double AlongOf(int ring) { return (1 - std::cos(kPi * (ring + 1) / (kRings + 1))) / 2; }

/// 1 in the middle and 0 at the poles: segments end in round caps.
double CapOf(double along) { return std::sqrt(1 - std::pow(std::abs(2 * along - 1), 6)); }

/// What a vertex is made of: position = origin + axial * axis + (sum of value * radius) * outward.
struct VertexModel {
  double along = 0;  ///< 0 first pole, 1 last pole
  int station = 0;   ///< the radii of this and the next station count
  double next = 0;   ///< share of the next one
  double cap = 0;
  double angle = 0;
  std::array<double, kHarmonics> waves;
};

std::array<VertexModel, kSegmentVertices> MakeVertices() {
  std::array<VertexModel, kSegmentVertices> vertices;
  for (int ring = 0; ring < kRings; ++ring)
    for (int around = 0; around < kAround; ++around) {
      VertexModel& v = vertices[RingVertex(ring, around)];
      v.along = AlongOf(ring);
      v.cap = CapOf(v.along);
      const double at = v.along * (kStations - 1);
      v.station = std::min(static_cast<int>(at), kStations - 2);
      v.next = at - v.station;
      v.angle = 2 * kPi * around / kAround;
      v.waves[0] = 1;
      for (int m = 1; 2 * m < kHarmonics; ++m) {
        v.waves[2 * m - 1] = std::cos(m * v.angle);
        v.waves[2 * m] = std::sin(m * v.angle);
      }
    }
  vertices[kSegmentVertices - 2] = {0, 0, 0, 0, 0, {}};
  vertices[kSegmentVertices - 1] = {1, kStations - 2, 1, 0, 0, {}};
  return vertices;
}

const std::array<VertexModel, kSegmentVertices>& Vertices() {
  static const std::array<VertexModel, kSegmentVertices> vertices = MakeVertices();
  return vertices;
}

Vector3d Outward(const SegmentModel& segment, double angle) {
  return std::cos(angle) * segment.side + std::sin(angle) * segment.axis.cross(segment.side);
}

Vector3d VertexPoint(const SegmentModel& segment, const VertexModel& v, const BodyShape& shape,
                     const Eigen::Matrix<double, kStations, kHarmonics>& radii) {
  const double length = shape.lengths[segment.length] + segment.behind + segment.beyond;
  double radius = 0;
  for (int m = 0; m < kHarmonics; ++m)
    radius += v.waves[m] * ((1 - v.next) * radii(v.station, m) + v.next * radii(v.station + 1, m));
  return segment.origin + (v.along * length - segment.behind) * segment.axis +
         v.cap * radius * Outward(segment, v.angle);
}

FacesX3 MakeSegmentFaces() {
  std::vector<Eigen::Vector3i> faces;
  const int first = kSegmentVertices - 2, last = kSegmentVertices - 1;
  for (int a = 0; a < kAround; ++a) {
    faces.emplace_back(first, RingVertex(0, a + 1), RingVertex(0, a));
    for (int r = 0; r + 1 < kRings; ++r) {
      const int v00 = RingVertex(r, a), v01 = RingVertex(r, a + 1);
      const int v10 = RingVertex(r + 1, a), v11 = RingVertex(r + 1, a + 1);
      faces.emplace_back(v00, v01, v11);
      faces.emplace_back(v00, v11, v10);
    }
    faces.emplace_back(last, RingVertex(kRings - 1, a), RingVertex(kRings - 1, a + 1));
  }
  FacesX3 matrix(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    matrix.row(static_cast<Eigen::Index>(f)) = faces[f];
  return matrix;
}

}  // namespace

LocalSurface SurfaceOf(const BodyShape& shape) {
  LocalSurface surface;
  for (int s = 0; s < kSegments; ++s) {
    surface.points[s].resize(kSegmentVertices, 3);
    for (int v = 0; v < kSegmentVertices; ++v)
      surface.points[s].row(v) = VertexPoint(Segments()[s], Vertices()[v], shape, shape.radii[s]);
    surface.normals[s] = VertexNormals(surface.points[s], SegmentFaces());
  }
  return surface;
}

const FacesX3& SegmentFaces() {
  static const FacesX3 faces = MakeSegmentFaces();
  return faces;
}

const FacesX3& BodyFaces() {
  static const FacesX3 faces = [] {
    const FacesX3& one = SegmentFaces();
    FacesX3 all(one.rows() * kSegments, 3);
    for (int s = 0; s < kSegments; ++s)
      all.middleRows(s * one.rows(), one.rows()) = one.array() + s * kSegmentVertices;
    return all;
  }();
  return faces;
}

PointsX3 BodyPoints(const LocalSurface& surface, const PosedBody& body) {
  PointsX3 points(kBodyVertices, 3);
  for (int s = 0; s < kSegments; ++s) {
    const int joint = Segments()[s].joint;
    points.middleRows(s * kSegmentVertices, kSegmentVertices) =
        (surface.points[s] * body.rotation[joint].transpose()).rowwise() +
        body.position[joint].transpose();
  }
  return points;
}

void AddSurfaceRow(int segment, int vertex, const Vector3d& w, double weight, double* lengths,
                   double* radii) {
  const SegmentModel& model = Segments()[segment];
  const VertexModel& v = Vertices()[vertex];
  lengths[model.length] += weight * v.along * w.dot(model.axis);
  const double outward = weight * v.cap * w.dot(Outward(model, v.angle));
  for (int m = 0; m < kHarmonics; ++m) {
    radii[v.station * kHarmonics + m] += outward * (1 - v.next) * v.waves[m];
    radii[(v.station + 1) * kHarmonics + m] += outward * v.next * v.waves[m];
  }
}

}  // namespace keypose::motion
