#include "core/surfaces/shapes.h"

#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "core/values/size_of.h"

namespace keypose {
namespace {

Mesh FromLists(const std::vector<Eigen::Vector3d>& points,
               const std::vector<std::array<int, 3>>& faces) {
  Mesh mesh;
  mesh.points.resize(std::ssize(points), 3);
  for (std::size_t v = 0; v < points.size(); ++v) mesh.points.row(v) = points[v];
  mesh.faces.resize(std::ssize(faces), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    for (int k = 0; k < 3; ++k) mesh.faces(static_cast<Eigen::Index>(f), k) = faces[f][k];
  return mesh;
}

}  // namespace

Mesh MakeIcosphere(int levels) {
  const double g = std::numbers::phi;
  std::vector<Eigen::Vector3d> points{{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                      {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                      {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
  for (auto& p : points) p.normalize();
  std::vector<std::array<int, 3>> faces{
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<int, int>, int> middle;
    const auto split = [&](int a, int b) {
      const auto [it, is_new] = middle.emplace(std::minmax(a, b), SizeOf(points));
      if (is_new) points.push_back((points[a] + points[b]).normalized());
      return it->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const int ab = split(a, b), bc = split(b, c), ca = split(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  return FromLists(points, faces);
}

Mesh MakeBox(double x, double y, double z) {
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) points.emplace_back(i & 1 ? x : 0, i & 2 ? y : 0, i & 4 ? z : 0);
  return FromLists(points, {{0, 2, 3},
                            {0, 3, 1},
                            {4, 5, 7},
                            {4, 7, 6},
                            {0, 1, 5},
                            {0, 5, 4},
                            {2, 6, 7},
                            {2, 7, 3},
                            {0, 4, 6},
                            {0, 6, 2},
                            {1, 3, 7},
                            {1, 7, 5}});
}

Mesh MakeCylinder(double radius, double length, int segments, int rings) {
  std::vector<Eigen::Vector3d> points;
  std::vector<std::array<int, 3>> faces;
  for (int r = 0; r <= rings; ++r)
    for (int s = 0; s < segments; ++s) {
      const double angle = 2 * std::numbers::pi * s / segments;
      points.emplace_back(radius * std::cos(angle), radius * std::sin(angle), length * r / rings);
    }
  const int bottom = SizeOf(points), top = bottom + 1;
  points.emplace_back(0, 0, 0);
  points.emplace_back(0, 0, length);
  const auto at = [&](int r, int s) { return r * segments + s % segments; };
  for (int s = 0; s < segments; ++s) {
    for (int r = 0; r < rings; ++r) {
      faces.push_back({at(r, s), at(r, s + 1), at(r + 1, s + 1)});
      faces.push_back({at(r, s), at(r + 1, s + 1), at(r + 1, s)});
    }
    faces.push_back({bottom, at(0, s + 1), at(0, s)});
    faces.push_back({top, at(rings, s), at(rings, s + 1)});
  }
  return FromLists(points, faces);
}

}  // namespace keypose
