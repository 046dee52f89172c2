#include "register/skeleton/curve_skeleton.h"

// These are included before CGAL_ALLOCATOR is redefined, so that only the halfedge list uses our
// allocator, and no other class of CGAL.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/bbox.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Polygon_mesh_processing/measure.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Midpoint_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <cmath>
#include <cstddef>
#include <exception>
#include <iterator>
#include <memory>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "core/numbers/ordered_memory.h"
#include "core/values/tuned.h"
#include "register/skeleton/ray_patience.h"

// CGAL's contraction keeps edges in sets ordered by address. So addresses must be in order for
// results to be repeatable.
#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) keypose::OrderedAllocator<T>
#include <CGAL/Polyhedron_3.h>
#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) std::allocator<T>
#include <CGAL/Mean_curvature_flow_skeletonization.h>

namespace keypose::registration {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

// Many times the memory needed. Only pages that are used take real memory.
constexpr std::size_t kLeastBytes = 16 << 20, kBytesAFace = 8 << 10;

/// CGAL tests whether a point is inside by casting rays until one tells. Where none does, CGAL
/// would not end. This kernel makes the rays and throws after too many.
struct PatientKernel : Kernel {
  struct Construct_ray_3 : Kernel::Construct_ray_3 {
    using Base = Kernel::Construct_ray_3;
    Kernel::Ray_3 operator()(const Kernel::Point_3& from, const Kernel::Vector_3& along) const {
      const bool first =
          along.x() == 0 &&
          along.y() == 0;  // the first ray is vertical; others have random directions
      patience.Cast(first);
      return Base::operator()(from, along);
    }
    static thread_local RayPatience patience;
  };
  Construct_ray_3 construct_ray_3_object() const { return {}; }
};
thread_local RayPatience PatientKernel::Construct_ray_3::patience;

// Chosen by the error of the start from skeletons on a tentacle bent by 270 degrees
// (docs/decisions/ordered-memory.md). Sensitivity: docs/results/sensitivity.md.
struct CurveSkeletonTuning {
  KEYPOSE_TUNED(double, kMedial, 1);  // CGAL's weight of the pull to the middle
};

constexpr double kLeastVolume = 1e-9;   // over the cube of the diagonal
constexpr std::size_t kMostGrowth = 4;  // factor on the vertex count during contraction

template <class T>
constexpr bool kOrdered = false;
template <class Traits, class Items, template <class, class, class> class Hds>
constexpr bool kOrdered<CGAL::Polyhedron_3<Traits, Items, Hds, OrderedAllocator<int>>> = true;

Eigen::RowVector3d ToEigen(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// Builds the surface mesh.
/// @return what is wrong with it, or an empty string
std::string Build(const PointsX3& points, const FacesX3& faces, Surface& surface) {
  std::vector<Surface::Vertex_index> vertex(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    std::array<Surface::Vertex_index, 3> corners;
    for (int k = 0; k < 3; ++k) {
      Surface::Vertex_index& v = vertex[faces(f, k)];
      if (v == Surface::null_vertex())
        v = surface.add_vertex(
            {points(faces(f, k), 0), points(faces(f, k), 1), points(faces(f, k), 2)});
      corners[k] = v;
    }
    if (surface.add_face(corners[0], corners[1], corners[2]) == Surface::null_face())
      return "is not a manifold";
  }
  return "";
}

/// Closes each hole with a fan. The skeleton does not need a better cap.
void CapHoles(Surface& surface) {
  std::vector<Surface::Halfedge_index> holes;
  for (Surface::Halfedge_index h : surface.halfedges()) {
    if (!surface.is_border(h)) continue;
    // Each hole is handled once, at the first halfedge of its cycle.
    Surface::Halfedge_index least = h;
    for (Surface::Halfedge_index g = surface.next(h); g != h; g = surface.next(g))
      least = std::min(least, g);
    if (least == h) holes.push_back(h);
  }
  for (Surface::Halfedge_index h : holes) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    int count = 0;
    for (Surface::Halfedge_index g : CGAL::halfedges_around_face(h, surface)) {
      sum += ToEigen(surface.point(surface.target(g)));
      ++count;
    }
    CGAL::Euler::fill_hole(h, surface);
    const Surface::Halfedge_index centre = CGAL::Euler::add_center_vertex(h, surface);
    sum /= count;
    surface.point(surface.target(centre)) = {sum[0], sum[1], sum[2]};
  }
}

int CountComponents(const Surface& surface) {
  std::vector<char> seen(surface.num_vertices(), 0);
  std::vector<Surface::Vertex_index> stack;
  int count = 0;
  for (Surface::Vertex_index v : surface.vertices()) {
    if (seen[v]) continue;
    ++count;
    seen[v] = 1;
    stack.push_back(v);
    while (!stack.empty()) {
      const Surface::Vertex_index u = stack.back();
      stack.pop_back();
      for (Surface::Vertex_index w : CGAL::vertices_around_target(surface.halfedge(u), surface))
        if (!seen[w]) {
          seen[w] = 1;
          stack.push_back(w);
        }
    }
  }
  return count;
}

std::string Decimate(Surface& surface, int faces) {
  namespace sms = CGAL::Surface_mesh_simplification;
  if (static_cast<int>(surface.number_of_faces()) > faces) {
    const sms::Count_stop_predicate<Surface> stop(static_cast<std::size_t>(faces) * 3 / 2);
    sms::edge_collapse(surface, stop,
                       CGAL::parameters::get_cost(sms::Edge_length_cost<Surface>())
                           .get_placement(sms::Midpoint_placement<Surface>()));
    surface.collect_garbage();
  }
  return surface.number_of_faces() < 20 ? "is too coarse" : "";
}

std::string Prepare(const PointsX3& points, const FacesX3& faces, int proxy_faces,
                    Surface& surface) {
  if (std::string fault = Build(points, faces, surface); !fault.empty()) return fault;
  CapHoles(surface);
  if (const int parts = CountComponents(surface); parts != 1)
    return "has " + std::to_string(parts) + " separate parts";
  const auto count = [](auto n) { return static_cast<long>(n); };
  const long euler = count(surface.number_of_vertices()) - count(surface.number_of_edges()) +
                     count(surface.number_of_faces());
  if (euler != 2)
    return "has " + std::to_string((2 - euler) / 2) + " handles (are touching parts merged?)";
  if (std::string fault = Decimate(surface, proxy_faces); !fault.empty()) return fault;
  // A mesh without volume has no inscribed balls, which CGAL relies on.
  const auto box = CGAL::Polygon_mesh_processing::bbox(surface);
  const double diagonal = Eigen::Vector3d(box.x_span(), box.y_span(), box.z_span()).norm();
  const double volume = CGAL::Polygon_mesh_processing::volume(surface);
  return std::abs(volume) > kLeastVolume * diagonal * diagonal * diagonal ? "" : "is flat";
}

/// Throws if a point is not finite: CGAL could not go on with it.
template <class Polyhedron>
void RequireFinite(const Polyhedron& meso_skeleton) {
  for (auto v = meso_skeleton.points_begin(); v != meso_skeleton.points_end(); ++v)
    if (!std::isfinite(v->x()) || !std::isfinite(v->y()) || !std::isfinite(v->z()))
      throw std::runtime_error("its positions are not finite");
}

/// The same as CGAL's contract_until_convergence, but it can be cancelled. It also stops when faces
/// split faster than they collapse, as on shapes without volume.
/// @throws Cancelled
/// @throws std::runtime_error  it does not converge
template <class Flow>
void Contract(Flow& flow, Progress* progress) {
  const auto area = [&] { return CGAL::Polygon_mesh_processing::area(flow.meso_skeleton()); };
  const std::size_t most_vertices = kMostGrowth * num_vertices(flow.meso_skeleton());
  const double whole = area();
  double before = 0;
  for (std::size_t round = 0; round < flow.max_iterations(); ++round) {
    if (progress && progress->cancelled()) throw Cancelled();
    flow.contract_geometry();
    RequireFinite(flow.meso_skeleton());
    flow.collapse_edges();
    flow.split_faces();
    flow.detect_degeneracies();
    const double now = area();
    if (std::abs(before - now) / whole < flow.area_variation_factor()) return;
    if (num_vertices(flow.meso_skeleton()) > most_vertices)
      throw std::runtime_error("its faces are split without end");
    before = now;
  }
}

}  // namespace

