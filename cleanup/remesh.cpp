#include "cleanup/remesh.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/remesh.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Bounded_normal_change_filter.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/LindstromTurk_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <cmath>

#include "cleanup/cgal_convert.h"
#include "core/geometry.h"

namespace keypose::cleanup {
namespace {

namespace PMP = CGAL::Polygon_mesh_processing;
namespace SMS = CGAL::Surface_mesh_simplification;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using SurfaceMesh = CGAL::Surface_mesh<Kernel::Point_3>;

// The collapse engine counts edges; boundary edges make faces and edges differ from 2:3, so faces are counted here.
struct FaceCountStop {
  std::size_t faces;
  template <class Cost, class Profile>
  bool operator()(const Cost&, const Profile& profile, std::size_t, std::size_t) const {
    return profile.surface_mesh().number_of_faces() <= faces;
  }
};

}  // namespace

Mesh Decimated(const Mesh& manifold, int faces, bool even) {
  SurfaceMesh mesh = ToSurfaceMesh<SurfaceMesh>(manifold);
  const FaceCountStop stop{static_cast<std::size_t>(faces)};
  const SMS::Bounded_normal_change_filter<> filter;
  const SMS::LindstromTurk_placement<SurfaceMesh> placement;
  if (even) {
    SMS::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(SMS::Edge_length_cost<SurfaceMesh>()).get_placement(placement).filter(filter));
  } else {
    SMS::edge_collapse(mesh, stop,
                       CGAL::parameters::get_cost(SMS::LindstromTurk_cost<SurfaceMesh>()).get_placement(placement).filter(filter));
  }
  mesh.collect_garbage();
  return FromSurfaceMesh(mesh);
}

Mesh UniformlyRemeshed(const Mesh& closed, int faces, int iterations) {
  SurfaceMesh mesh = ToSurfaceMesh<SurfaceMesh>(closed);
  // Equilateral triangles of this edge would cover the area exactly.
  const double edge = std::sqrt(4 / std::sqrt(3.0) * SurfaceArea(closed.points, closed.faces) / faces);
  PMP::isotropic_remeshing(CGAL::faces(mesh), edge, mesh, CGAL::parameters::number_of_iterations(iterations).number_of_relaxation_steps(3));
  mesh.collect_garbage();
  return FromSurfaceMesh(mesh);
}

}  // namespace keypose::cleanup
