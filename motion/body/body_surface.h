// The surface of the kinematic template: sixteen closed segments made of rings, as one mesh.
#pragma once

#include <array>
#include <vector>

#include "core/values/mesh.h"
#include "motion/body/body_pose.h"

namespace keypose::motion {

inline constexpr int kRings = 15;   ///< between a segment's two poles
inline constexpr int kAround = 16;  ///< vertices of a ring
inline constexpr int kSegmentVertices = kRings * kAround + 2;
inline constexpr int kBodyVertices = kSegments * kSegmentVertices;

/// Vertex of a segment by ring and angle. The poles are the segment's last two vertices.
inline int RingVertex(int ring, int around) {
  return ring * kAround + (around + kAround) % kAround;
}

/// Vertices and normals in their joints' frames.
struct LocalSurface {
  std::array<PointsX3, kSegments> points, normals;  ///< kSegmentVertices x 3
};
LocalSurface SurfaceOf(const BodyShape& shape);

/// Faces of all segments; vertex v of segment s has the number s * kSegmentVertices + v.
const FacesX3& BodyFaces();
/// Faces of one segment, in its own vertices' numbers.
const FacesX3& SegmentFaces();
/// All vertices in the world.
PointsX3 BodyPoints(const LocalSurface& surface, const PosedBody& body);

/// Adds w^T d(x)/d(lengths) and w^T d(x)/d(radii) of a vertex in its joint's frame.
/// @param w       in the joint's frame
/// @param weight  factor on what is added
/// @param lengths kLengths numbers
/// @param radii   kStations * kHarmonics numbers of the segment, station after station
void AddSurfaceRow(int segment, int vertex, const Eigen::Vector3d& w, double weight,
                   double* lengths, double* radii);

}  // namespace keypose::motion
