// Measurements of triangle meshes: size, area, volume, normals, and whether they are closed.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Diagonal of the bounding box; 0 for no points.
double BoundingDiagonal(const PointsX3& points);
double SurfaceArea(const PointsX3& points, const FacesX3& faces);
/// Positive for closed meshes with faces oriented outwards.
double SignedVolume(const PointsX3& points, const FacesX3& faces);
/// @return F
Eigen::VectorXd FaceAreas(const PointsX3& points, const FacesX3& faces);
/// @return V; a third of the area of each vertex's faces
Eigen::VectorXd VertexAreas(const PointsX3& points, const FacesX3& faces);
/// @return F x 3, unit; zero for faces without area
PointsX3 FaceNormals(const PointsX3& points, const FacesX3& faces);
/// @return V x 3, unit, weighted by area; zero for vertices without a face
PointsX3 VertexNormals(const PointsX3& points, const FacesX3& faces);
/// @return each edge once, as (i, j) with i < j, sorted
std::vector<std::pair<int, int>> UndirectedEdges(const FacesX3& faces);
/// @return V; 1 where some edge of the vertex does not have exactly two faces
std::vector<char> BoundaryVertices(int vertex_count, const FacesX3& faces);

/// Counts everything that prevents a mesh from being a closed, oriented 2-manifold of positive
/// volume. The rules are those of common mesh checkers.
struct ClosedReport {
  int bad_edges = 0;  ///< directed edges that do not have exactly one opposite
  int bad_fans = 0;   ///< vertices whose faces do not form exactly one closed fan
  int unused_vertices = 0;
  int zero_area_faces = 0;  ///< twice the area <= 1e-14 diag^2
  int components = 0;
  int euler = 0;
  double volume = 0;
  bool finite = true;
  bool closed() const {
    return bad_edges == 0 && bad_fans == 0 && unused_vertices == 0 && zero_area_faces == 0 &&
           volume > 0 && finite;
  }
};
ClosedReport CheckClosed(const Mesh& mesh);

/// `count` points on the surface, distributed uniformly by area, and the face of each.
/// Deterministic for a given seed.
struct SurfaceSamples {
  PointsX3 points;
  std::vector<int> faces;
};
SurfaceSamples SampleSurface(const PointsX3& points, const FacesX3& faces, int count,
                             std::uint64_t seed);

}  // namespace keypose
