#include "core/surfaces/self_intersections.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>
#include <CGAL/intersections.h>

#include <array>
#include <string>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/mesh_checks.h"

namespace keypose {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using Corners = std::array<Point, 3>;
using Box =
    CGAL::Box_intersection_d::Box_with_info_d<double, 3, int,
                                              CGAL::Box_intersection_d::ID_FROM_BOX_ADDRESS>;

// CGAL's own choice for meshes: up to this number of boxes, all pairs are tested.
constexpr std::ptrdiff_t kFewBoxes = 2000;
constexpr std::int64_t kGrain = 256;

Kernel::Triangle_3 TriangleOf(const Corners& c) { return {c[0], c[1], c[2]}; }

bool OnSegment(const Point& a, const Point& b, const Point& x) {
  return CGAL::collinear(a, b, x) && CGAL::collinear_are_ordered_along_line(a, x, b);
}

/// The two end points of three collinear points.
std::array<Point, 2> Ends(const Corners& p) {
  for (int k = 0; k < 3; ++k)
    if (CGAL::collinear_are_ordered_along_line(p[(k + 1) % 3], p[k], p[(k + 2) % 3]))
      return {p[(k + 1) % 3], p[(k + 2) % 3]};
  return {p[0], p[1]};
}

/// Tests two triangles of which at least one is degenerate (a segment or a point). CGAL's test does
/// not accept these.
bool DegenerateMeet(const Corners& a, bool a_flat, const Corners& b, bool b_flat) {
  if (!a_flat) return DegenerateMeet(b, b_flat, a, a_flat);
  const auto [a0, a1] = Ends(a);
  if (!b_flat) {
    const Kernel::Triangle_3 t = TriangleOf(b);
    return a0 == a1 ? t.has_on(a0) : CGAL::do_intersect(t, Kernel::Segment_3(a0, a1));
  }
  const auto [b0, b1] = Ends(b);
  if (a0 == a1) return b0 == b1 ? a0 == b0 : OnSegment(b0, b1, a0);
  if (b0 == b1) return OnSegment(a0, a1, b0);
  return CGAL::do_intersect(Kernel::Segment_3(a0, a1), Kernel::Segment_3(b0, b1));
}

/// The faces of one mesh, with tests of which pairs intersect.
class Triangles {
 public:
  Triangles(const PointsX3& points, const FacesX3& faces, TouchingFaces touching);
  /// Calls visit(a, b) for each two faces that can be a pair because their boxes intersect, and
  /// visit(a, a) for each face that is a pair with itself. Always in the same order.
  template <class Visit>
  void Candidates(const Visit& visit) const;
  bool Meet(int a, int b) const;

 private:
  struct Shared {
    int count = 0;
    int last_a = -1, last_b = -1;  // corners
    int free_a = 3, free_b = 3;    // sums of the corners that are not shared
  };
  Shared SharedCorners(int a, int b) const;
  bool MeetBeyondEdge(int a, int b, const Shared& shared) const;
  bool MeetBeyondVertex(int a, int b, const Shared& shared) const;

  const FacesX3& faces_;
  TouchingFaces touching_;
  std::vector<Corners> corners_;
  std::vector<char> flat_;
};

Triangles::Triangles(const PointsX3& points, const FacesX3& faces, TouchingFaces touching)
    : faces_(faces), touching_(touching), corners_(faces.rows()), flat_(faces.rows()) {
  RequireIndices(points.rows(), faces, "self-intersections");
  RequireFinite(points, "self-intersections");
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    Corners& c = corners_[f];
    for (int k = 0; k < 3; ++k) {
      const auto p = points.row(faces(f, k));
      c[k] = Point(p[0], p[1], p[2]);
    }
    flat_[f] = CGAL::collinear(c[0], c[1], c[2]);
  }
}

