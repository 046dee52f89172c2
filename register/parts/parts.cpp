#include "register/parts/parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <queue>
#include <tuple>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "core/values/union_find.h"
#include "register/parts/part_points.h"

namespace keypose::registration {

namespace {

using Eigen::Vector3d;

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct LoosePartTuning {
  // of the part's size
  KEYPOSE_TUNED(double, kSoftFoot, 0.1);   // closer points have about equal weight
  KEYPOSE_TUNED(double, kRing, 0.5);       // distance to which anchors spread
  KEYPOSE_TUNED(double, kTouching, 0.05);  // parts farther apart do not sit on each other
  // weight of the anchors around the feet, over the feet's
  KEYPOSE_TUNED(double, kRingShare, 0.25);
  // largest factor between the scale of a part and that of the host
  KEYPOSE_TUNED(double, kMostScale, 1.25);
};

/// For each vertex the first vertex with the same position.
std::vector<int> Places(const PointsX3& points) {
  std::vector<int> order(static_cast<std::size_t>(points.rows())), place(order.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int v) { return std::tuple(points(v, 0), points(v, 1), points(v, 2)); };
  std::sort(order.begin(), order.end(),
            [&](int a, int b) { return at(a) != at(b) ? at(a) < at(b) : a < b; });
  for (std::size_t i = 0; i < order.size(); ++i)
    place[order[i]] = i > 0 && at(order[i]) == at(order[i - 1]) ? place[order[i - 1]] : order[i];
  return place;
}

/// The connected components of a mesh. Seams, where an edge occurs twice at the same position, do
/// not divide a component. Vertices that no face uses have component -1.
struct MeshParts {
  std::vector<int> of_vertex;
  std::vector<double> diagonal;

  explicit MeshParts(const Mesh& mesh) : of_vertex(mesh.vertex_count(), -1) {
    UnionFind joined(mesh.vertex_count());
    std::vector<char> used(mesh.vertex_count(), 0);
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
      joined.Join(mesh.faces(f, 0), mesh.faces(f, 1));
      joined.Join(mesh.faces(f, 0), mesh.faces(f, 2));
      for (int k = 0; k < 3; ++k) used[mesh.faces(f, k)] = 1;
    }
    int pieces = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) pieces += used[v] && joined.Find(v) == v;
    if (pieces > 1) JoinSeams(mesh, joined);
    std::vector<Eigen::AlignedBox3d> boxes;
    std::vector<int> id(mesh.vertex_count(), -1);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      if (!used[v]) continue;
      const int r = joined.Find(v);
      if (id[r] < 0) {
        id[r] = SizeOf(boxes);
        boxes.emplace_back();
      }
      of_vertex[v] = id[r];
      boxes[id[r]].extend(mesh.points.row(v).transpose());
    }
    for (const auto& box : boxes) diagonal.push_back(box.diagonal().norm());
  }

 private:
  static void JoinSeams(const Mesh& mesh, UnionFind& joined) {
    // At a seam both ends of an edge are repeated. A single repeated point only means that two
    // parts touch.
    const std::vector<int> place = Places(mesh.points);
    std::vector<std::array<int, 3>> edges;
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        const int a = mesh.faces(f, k), b = mesh.faces(f, (k + 1) % 3);
        edges.push_back({std::min(place[a], place[b]), std::max(place[a], place[b]), a});
      }
    std::sort(edges.begin(), edges.end());
    for (std::size_t i = 1; i < edges.size(); ++i)
      if (edges[i][0] == edges[i - 1][0] && edges[i][1] == edges[i - 1][1])
        joined.Join(edges[i][2], edges[i - 1][2]);
  }
};

/// A piece of the mesh that a loose part may sit on.
struct Seat {
  std::vector<int> faces;  // of the mesh
  FacesX3 corners;
  std::unique_ptr<RayScene> scene;  // built on first use
  Eigen::AlignedBox3d box;

  const RayScene& Scene(const Mesh& mesh) {
    if (!scene) {
      corners.resize(std::ssize(faces), 3);
      for (std::size_t i = 0; i < faces.size(); ++i) corners.row(i) = mesh.faces.row(faces[i]);
      scene = std::make_unique<RayScene>(mesh.points, corners);
    }
    return *scene;
  }
};

double MeanDistance(const RayScene& scene, const Mesh& mesh, const std::vector<int>& vertices) {
  double sum = 0;
  for (int v : vertices) sum += std::sqrt(scene.ClosestPoint(mesh.points.row(v)).squared_distance);
  return sum / static_cast<double>(vertices.size());
}

