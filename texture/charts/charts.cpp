#include "texture/charts/charts.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <queue>
#include <string>
#include <tuple>
#include <unordered_map>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/union_find.h"

namespace keypose::texture {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Flood {
  std::vector<int> label;    // F, -1: not reached
  std::vector<double> cost;  // F
};

// Grows all regions at once, cheapest step first, within the faces marked in `allowed`.
Flood Grow(const Surface& s, const std::vector<int>& seeds, const PointsX3& normals,
           const std::vector<char>& allowed) {
  Flood flood{std::vector<int>(s.faces.rows(), -1), std::vector<double>(s.faces.rows(), kInfinity)};
  using Entry = std::tuple<double, int, int>;  // cost, face, label; ties resolve by face, so the
                                               // result is unique
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
  for (int i = 0; i < std::ssize(seeds); ++i) queue.emplace(0.0, seeds[i], i);
  while (!queue.empty()) {
    const auto [cost, face, label] = queue.top();
    queue.pop();
    if (flood.label[face] >= 0) continue;
    flood.label[face] = label;
    flood.cost[face] = cost;
    for (int k = 0; k < 3; ++k) {
      const int next = s.neighbors(face, k);
      if (flood.label[next] >= 0 || !allowed[next]) continue;
      const double bend = 1.05 - s.normals.row(next).dot(normals.row(label));
      queue.emplace(cost + bend * (s.centers.row(next) - s.centers.row(face)).norm(), next, label);
    }
  }
  return flood;
}

// Mean normal of each region, and the face nearest to its centroid.
void Recenter(const Surface& s, const Flood& flood, std::vector<int>& seeds, PointsX3& normals) {
  const int count = SizeOf(seeds);
  PointsX3 centers = PointsX3::Zero(count, 3);
  Eigen::VectorXd areas = Eigen::VectorXd::Zero(count);
  normals.setZero(count, 3);
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f) {
    const int label = flood.label[f];
    if (label < 0) continue;
    const double area = std::max(s.areas[f], 1e-300);
    centers.row(label) += area * s.centers.row(f);
    normals.row(label) += area * s.normals.row(f);
    areas[label] += area;
  }
  std::vector<double> best(count, kInfinity);
  for (int i = 0; i < count; ++i) {
    centers.row(i) /= areas[i];
    const double length = normals.row(i).norm();
    if (length > 0) normals.row(i) /= length;
  }
  for (int f = 0; f < static_cast<int>(s.faces.rows()); ++f) {
    const int label = flood.label[f];
    if (label < 0) continue;
    const double d = (s.centers.row(f) - centers.row(label)).squaredNorm();
    if (d < best[label]) {
      best[label] = d;
      seeds[label] = f;
    }
  }
}

PointsX3 NormalsOf(const Surface& s, const std::vector<int>& seeds) {
  PointsX3 normals(std::ssize(seeds), 3);
  for (int i = 0; i < std::ssize(seeds); ++i) normals.row(i) = s.normals.row(seeds[i]);
  return normals;
}

// Unreached faces (other components) count as farthest.
int Farthest(const Flood& flood, const std::vector<char>& allowed) {
  int best = -1;
  for (int f = 0; f < std::ssize(flood.cost); ++f)
    if (allowed[f] && (best < 0 || flood.cost[f] > flood.cost[best])) best = f;
  return best;
}

// Follows the boundary; returns the number of loops and the first one.
int Loops(const Surface& s, const Chart& chart, const std::vector<int>& local,
          std::vector<int>& rim) {
  const int vertex_count = SizeOf(chart.vertices);
  std::vector<int> next(vertex_count, -1);
  for (int i = 0; i < std::ssize(chart.faces); ++i)
    for (int k = 0; k < 3; ++k)
      if (local[s.neighbors(chart.faces[i], k)] < 0)
        next[chart.corners(i, k)] = chart.corners(i, (k + 1) % 3);
  std::vector<char> seen(vertex_count, 0);
  int loops = 0;
  for (int v = 0; v < vertex_count; ++v) {
    if (next[v] < 0 || seen[v]) continue;
    ++loops;
    for (int w = v; w >= 0 && !seen[w]; w = next[w]) {
      seen[w] = 1;
      if (loops == 1) rim.push_back(w);
    }
  }
  return loops;
}

// Corners that chart faces share over an edge become one local vertex.
void NumberCorners(const Surface& s, const std::vector<int>& local, Chart& chart) {
  const int count = SizeOf(chart.faces);
  UnionFind joined(3 * count);
  for (int i = 0; i < count; ++i) {
    const int f = chart.faces[i];
    for (int k = 0; k < 3; ++k) {
      const int j = local[s.neighbors(f, k)];
      if (j < 0) continue;
      for (const int corner : {k, (k + 1) % 3}) {
        for (int m = 0; m < 3; ++m)
          if (s.faces(chart.faces[j], m) == s.faces(f, corner))
            joined.Join(3 * i + corner, 3 * j + m);
      }
    }
  }
  std::vector<int> id(3 * count, -1);
  chart.corners.resize(count, 3);
  for (int i = 0; i < count; ++i) {
    for (int k = 0; k < 3; ++k) {
      int& v = id[joined.Find(3 * i + k)];
      if (v < 0) {
        v = SizeOf(chart.vertices);
        chart.vertices.push_back(s.faces(chart.faces[i], k));
      }
      chart.corners(i, k) = v;
    }
  }
}

