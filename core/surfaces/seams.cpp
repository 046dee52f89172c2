#include "core/surfaces/seams.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <numeric>
#include <tuple>

#include "core/values/size_of.h"

namespace keypose {

namespace {

std::uint64_t Hash(const PointsX3& points, Eigen::Index v) {
  std::uint64_t hash = 0;
  for (int k = 0; k < 3; ++k) {
    const double x = points(v, k) + 0.0;  // turns -0 into +0
    std::uint64_t bits;
    std::memcpy(&bits, &x, sizeof bits);
    hash = (hash ^ bits) * 0x9e3779b97f4a7c15ULL;
    hash ^= hash >> 29;
  }
  return hash;
}

/// For each vertex the first vertex with the same position; empty when all positions differ.
std::vector<int> WeldedPlaces(const PointsX3& points) {
  std::vector<std::pair<std::uint64_t, int>> keys(static_cast<std::size_t>(points.rows()));
  for (std::size_t v = 0; v < keys.size(); ++v)
    keys[v] = {Hash(points, static_cast<Eigen::Index>(v)), static_cast<int>(v)};
  std::sort(keys.begin(), keys.end());
  bool repeated = false;
  std::vector<int> place(keys.size());
  std::iota(place.begin(), place.end(), 0);
  for (std::size_t b = 0; b < keys.size();) {
    std::size_t e = b;
    for (; e < keys.size() && keys[e].first == keys[b].first; ++e)
      for (std::size_t s = b; s < e; ++s)
        if (points.row(keys[s].second) ==
            points.row(keys[e].second)) {  // different positions may have the same hash
          place[keys[e].second] = place[keys[s].second];
          repeated = true;
          break;
        }
    b = e;
  }
  return repeated ? place : std::vector<int>{};
}

struct Edge {
  int low, high;  // the two ends: vertices, or first vertices at their positions
  int from, to;   // the two ends as vertices, in the face's direction
  bool forward;   // from low to high
  auto key() const { return std::pair(low, high); }
};

bool Before(const Edge& a, const Edge& b) {
  return std::tie(a.low, a.high, a.from, a.to) < std::tie(b.low, b.high, b.from, b.to);
}

/// Calls visit(begin, end) for each run of edges with the same ends.
template <class Visit>
void ForRuns(std::vector<Edge>& edges, const Visit& visit) {
  std::sort(edges.begin(), edges.end(), Before);
  for (std::size_t b = 0; b < edges.size();) {
    std::size_t e = b;
    while (e < edges.size() && edges[e].key() == edges[b].key()) ++e;
    visit(b, e);
    b = e;
  }
}

/// Boundary edges with at least one doubled end; `low` and `high` are their positions.
std::vector<Edge> BoundarySides(const FacesX3& faces, const std::vector<int>& place) {
  std::vector<char> doubled(place.size(), 0);
  for (std::size_t v = 0; v < place.size(); ++v)
    if (place[v] != static_cast<int>(v)) doubled[v] = doubled[place[v]] = 1;
  std::vector<Edge> edges, sides;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (doubled[a] || doubled[b]) edges.push_back({std::min(a, b), std::max(a, b), a, b, a < b});
    }
  ForRuns(edges, [&](std::size_t b, std::size_t e) {
    if (e - b != 1) return;
    Edge side = edges[b];
    const int from = place[side.from], to = place[side.to];
    if (from == to) return;
    side.low = std::min(from, to);
    side.high = std::max(from, to);
    side.forward = from < to;
    sides.push_back(side);
  });
  return sides;
}

}  // namespace

Seams FindSeams(const Mesh& mesh) {
  const std::vector<int> place = WeldedPlaces(mesh.points);
  if (place.empty()) return {};
  std::vector<Edge> sides = BoundarySides(mesh.faces, place);
  Seams seams;
  seams.one.resize(place.size());
  std::iota(seams.one.begin(), seams.one.end(), 0);
  const auto find = [&](int v) {
    while (seams.one[v] != v) v = seams.one[v] = seams.one[seams.one[v]];
    return v;
  };
  const auto join = [&](int a, int b) {
    a = find(a);
    b = find(b);
    seams.one[std::max(a, b)] = std::min(a, b);
  };
  ForRuns(sides, [&](std::size_t b, std::size_t e) {
    if (e - b != 2 || sides[b].forward == sides[b + 1].forward) return;
    join(sides[b].from, sides[b + 1].to);
    join(sides[b].to, sides[b + 1].from);
  });
  for (std::size_t v = 0; v < place.size(); ++v) {
    seams.one[v] = find(static_cast<int>(v));
    seams.joined += seams.one[v] != static_cast<int>(v);
  }
  if (seams.empty()) seams.one.clear();
  return seams;
}

FacesX3 WeldedFaces(const FacesX3& faces, const Seams& seams) {
  if (seams.empty()) return faces;
  return faces.unaryExpr([&](int v) { return seams.one[v]; });
}

WeldedMesh Weld(const Mesh& mesh, const Seams& seams) {
  WeldedMesh welded;
  welded.of_input.resize(mesh.points.rows());
  std::vector<int> kept;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const int one = seams.empty() ? v : seams.one[v];
    if (one == v) kept.push_back(v);
    welded.of_input[v] = one == v ? SizeOf(kept) - 1 : welded.of_input[one];
  }
  welded.mesh.points = mesh.points(kept, Eigen::all);
  welded.mesh.faces.resize(mesh.faces.rows(), 3);
  Eigen::Index faces = 0;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    const auto at = [&](int k) { return welded.of_input[mesh.faces(f, k)]; };
    const bool shrank = (at(0) == at(1) && mesh.faces(f, 0) != mesh.faces(f, 1)) ||
                        (at(1) == at(2) && mesh.faces(f, 1) != mesh.faces(f, 2)) ||
                        (at(2) == at(0) && mesh.faces(f, 2) != mesh.faces(f, 0));
    if (!shrank) welded.mesh.faces.row(faces++) << at(0), at(1), at(2);
  }
  welded.mesh.faces.conservativeResize(faces, 3);
  return welded;
}

WeldedMesh WeldWholeFaces(const Mesh& mesh) {
  WeldedMesh whole = Weld(mesh, FindSeams(mesh));
  if (whole.mesh.face_count() != mesh.face_count()) return Weld(mesh, {});
  return whole;
}

}  // namespace keypose
