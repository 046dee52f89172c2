// Editing of a closed triangle mesh: edge splits, collapses and flips, and vertex moves. They keep
// the mesh closed and turn no face over.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/values/mesh.h"

namespace CGAL {
template <typename P>
class Surface_mesh;
class SM_Vertex_index;
class SM_Edge_index;
class SM_Face_index;
class SM_Halfedge_index;
}  // namespace CGAL

namespace keypose::cleanup {

using SurfaceMesh = CGAL::Surface_mesh<Eigen::Vector3d>;
using Vertex = CGAL::SM_Vertex_index;
using Edge = CGAL::SM_Edge_index;
using Face = CGAL::SM_Face_index;
using Halfedge = CGAL::SM_Halfedge_index;

/// Smallest angle of a triangle. [rad]
double MinAngle(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c);

/// A mesh with a wanted edge length (size) at each vertex. Edits return whether they were done.
class Editor {
  std::unique_ptr<SurfaceMesh> owned_;  // before `mesh`, which refers to it

 public:
  explicit Editor(const Mesh& closed);
  ~Editor();
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  SurfaceMesh& mesh;
  std::vector<double> sizes;  ///< by vertex index

  double Length(Edge e) const;
  double Relative(Edge e) const;  ///< length over the wanted length
  /// Splits the edge at its midpoint and returns the new vertex.
  Vertex Split(Edge e);
  /// Collapses the edge to the end or the midpoint that is nearest to the planes of the surrounding
  /// faces. Refused when an edge would become longer than `longest` times its wanted length.
  bool Collapse(Edge e, double longest);
  /// Flips the edge if the smallest angle of the two faces grows and the fold between them does not
  /// get sharper.
  bool Flip(Edge e);
  /// Flips the edge if no angle becomes smaller than `least_angle` [rad] and no face is turned
  /// over.
  bool FlipTo(Edge e, double least_angle);
  bool Move(Vertex v, const Eigen::Vector3d& to);
  /// Flips, collapses and moves that remove angles below `least_deg`.
  void MendThinFaces(double least_deg, int rounds);
  /// Twice the face's area times its normal.
  Eigen::Vector3d Cross(Face f) const;
  Eigen::Vector3d Normal(Vertex v) const;
  /// Smallest angle [rad] of a face, or of the faces around a vertex.
  double Angle(Face f) const;
  double Angle(Vertex v) const;

 private:
  bool StarHolds(Vertex v, const Eigen::Vector3d& to, Vertex ignored) const;
  double PlaneError(Vertex v, const Eigen::Vector3d& x) const;
};

}  // namespace keypose::cleanup
