#include "register/quality/self_intersections.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/intersections.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <string>

#include "core/errors.h"
#include "core/parallel.h"

namespace keypose::registration {

namespace {

using Eigen::Vector3d;
using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;

constexpr int kLeafFaces = 4;
constexpr int kGrain = 64;
constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

struct Box {
  Vector3d low = Vector3d::Constant(std::numeric_limits<double>::infinity());
  Vector3d high = Vector3d::Constant(-std::numeric_limits<double>::infinity());
  void Add(const Vector3d& p) {
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  void Add(const Box& b) {
    low = low.cwiseMin(b.low);
    high = high.cwiseMax(b.high);
  }
  bool Meets(const Box& b) const {
    return (low.array() <= b.high.array()).all() && (b.low.array() <= high.array()).all();
  }
};

/// A triangle with the plane through it and the bound of that plane's rounding error.
struct Triangle {
  std::array<Vector3d, 3> p;
  std::array<int, 3> vertex{};
  Vector3d normal;
  double size2 = 0;  // largest coordinate of one edge times that of another
  Box box;

  /// Side of the plane that x lies on: -1 or 1 when certain, else 0.
  int Side(const Vector3d& x) const {
    const Vector3d w = x - p[0];
    const double d = normal.dot(w);
    // 48 half-epsilons bound the roundings of the differences, the cross product and the dot
    // product.
    const double bound =
        32 * kEpsilon * size2 * w.cwiseAbs().maxCoeff() + std::numeric_limits<double>::min();
    return d > bound ? 1 : d < -bound ? -1 : 0;
  }
};

/// Sign of the volume of a, b, c, d: -1 or 1 when certain, else 0.
int Orientation(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  const Vector3d u = b - a, v = c - a, w = d - a;
  const double volume = u.cross(v).dot(w);
  const double bound =
      32 * kEpsilon * u.cwiseAbs().maxCoeff() * v.cwiseAbs().maxCoeff() * w.cwiseAbs().maxCoeff() +
      std::numeric_limits<double>::min();
  return volume > bound ? 1 : volume < -bound ? -1 : 0;
}

enum class Answer { kNo, kYes, kUnsure };

/// Whether segment ab, whose ends lie on different sides of the triangle's plane, passes through
/// the triangle.
Answer Pierces(const Vector3d& a, const Vector3d& b, const Triangle& t) {
  const int s0 = Orientation(a, b, t.p[0], t.p[1]), s1 = Orientation(a, b, t.p[1], t.p[2]);
  if (s0 * s1 < 0) return Answer::kNo;
  const int s2 = Orientation(a, b, t.p[2], t.p[0]);
  if (s0 * s2 < 0 || s1 * s2 < 0) return Answer::kNo;
  return s0 != 0 && s1 != 0 && s2 != 0 ? Answer::kYes : Answer::kUnsure;
}

bool GapAlong(const Vector3d& axis, const Triangle& s, const Triangle& t, double extent) {
  double low[2], high[2];
  for (int side = 0; side < 2; ++side) {
    const Triangle& u = side ? t : s;
    const double x0 = axis.dot(u.p[0] - s.p[0]), x1 = axis.dot(u.p[1] - s.p[0]),
                 x2 = axis.dot(u.p[2] - s.p[0]);
    low[side] = std::min({x0, x1, x2});
    high[side] = std::max({x0, x1, x2});
  }
  const double bound = 16 * kEpsilon * axis.cwiseAbs().maxCoeff() * extent;
  return low[1] - high[0] > bound || low[0] - high[1] > bound;
}

/// Whether a clear gap along some axis proves that they are apart. Catches nearly coplanar
/// neighbours, which exact arithmetic would slow down.
bool ClearlyApart(const Triangle& s, const Triangle& t) {
  const double extent =
      (s.box.high.cwiseMax(t.box.high) - s.box.low.cwiseMin(t.box.low)).maxCoeff();
  if (GapAlong(s.normal, s, t, extent) || GapAlong(t.normal, s, t, extent)) return true;
  for (int i = 0; i < 3; ++i) {
    const Vector3d e = s.p[(i + 1) % 3] - s.p[i], f = t.p[(i + 1) % 3] - t.p[i];
    if (GapAlong(s.normal.cross(e), s, t, extent) || GapAlong(t.normal.cross(f), s, t, extent))
      return true;
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (GapAlong((s.p[(i + 1) % 3] - s.p[i]).cross(t.p[(j + 1) % 3] - t.p[j]), s, t, extent))
        return true;
  return false;
}

Kernel::Point_3 ExactPoint(const Vector3d& p) { return {p.x(), p.y(), p.z()}; }

bool OnSegment(const Kernel::Point_3& a, const Kernel::Point_3& b, const Kernel::Point_3& x) {
  return CGAL::collinear(a, b, x) && CGAL::collinear_are_ordered_along_line(a, x, b);
}

/// The two ends that are farthest along of three collinear points.
std::array<Kernel::Point_3, 2> Ends(const std::array<Kernel::Point_3, 3>& p) {
  for (int k = 0; k < 3; ++k)
    if (CGAL::collinear_are_ordered_along_line(p[(k + 1) % 3], p[k], p[(k + 2) % 3]))
      return {p[(k + 1) % 3], p[(k + 2) % 3]};
  return {p[0], p[1]};
}

/// At least one of the two is a segment or a point, which CGAL's own test does not take.
bool ExactlyMeetDegenerate(const std::array<Kernel::Point_3, 3>& a, bool a_flat,
                           const std::array<Kernel::Point_3, 3>& b, bool b_flat) {
  if (!a_flat) return ExactlyMeetDegenerate(b, b_flat, a, a_flat);
  const auto [a0, a1] = Ends(a);
  if (!b_flat) {
    const Kernel::Triangle_3 t(b[0], b[1], b[2]);
    return a0 == a1 ? t.has_on(a0) : CGAL::do_intersect(t, Kernel::Segment_3(a0, a1));
  }
  const auto [b0, b1] = Ends(b);
  if (a0 == a1) return b0 == b1 ? a0 == b0 : OnSegment(b0, b1, a0);
  if (b0 == b1) return OnSegment(a0, a1, b0);
  return CGAL::do_intersect(Kernel::Segment_3(a0, a1), Kernel::Segment_3(b0, b1));
}

bool ExactlyMeet(const Triangle& s, const Triangle& t) {
  const std::array<Kernel::Point_3, 3> a = {ExactPoint(s.p[0]), ExactPoint(s.p[1]),
                                            ExactPoint(s.p[2])};
  const std::array<Kernel::Point_3, 3> b = {ExactPoint(t.p[0]), ExactPoint(t.p[1]),
                                            ExactPoint(t.p[2])};
  const bool a_flat = CGAL::collinear(a[0], a[1], a[2]), b_flat = CGAL::collinear(b[0], b[1], b[2]);
  if (a_flat || b_flat) return ExactlyMeetDegenerate(a, a_flat, b, b_flat);
  return CGAL::do_intersect(Kernel::Triangle_3(a[0], a[1], a[2]),
                            Kernel::Triangle_3(b[0], b[1], b[2]));
}

/// Two triangles in general position meet if and only if an edge of one passes through the other.
Answer MeetInDoubles(const Triangle& s, const Triangle& t) {
  std::array<int, 3> side[2];
  for (int k = 0; k < 3; ++k) side[0][k] = t.Side(s.p[k]);
  const auto one_sided = [](const std::array<int, 3>& x) {
    return x[0] != 0 && x[0] == x[1] && x[1] == x[2];
  };
  if (one_sided(side[0])) return Answer::kNo;
  for (int k = 0; k < 3; ++k) side[1][k] = s.Side(t.p[k]);
  if (one_sided(side[1])) return Answer::kNo;
  for (const auto& x : side)
    if (x[0] == 0 || x[1] == 0 || x[2] == 0) return Answer::kUnsure;
  bool unsure = false;
  for (int which = 0; which < 2; ++which) {
    const Triangle& edges = which ? t : s;
    const Triangle& face = which ? s : t;
    for (int k = 0; k < 3; ++k) {
      if (side[which][k] == side[which][(k + 1) % 3]) continue;
      const Answer answer = Pierces(edges.p[k], edges.p[(k + 1) % 3], face);
      if (answer == Answer::kYes) return answer;
      unsure = unsure || answer == Answer::kUnsure;
    }
  }
  return unsure ? Answer::kUnsure : Answer::kNo;
}

bool ShareVertex(const Triangle& s, const Triangle& t) {
  for (int a : s.vertex)
    for (int b : t.vertex)
      if (a == b) return true;
  return false;
}

/// For triangles whose boxes meet.
bool Meet(const Triangle& s, const Triangle& t) {
  if (ShareVertex(s, t)) return false;
  const Answer answer = MeetInDoubles(s, t);
  if (answer != Answer::kUnsure) return answer == Answer::kYes;
  return !ClearlyApart(s, t) && ExactlyMeet(s, t);
}

/// Faces in a balanced tree of boxes: node n has children 2n+1 and 2n+2; all leaves are on the last
/// level.
struct BoxTree {
  std::vector<int> order;  // faces, leaf by leaf
  std::vector<Box> boxes;  // of nodes
  int first_leaf = 0, leaves = 1;

  std::int64_t Begin(int leaf) const {
    return static_cast<std::int64_t>(order.size()) * leaf / leaves;
  }

  explicit BoxTree(const std::vector<Triangle>& triangles) : order(triangles.size()) {
    while (static_cast<std::size_t>(leaves) * kLeafFaces < triangles.size()) leaves *= 2;
    first_leaf = leaves - 1;
    boxes.resize(2 * static_cast<std::size_t>(leaves) - 1);
    std::vector<Vector3d> centers(triangles.size());
    for (std::size_t f = 0; f < triangles.size(); ++f) {
      order[f] = static_cast<int>(f);
      centers[f] = triangles[f].box.low + triangles[f].box.high;
    }
    Split(0, 0, leaves, centers);
    for (int leaf = 0; leaf < leaves; ++leaf)
      for (std::int64_t i = Begin(leaf); i < Begin(leaf + 1); ++i)
        boxes[first_leaf + leaf].Add(triangles[order[i]].box);
    for (int n = first_leaf - 1; n >= 0; --n) {
      boxes[n].Add(boxes[2 * n + 1]);
      boxes[n].Add(boxes[2 * n + 2]);
    }
  }

  void Split(int node, int leaf_begin, int leaf_end, const std::vector<Vector3d>& centers) {
    if (leaf_end - leaf_begin == 1) return;
    const int middle = (leaf_begin + leaf_end) / 2;
    Box spread;
    for (std::int64_t i = Begin(leaf_begin); i < Begin(leaf_end); ++i)
      spread.Add(centers[order[i]]);
    int axis = 0;
    (spread.high - spread.low).maxCoeff(&axis);
    std::nth_element(
        order.begin() + Begin(leaf_begin), order.begin() + Begin(middle),
        order.begin() + Begin(leaf_end), [&](int a, int b) {
          return centers[a][axis] != centers[b][axis] ? centers[a][axis] < centers[b][axis] : a < b;
        });
    Split(2 * node + 1, leaf_begin, middle, centers);
    Split(2 * node + 2, middle, leaf_end, centers);
  }

  /// Calls visit(leaf) for each leaf from `leaf` on whose box meets its box.
  template <class Visit>
  void LeavesMeeting(int leaf, const Visit& visit) const {
    const Box& box = boxes[first_leaf + leaf];
    std::array<int, 64> stack;
    std::array<int, 64> last;  // last leaf under the node
    int depth = 0;
    stack[0] = 0;
    last[0] = leaves;
    int level_leaves[64];
    level_leaves[0] = leaves;
    while (depth >= 0) {
      const int node = stack[depth], end = last[depth], under = level_leaves[depth];
      --depth;
      if (end <= leaf || !boxes[node].Meets(box)) continue;
      if (under == 1) {
        visit(node - first_leaf);
        continue;
      }
      for (int child = 0; child < 2; ++child) {
        ++depth;
        stack[depth] = 2 * node + 2 - child;
        last[depth] = child == 0 ? end : end - under / 2;
        level_leaves[depth] = under / 2;
      }
    }
  }
};

std::vector<Triangle> MakeTriangles(const PointsX3& points, const FacesX3& faces) {
  std::vector<Triangle> triangles(faces.rows());
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    Triangle& t = triangles[f];
    for (int k = 0; k < 3; ++k) {
      const int v = faces(f, k);
      if (v < 0 || v >= points.rows())
        throw InputError("self-intersections: face " + std::to_string(f) + " names vertex " +
                         std::to_string(v) + ", but there are " + std::to_string(points.rows()));
      t.p[k] = points.row(v);
      if (!t.p[k].allFinite())
        throw InputError("self-intersections: vertex " + std::to_string(v) + " is not finite");
      t.vertex[k] = v;
      t.box.Add(t.p[k]);
    }
    const Vector3d u = t.p[1] - t.p[0], v = t.p[2] - t.p[0];
    t.normal = u.cross(v);
    t.size2 = u.cwiseAbs().maxCoeff() * v.cwiseAbs().maxCoeff();
  }
  return triangles;
}

}  // namespace

SelfIntersections FindSelfIntersections(const PointsX3& points, const FacesX3& faces) {
  const std::vector<Triangle> triangles = MakeTriangles(points, faces);
  SelfIntersections found;
  if (triangles.empty()) return found;
  const BoxTree tree(triangles);
  std::vector<Box> boxes;  // leaf by leaf, so that neighbours lie together in memory
  boxes.reserve(triangles.size());
  for (int f : tree.order) boxes.push_back(triangles[f].box);
  std::vector<std::vector<std::array<int, 2>>> by_leaf(tree.leaves);
  const auto compare_leaves = [&](int leaf, int other) {
    const Box& other_box = tree.boxes[tree.first_leaf + other];
    for (std::int64_t i = tree.Begin(leaf); i < tree.Begin(leaf + 1); ++i) {
      if (!boxes[i].Meets(other_box)) continue;
      for (std::int64_t j = other == leaf ? i + 1 : tree.Begin(other); j < tree.Begin(other + 1);
           ++j) {
        const int a = tree.order[i], b = tree.order[j];
        if (boxes[i].Meets(boxes[j]) && Meet(triangles[a], triangles[b]))
          by_leaf[leaf].push_back({a, b});
      }
    }
  };
  ParallelBlocks(tree.leaves, kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (int leaf = static_cast<int>(begin); leaf < end; ++leaf)
      tree.LeavesMeeting(leaf, [&](int other) { compare_leaves(leaf, other); });
  });
  std::vector<char> met(triangles.size(), 0);
  for (const auto& pairs : by_leaf) {
    found.pairs += static_cast<std::int64_t>(pairs.size());
    for (const auto& [a, b] : pairs) met[a] = met[b] = 1;
  }
  for (std::size_t f = 0; f < met.size(); ++f)
    if (met[f]) found.faces.push_back(static_cast<int>(f));
  return found;
}

}  // namespace keypose::registration