template <class Visit>
void Triangles::Candidates(const Visit& visit) const {
  std::vector<Box> boxes;
  boxes.reserve(corners_.size());
  for (int f = 0; f < std::ssize(corners_); ++f) {
    const Corners& c = corners_[f];
    if (flat_[f] && touching_ == TouchingFaces::kCounted)
      visit(f, f);
    else
      boxes.emplace_back(c[0].bbox() + c[1].bbox() + c[2].bbox(), f);
  }
  std::vector<const Box*> pointers;
  pointers.reserve(boxes.size());
  for (const Box& box : boxes) pointers.push_back(&box);
  const auto take = [&](const Box* a, const Box* b) {
    const bool can_meet =
        touching_ == TouchingFaces::kCounted || SharedCorners(a->info(), b->info()).count == 0;
    if (can_meet) visit(a->info(), b->info());
  };
  CGAL::box_self_intersection_d(pointers.begin(), pointers.end(), take,
                                CGAL::Box_intersection_d::Box_traits_d<const Box*>(), kFewBoxes);
}

Triangles::Shared Triangles::SharedCorners(int a, int b) const {
  Shared shared;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      if (faces_(a, i) != faces_(b, j)) continue;
      ++shared.count;
      shared.last_a = i;
      shared.last_b = j;
      shared.free_a -= i;
      shared.free_b -= j;
    }
  return shared;
}

/// Two faces that share an edge overlap only when they are folded flat onto each other.
bool Triangles::MeetBeyondEdge(int a, int b, const Shared& shared) const {
  const Corners& c = corners_[a];
  const int tip = shared.free_a;
  const Point &from = c[(tip + 1) % 3], &to = c[(tip + 2) % 3];
  const Point& other_tip = corners_[b][shared.free_b];
  return CGAL::coplanar(from, to, c[tip], other_tip) &&
         CGAL::coplanar_orientation(from, to, c[tip], other_tip) == CGAL::POSITIVE;
}

/// Two faces that share a vertex also meet elsewhere when the opposite edge of one of them meets
/// the other.
bool Triangles::MeetBeyondVertex(int a, int b, const Shared& shared) const {
  const Corners &p = corners_[a], &q = corners_[b];
  const Kernel::Segment_3 p_side(p[(shared.last_a + 1) % 3], p[(shared.last_a + 2) % 3]);
  const Kernel::Segment_3 q_side(q[(shared.last_b + 1) % 3], q[(shared.last_b + 2) % 3]);
  return CGAL::do_intersect(TriangleOf(p), q_side) || CGAL::do_intersect(TriangleOf(q), p_side);
}

bool Triangles::Meet(int a, int b) const {
  if (a == b) return true;
  const Shared shared = SharedCorners(a, b);
  if (shared.count == 1) return MeetBeyondVertex(a, b, shared);
  if (shared.count == 2) return MeetBeyondEdge(a, b, shared);
  if (shared.count > 2) return true;
  if (flat_[a] || flat_[b]) return DegenerateMeet(corners_[a], flat_[a], corners_[b], flat_[b]);
  return CGAL::do_intersect(TriangleOf(corners_[a]), TriangleOf(corners_[b]));
}

}  // namespace

SelfIntersections FindSelfIntersections(const PointsX3& points, const FacesX3& faces,
                                        TouchingFaces touching) {
  const Triangles triangles(points, faces, touching);
  std::vector<std::pair<int, int>> candidates;
  triangles.Candidates([&](int a, int b) { candidates.emplace_back(a, b); });
  std::vector<char> meet(candidates.size());
  ParallelFor(
      std::ssize(candidates),
      [&](std::int64_t i) { meet[i] = triangles.Meet(candidates[i].first, candidates[i].second); },
      kGrain);
  SelfIntersections found;
  std::vector<char> met(faces.rows(), 0);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    if (!meet[i]) continue;
    ++found.pairs;
    met[candidates[i].first] = met[candidates[i].second] = 1;
  }
  for (int f = 0; f < std::ssize(met); ++f)
    if (met[f]) found.faces.push_back(f);
  return found;
}

bool HasSelfIntersections(const PointsX3& points, const FacesX3& faces, TouchingFaces touching) {
  struct Found {};  // an exception is the only way to end CGAL's box search early
  const Triangles triangles(points, faces, touching);
  try {
    triangles.Candidates([&](int a, int b) {
      if (triangles.Meet(a, b)) throw Found();
    });
  } catch (const Found&) {
    return true;
  }
  return false;
}

}  // namespace keypose
