// A closed triangle mesh that is edited: splits, collapses, flips and moves that keep it closed and
// turn no face over.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/mesh.h"

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

/// Positions are the mesh's points; sizes, the wanted edge lengths, ride along. Each edit says
/// whether it was done.
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
  double Relative(Edge e) const;  ///< over the wanted length there
  /// In the middle; returns the new vertex.
  Vertex Split(Edge e);
  /// To the end or the middle that lies nearest to the planes around; no edge gets longer than
  /// `longest` of its size.
  bool Collapse(Edge e, double longest);
  /// When the smaller angle of the two faces grows and the fold between them does not.
  bool Flip(Edge e);
  /// When the other diagonal can be: no angle below the least [rad], no face turned.
  bool FlipTo(Edge e, double least_angle);
  bool Move(Vertex v, const Eigen::Vector3d& to);
  /// Flips, collapses and shifts for angles below `least_deg`.
  void MendThinFaces(double least_deg, int rounds);
  /// Twice the face's area times its normal.
  Eigen::Vector3d Cross(Face f) const;
  Eigen::Vector3d Normal(Vertex v) const;
  /// Smallest angle of a face, and of the faces around a vertex. [rad]
  double Angle(Face f) const;
  double Angle(Vertex v) const;

 private:
  bool StarHolds(Vertex v, const Eigen::Vector3d& to, Vertex ignored) const;
  double PlaneError(Vertex v, const Eigen::Vector3d& x) const;
};

}  // namespace keypose::cleanup