/// Distances along mesh edges from the given vertices, up to `reach`.
std::map<int, double> Around(const Mesh& mesh, const std::vector<std::vector<int>>& neighbors,
                             const std::map<int, double>& from, double reach) {
  std::map<int, double> distance;
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (const auto& [v, weight] : from) {
    distance[v] = 0;
    queue.emplace(0, v);
  }
  while (!queue.empty()) {
    const auto [d, v] = queue.top();
    queue.pop();
    if (d > distance[v]) continue;
    for (int u : neighbors[v]) {
      const double further = d + (mesh.points.row(u) - mesh.points.row(v)).norm();
      if (further > reach) continue;
      const auto [at, fresh] = distance.emplace(u, further);
      if (!fresh && further >= at->second) continue;
      at->second = further;
      queue.emplace(further, u);
    }
  }
  return distance;
}

/// Binds a part to the faces of its seat that are closest to it and, with less weight, to the
/// surface around them.
void Bind(const Mesh& mesh, const std::vector<std::vector<int>>& neighbors, Seat& seat,
          LoosePart& part) {
  std::map<int, double> weights;
  const double soft =
      std::max(LoosePartTuning::kSoftFoot * part.diagonal, std::numeric_limits<double>::min());
  double total = 0;
  for (int v : SomeOf(part.vertices, kFeet)) {
    const RayScene::Foot foot = seat.Scene(mesh).ClosestPoint(mesh.points.row(v));
    const double w = soft * soft / (foot.squared_distance + soft * soft);
    // All three corners get some weight, so that a closest point on an edge still follows the
    // rotation of the face.
    for (int k = 0; k < 3; ++k)
      weights[seat.corners(foot.face, k)] += w * (foot.barycentric[k] + 0.1);
    total += 1.3 * w;
  }
  const std::map<int, double> ring =
      Around(mesh, neighbors, weights, LoosePartTuning::kRing * part.diagonal);
  double ring_total = 0;
  const auto fade = [&](double d) {
    return std::exp(-std::pow(2 * d / std::max(LoosePartTuning::kRing * part.diagonal, 1e-300), 2));
  };
  for (const auto& [v, d] : ring) ring_total += fade(d);
  for (const auto& [v, d] : ring)
    weights[v] += LoosePartTuning::kRingShare * total * fade(d) / ring_total;
  part.weights.resize(std::ssize(weights));
  for (const auto& [v, w] : weights) {
    part.weights[std::ssize(part.anchors)] = w;
    part.anchors.push_back(v);
  }
  part.weights /= part.weights.sum();
}

std::vector<std::vector<int>> Neighbors(const Mesh& mesh) {
  std::vector<std::vector<int>> neighbors(mesh.vertex_count());
  for (const auto& [i, j] : UndirectedEdges(mesh.faces)) {
    neighbors[i].push_back(j);
    neighbors[j].push_back(i);
  }
  return neighbors;
}

/// The least squares similarity transform with its scale limited to values near `scale`.
Similarity3 FitNear(const PointsX3& from, const PointsX3& to, const Eigen::VectorXd& weights,
                    double scale) {
  const Vector3d mean_from = from.transpose() * weights / weights.sum(),
                 mean_to = to.transpose() * weights / weights.sum();
  Similarity3 fit;
  fit.scale = scale;
  if (BoundingDiagonal(from) > 0 && BoundingDiagonal(to) > 0 && from.rows() >= 3) {
    fit = FitSimilarity(from, to, weights);
    fit.scale = std::isfinite(fit.scale)
                    ? std::clamp(fit.scale, scale / LoosePartTuning::kMostScale,
                                 scale * LoosePartTuning::kMostScale)
                    : scale;
  }
  fit.translation = mean_to - fit.scale * (fit.rotation * mean_from);
  return fit;
}

/// The change of size of the host: the square root of the ratio of areas.
double HostScale(const Mesh& source, const LooseParts& parts, const PointsX3& moved) {
  std::vector<char> loose(source.vertex_count(), 0);
  for (const LoosePart& part : parts.parts)
    for (int v : part.vertices) loose[v] = 1;
  double before = 0, after = 0;
  const Eigen::VectorXd old_areas = FaceAreas(source.points, source.faces),
                        new_areas = FaceAreas(moved, source.faces);
  for (Eigen::Index f = 0; f < old_areas.size(); ++f) {
    if (loose[source.faces(f, 0)]) continue;
    before += old_areas[f];
    after += new_areas[f];
  }
  const double ratio = after / before;
  return std::isfinite(ratio) && ratio > 0 ? std::sqrt(ratio) : 1;
}

/// The loose components, largest first.
template <class IsLoose>
std::vector<int> LooseComponents(const MeshParts& components, const IsLoose& is_loose) {
  std::vector<int> order;
  for (std::size_t c = 0; c < components.diagonal.size(); ++c)
    if (is_loose(static_cast<int>(c))) order.push_back(static_cast<int>(c));
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return components.diagonal[a] > components.diagonal[b]; });
  return order;
}