bool Connected(const Surface& s, const std::vector<int>& faces, const std::vector<int>& local) {
  std::vector<char> seen(faces.size(), 0);
  std::vector<int> stack = {0};
  seen[0] = 1;
  std::size_t reached = 1;
  while (!stack.empty()) {
    const int i = stack.back();
    stack.pop_back();
    for (int k = 0; k < 3; ++k) {
      const int j = local[s.neighbors(faces[i], k)];
      if (j < 0 || seen[j]) continue;
      seen[j] = 1;
      ++reached;
      stack.push_back(j);
    }
  }
  return reached == faces.size();
}

}  // namespace

FacesX3 FaceNeighbors(const FacesX3& faces) {
  std::unordered_map<std::uint64_t, int> owner;
  owner.reserve(static_cast<std::size_t>(faces.rows()) * 4);
  const auto key = [](int a, int b) {
    return (static_cast<std::uint64_t>(a) << 32) | static_cast<std::uint32_t>(b);
  };
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (!owner.emplace(key(a, b), f).second)
        throw InputError("unwrap: edge " + std::to_string(a) + "-" + std::to_string(b) +
                         " has two faces on one side; run cleanup on the mesh first");
    }
  }
  FacesX3 neighbors(faces.rows(), 3);
  for (int f = 0; f < static_cast<int>(faces.rows()); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      const auto other = owner.find(key(b, a));
      if (other == owner.end())
        throw InputError("unwrap: edge " + std::to_string(a) + "-" + std::to_string(b) +
                         " of face " + std::to_string(f) +
                         " is a boundary; run cleanup on the mesh first");
      neighbors(f, k) = other->second;
    }
  }
  return neighbors;
}

Surface MakeSurface(const Mesh& mesh) {
  Surface s;
  s.points = mesh.points;
  s.faces = mesh.faces;
  s.neighbors = FaceNeighbors(mesh.faces);
  s.normals = FaceNormals(mesh.points, mesh.faces);
  s.areas = FaceAreas(mesh.points, mesh.faces);
  s.centers.resize(mesh.faces.rows(), 3);
  for (int f = 0; f < mesh.face_count(); ++f)
    s.centers.row(f) = (mesh.points.row(mesh.faces(f, 0)) + mesh.points.row(mesh.faces(f, 1)) +
                        mesh.points.row(mesh.faces(f, 2))) /
                       3;
  return s;
}

Chart MakeChart(const Surface& surface, std::vector<int> faces) {
  Chart chart;
  std::sort(faces.begin(), faces.end());
  chart.faces = std::move(faces);
  std::vector<int> local(surface.faces.rows(), -1);
  for (int i = 0; i < std::ssize(chart.faces); ++i) local[chart.faces[i]] = i;
  NumberCorners(surface, local, chart);
  const int loops = Loops(surface, chart, local, chart.rim);
  // With one loop through all boundary edges, V - E + F = 1 excludes handles.
  const long f = static_cast<long>(chart.faces.size()),
             v = static_cast<long>(chart.vertices.size()), b = static_cast<long>(chart.rim.size());
  chart.disk = loops == 1 && (3 * f + b) % 2 == 0 && v - (3 * f + b) / 2 + f == 1 &&
               Connected(surface, chart.faces, local);
  return chart;
}

std::vector<int> CutIntoCharts(const Surface& surface, int count, int rounds) {
  const std::vector<char> all(surface.faces.rows(), 1);
  std::vector<int> seeds = {0};
  Flood flood = Grow(surface, seeds, NormalsOf(surface, seeds), all);
  PointsX3 normals;
  while (SizeOf(seeds) < count || Farthest(flood, all) < 0 ||
         flood.label[Farthest(flood, all)] < 0) {
    seeds.push_back(Farthest(flood, all));
    flood = Grow(surface, seeds, NormalsOf(surface, seeds), all);
  }
  for (int round = 0; round < rounds; ++round) {
    Recenter(surface, flood, seeds, normals);
    flood = Grow(surface, seeds, normals, all);
  }
  return flood.label;
}

std::vector<std::vector<int>> Halved(const Surface& surface, const std::vector<int>& faces) {
  std::vector<char> allowed(surface.faces.rows(), 0);
  for (const int f : faces) allowed[f] = 1;
  std::vector<int> seeds = {faces.front()};
  seeds = {Farthest(Grow(surface, seeds, NormalsOf(surface, seeds), allowed), allowed)};
  seeds.push_back(Farthest(Grow(surface, seeds, NormalsOf(surface, seeds), allowed), allowed));
  Flood flood = Grow(surface, seeds, NormalsOf(surface, seeds), allowed);
  PointsX3 normals;
  for (int round = 0; round < 3; ++round) {
    Recenter(surface, flood, seeds, normals);
    if (seeds[0] == seeds[1]) break;
    flood = Grow(surface, seeds, normals, allowed);
  }
  std::vector<std::vector<int>> halves(2);
  for (const int f : faces) halves[flood.label[f] == 1].push_back(f);
  return halves;
}

}  // namespace keypose::texture