CurveSkeleton ExtractCurveSkeleton(const PointsX3& points, const FacesX3& faces, int proxy_faces,
                                   Progress* progress) {
  CurveSkeleton result;
  Surface surface;
  result.fault = Prepare(points, faces, proxy_faces, surface);
  if (!result.fault.empty()) return result;
  using Flow = CGAL::Mean_curvature_flow_skeletonization<Surface, PatientKernel>;
  static_assert(kOrdered<CGAL::Polyhedron_3<PatientKernel>>);
  const OrderedMemory memory(kLeastBytes + kBytesAFace * surface.number_of_faces());
  Flow::Skeleton skeleton;
  try {
    Flow flow(surface);
    // With the default of 0.2 the curve leaves thin limbs on the inner side of tight curls.
    flow.set_medially_centered_speed_tradeoff(CurveSkeletonTuning::kMedial);
    Contract(flow, progress);
    flow.convert_to_skeleton(skeleton);
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& e) {  // ours above, and CGAL's own checks if compiled in
    result.fault = std::string("could not be contracted: ") + e.what();
    return result;
  }
  result.nodes.resize(static_cast<Eigen::Index>(num_vertices(skeleton)), 3);
  result.surface.resize(static_cast<Eigen::Index>(surface.number_of_vertices()), 3);
  result.node_of.assign(surface.number_of_vertices(), 0);
  for (const auto node : CGAL::make_range(vertices(skeleton))) {
    result.nodes.row(node) = ToEigen(skeleton[node].point);
    for (const Surface::Vertex_index v : skeleton[node].vertices)
      result.node_of[v] = static_cast<int>(node);
  }
  for (const Surface::Vertex_index v : surface.vertices())
    result.surface.row(v.idx()) = ToEigen(surface.point(v));
  for (const auto edge : CGAL::make_range(edges(skeleton)))
    result.edges.push_back(
        {static_cast<int>(source(edge, skeleton)), static_cast<int>(target(edge, skeleton))});
  if (result.nodes.rows() < 4 || std::ssize(result.edges) + 1 != result.nodes.rows())
    result.fault = "has a skeleton that is not a tree";
  if (!result.nodes.allFinite()) result.fault = "could not be contracted";
  return result;
}

}  // namespace keypose::registration