/// Finds the part that part i sits on, among the larger ones before it.
/// @return its index, or -1 for the host
int ParentOf(const Mesh& mesh, const std::vector<LoosePart>& parts, std::size_t i, Seat& host,
             std::vector<Seat>& seats) {
  const std::vector<int> some = SomeOf(parts[i].vertices, kFeet);
  double nearest = MeanDistance(host.Scene(mesh), mesh, some);
  int parent = -1;
  for (std::size_t j = 0; j < i; ++j) {
    // A part only sits on another part if they touch, or nearly: two eyes side by side do not sit
    // on each other.
    if (parts[j].diagonal <= parts[i].diagonal ||
        seats[j].box.exteriorDistance(seats[i].box) >
            LoosePartTuning::kTouching * parts[i].diagonal)
      continue;
    const double d = MeanDistance(seats[j].Scene(mesh), mesh, some);
    if (d >= nearest) continue;
    nearest = d;
    parent = static_cast<int>(j);
  }
  return parent;
}

}  // namespace

LooseParts FindLooseParts(const Mesh& mesh, const LoosePartOptions& options) {
  RequireUsable(mesh, "register: loose parts");
  const MeshParts components(mesh);
  const double largest = *std::max_element(components.diagonal.begin(), components.diagonal.end());
  const auto is_loose = [&](int c) {
    return c >= 0 && components.diagonal[c] < options.largest_share * largest;
  };
  LooseParts found;
  const std::vector<int> order = LooseComponents(components, is_loose);
  std::vector<int> part_of(components.diagonal.size(), -1);
  for (std::size_t i = 0; i < order.size(); ++i) part_of[order[i]] = static_cast<int>(i);
  found.parts.resize(order.size());
  std::vector<Seat> seats(order.size());
  Seat host;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int c = components.of_vertex[v];
    if (!is_loose(c)) {
      found.host_vertices.push_back(v);
      continue;
    }
    found.parts[part_of[c]].vertices.push_back(v);
    seats[part_of[c]].box.extend(mesh.points.row(v).transpose());
  }
  if (order.empty()) return found;
  for (int f = 0; f < mesh.face_count(); ++f) {
    const int c = components.of_vertex[mesh.faces(f, 0)];
    (is_loose(c) ? seats[part_of[c]] : host).faces.push_back(f);
  }
  const std::vector<std::vector<int>> neighbors = Neighbors(mesh);
  for (std::size_t i = 0; i < order.size(); ++i) {
    LoosePart& part = found.parts[i];
    part.diagonal = components.diagonal[order[i]];
    part.parent = ParentOf(mesh, found.parts, i, host, seats);
    Bind(mesh, neighbors, part.parent < 0 ? host : seats[part.parent], part);
  }
  return found;
}

Mesh HostOf(const Mesh& mesh, const LooseParts& parts) {
  Mesh host;
  host.points = RowsOf(mesh.points, parts.host_vertices);
  std::vector<int> row(mesh.vertex_count(), -1);
  for (std::size_t i = 0; i < parts.host_vertices.size(); ++i)
    row[parts.host_vertices[i]] = static_cast<int>(i);
  std::vector<int> kept;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (row[mesh.faces(f, 0)] >= 0) kept.push_back(f);
  host.faces.resize(std::ssize(kept), 3);
  for (std::size_t i = 0; i < kept.size(); ++i)
    for (int k = 0; k < 3; ++k)
      host.faces(static_cast<Eigen::Index>(i), k) = row[mesh.faces(kept[i], k)];
  return host;
}

PointsX3 MoveLooseParts(const Mesh& source, const LooseParts& parts, const PointsX3& moved) {
  if (moved.rows() != source.points.rows())
    throw InputError("register: loose parts: the moved points are not the source's");
  PointsX3 points = moved;
  if (parts.empty()) return points;
  const double scale = HostScale(source, parts, moved);
  std::vector<Similarity3> motions;
  for (const LoosePart& part : parts.parts) {
    // A part that sits on a loose part gets exactly the same motion.
    motions.push_back(part.parent >= 0
                          ? motions[part.parent]
                          : FitNear(RowsOf(source.points, part.anchors),
                                    RowsOf(points, part.anchors), part.weights, scale));
    for (int v : part.vertices) points.row(v) = source.points.row(v);
    Apply(motions.back(), part.vertices, points);
  }
  return points;
}

PointsX3 MoveLoosePartsWithHost(const Mesh& source, const LooseParts& parts,
                                const PointsX3& moved_host) {
  if (moved_host.rows() != std::ssize(parts.host_vertices))
    throw InputError("register: loose parts: the moved points are not the host's");
  PointsX3 points = source.points;
  for (std::size_t i = 0; i < parts.host_vertices.size(); ++i)
    points.row(parts.host_vertices[i]) = moved_host.row(i);
  return MoveLooseParts(source, parts, points);
}

}  // namespace keypose::registration
