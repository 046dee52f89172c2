// Measures of triangle meshes: size, area, volume, normals, and whether they are closed.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/mesh.h"

namespace keypose {

double BoundingDiagonal(const PointsX3& points);  ///< 0 for no points
double SurfaceArea(const PointsX3& points, const FacesX3& faces);
double SignedVolume(const PointsX3& points,
                    const FacesX3& faces);  ///< positive for closed, outward oriented meshes
Eigen::VectorXd FaceAreas(const PointsX3& points, const FacesX3& faces);  ///< F
PointsX3 FaceNormals(const PointsX3& points,
                     const FacesX3& faces);  ///< F x 3 unit; zero for faces without area
PointsX3 VertexNormals(
    const PointsX3& points,
    const FacesX3& faces);  ///< V x 3 unit, area weighted; zero for unused vertices
std::vector<std::pair<int, int>> UndirectedEdges(const FacesX3& faces);  ///< unique (i < j), sorted
std::vector<char> BoundaryVertices(
    int vertex_count,
    const FacesX3& faces);  ///< 1 where an edge of the vertex has not exactly two faces

/// Counts of what keeps a mesh from being a closed, oriented 2-manifold of positive volume; the
/// same rules as the field's checkers use.
struct ClosedReport {
  int bad_edges = 0;  ///< directed edges without exactly one opposite
  int bad_fans = 0;   ///< vertices whose faces form more or less than one closed fan
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

/// `count` points uniform by area on the surface, with the face that each lies on. Deterministic
/// for a seed.
struct SurfaceSamples {
  PointsX3 points;
  std::vector<int> faces;
};
SurfaceSamples SampleSurface(const PointsX3& points, const FacesX3& faces, int count,
                             std::uint64_t seed);

}  // namespace keypose
