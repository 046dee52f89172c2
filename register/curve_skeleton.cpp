#include "register/curve_skeleton.h"

// Before the allocator below is named, so that it reaches the halfedge list alone and no other class of CGAL's.
#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/compute_normal.h>
#include <CGAL/Side_of_triangle_mesh.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Count_stop_predicate.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Edge_length_cost.h>
#include <CGAL/Surface_mesh_simplification/Policies/Edge_collapse/Midpoint_placement.h>
#include <CGAL/Surface_mesh_simplification/edge_collapse.h>

#include <cstddef>
#include <cstdlib>
#include <exception>
#include <map>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace keypose::registration {
namespace {

/// Memory whose addresses rise in the order of allocation. CGAL's contraction keeps edges in sets ordered by address, so that from the
/// ordinary heap its result would change from call to call.
class Arena {
 public:
  explicit Arena(std::size_t bytes) : size_(bytes), block_(static_cast<std::byte*>(std::malloc(bytes))) { current = this; }
  ~Arena() {
    current = nullptr;
    std::free(block_);
  }
  Arena(const Arena&) = delete;
  Arena& operator=(const Arena&) = delete;

  void* Take(std::size_t bytes) {
    bytes = (bytes + 15) / 16 * 16;
    std::vector<void*>& spare = spare_[bytes];
    if (!spare.empty()) {
      void* p = spare.back();
      spare.pop_back();
      return p;
    }
    if (!block_ || used_ + bytes > size_) throw std::bad_alloc();
    void* p = block_ + used_;
    used_ += bytes;
    return p;
  }
  void Give(void* p, std::size_t bytes) { spare_[(bytes + 15) / 16 * 16].push_back(p); }

  static thread_local Arena* current;

 private:
  std::size_t size_, used_ = 0;
  std::byte* block_;
  std::map<std::size_t, std::vector<void*>> spare_;
};
thread_local Arena* Arena::current = nullptr;

template <class T>
struct ArenaAllocator {
  using value_type = T;
  ArenaAllocator() = default;
  template <class U>
  ArenaAllocator(const ArenaAllocator<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(Arena::current->Take(n * sizeof(T))); }
  void deallocate(T* p, std::size_t n) { Arena::current->Give(p, n * sizeof(T)); }
  bool operator==(const ArenaAllocator&) const { return true; }
};

}  // namespace
}  // namespace keypose::registration

#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) keypose::registration::ArenaAllocator<T>
#include <CGAL/Polyhedron_3.h>
#undef CGAL_ALLOCATOR
#define CGAL_ALLOCATOR(T) std::allocator<T>
#include <CGAL/Mean_curvature_flow_skeletonization.h>

namespace keypose::registration {

namespace {

using Kernel = CGAL::Simple_cartesian<double>;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

constexpr std::size_t kArenaBytes = 16 << 20, kArenaBytesAFace = 8 << 10;  // many times what it takes; only what is used becomes real

constexpr double kMedial = 1;

template <class T>
constexpr bool kOrdered = false;
template <class Traits, class Items, template <class, class, class> class Hds>
constexpr bool kOrdered<CGAL::Polyhedron_3<Traits, Items, Hds, ArenaAllocator<int>>> = true;

Eigen::RowVector3d ToEigen(const Kernel::Point_3& p) { return {p.x(), p.y(), p.z()}; }

/// Says what is wrong, or nothing.
std::string Build(const PointsX3& points, const FacesX3& faces, Surface& surface) {
  std::vector<Surface::Vertex_index> vertex(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    std::array<Surface::Vertex_index, 3> corners;
    for (int k = 0; k < 3; ++k) {
      Surface::Vertex_index& v = vertex[faces(f, k)];
      if (v == Surface::null_vertex()) v = surface.add_vertex({points(faces(f, k), 0), points(faces(f, k), 1), points(faces(f, k), 2)});
      corners[k] = v;
    }
    if (surface.add_face(corners[0], corners[1], corners[2]) == Surface::null_face()) return "is not a manifold";
  }
  return "";
}

/// A fan over each hole: the skeleton does not need a better cap.
void CapHoles(Surface& surface) {
  std::vector<Surface::Halfedge_index> holes;
  for (Surface::Halfedge_index h : surface.halfedges()) {
    if (!surface.is_border(h)) continue;
    // One halfedge stands for its hole: the first of its cycle.
    Surface::Halfedge_index least = h;
    for (Surface::Halfedge_index g = surface.next(h); g != h; g = surface.next(g)) least = std::min(least, g);
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
                       CGAL::parameters::get_cost(sms::Edge_length_cost<Surface>()).get_placement(sms::Midpoint_placement<Surface>()));
    surface.collect_garbage();
  }
  return surface.number_of_faces() < 20 ? "is too coarse" : "";
}

std::string Prepare(const PointsX3& points, const FacesX3& faces, int proxy_faces, Surface& surface) {
  if (std::string fault = Build(points, faces, surface); !fault.empty()) return fault;
  CapHoles(surface);
  if (const int parts = CountComponents(surface); parts != 1) return "has " + std::to_string(parts) + " separate parts";
  const auto count = [](auto n) { return static_cast<long>(n); };
  const long euler = count(surface.number_of_vertices()) - count(surface.number_of_edges()) + count(surface.number_of_faces());
  if (euler != 2) return "has " + std::to_string((2 - euler) / 2) + " handles (parts that touch and are merged?)";
  return Decimate(surface, proxy_faces);
}

}  // namespace

CurveSkeleton ExtractCurveSkeleton(const PointsX3& points, const FacesX3& faces, int proxy_faces) {
  CurveSkeleton result;
  Surface surface;
  result.fault = Prepare(points, faces, proxy_faces, surface);
  if (!result.fault.empty()) return result;
  using Flow = CGAL::Mean_curvature_flow_skeletonization<Surface>;
  static_assert(kOrdered<CGAL::Polyhedron_3<Kernel>>);
  const Arena arena(kArenaBytes + kArenaBytesAFace * surface.number_of_faces());
  Flow::Skeleton skeleton;
  try {
    Flow flow(surface);
    // At the default of 0.2 the curve leaves thin limbs on the inner side of tight curls.
    flow.set_medially_centered_speed_tradeoff(kMedial);
    flow(skeleton);
  } catch (const std::exception& e) {  // of CGAL's own checks, where they are compiled in
    result.fault = std::string("could not be contracted: ") + e.what();
    return result;
  }
  result.nodes.resize(static_cast<Eigen::Index>(num_vertices(skeleton)), 3);
  result.surface.resize(static_cast<Eigen::Index>(surface.number_of_vertices()), 3);
  result.node_of.assign(surface.number_of_vertices(), 0);
  for (const auto node : CGAL::make_range(vertices(skeleton))) {
    result.nodes.row(static_cast<Eigen::Index>(node)) = ToEigen(skeleton[node].point);
    for (const Surface::Vertex_index v : skeleton[node].vertices) result.node_of[v] = static_cast<int>(node);
  }
  for (const Surface::Vertex_index v : surface.vertices())
    result.surface.row(static_cast<Eigen::Index>(v.idx())) = ToEigen(surface.point(v));
  for (const auto edge : CGAL::make_range(edges(skeleton)))
    result.edges.push_back({static_cast<int>(source(edge, skeleton)), static_cast<int>(target(edge, skeleton))});
  if (result.nodes.rows() < 4 || static_cast<Eigen::Index>(result.edges.size()) + 1 != result.nodes.rows())
    result.fault = "has no tree as its skeleton";
  if (!result.nodes.allFinite()) result.fault = "could not be contracted";
  return result;
}

}  // namespace keypose::registration
