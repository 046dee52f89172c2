#include "core/io/meshes/some_colors.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace keypose {
namespace {

std::uint8_t ClampedLevel(double value) {
  return static_cast<std::uint8_t>(std::lround(std::clamp(value, 0.0, 255.0)));
}

/// The neighbours of each vertex, once for each face that they share: those of v are
/// ids[offsets[v]] to ids[offsets[v + 1]].
struct Neighbours {
  std::vector<std::size_t> offsets;
  std::vector<int> ids;
};

Neighbours NeighboursOf(const FacesX3& faces, Eigen::Index vertices) {
  Neighbours all;
  all.offsets.assign(static_cast<std::size_t>(vertices) + 1, 0);
  for (Eigen::Index c = 0; c < faces.size(); ++c) all.offsets[faces.data()[c] + 1] += 2;
  for (std::size_t v = 0; v + 1 < all.offsets.size(); ++v) all.offsets[v + 1] += all.offsets[v];
  all.ids.resize(all.offsets.back());
  std::vector<std::size_t> next(all.offsets.begin(), all.offsets.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (int other = 1; other < 3; ++other)
        all.ids[next[faces(f, k)]++] = faces(f, (k + other) % 3);
  return all;
}

/// Gives vertices without a colour the mean of their neighbours, ring by ring.
/// @param ring  V: 0 for vertices with a colour, -1 for others; becomes the ring's number
void GrowRings(const Neighbours& neighbours, std::vector<int>* ring, Eigen::MatrixX3d* levels) {
  std::vector<int> front;
  for (std::size_t v = 0; v < ring->size(); ++v)
    if ((*ring)[v] == 0) front.push_back(static_cast<int>(v));
  const auto each = [&](int v, const auto& visit) {
    for (std::size_t i = neighbours.offsets[v]; i < neighbours.offsets[v + 1]; ++i)
      visit(neighbours.ids[i]);
  };
  for (int number = 1; !front.empty(); ++number) {
    std::vector<int> grown;
    for (const int v : front)
      each(v, [&](int to) {
        if ((*ring)[to] >= 0) return;
        (*ring)[to] = number;
        grown.push_back(to);
      });
    for (const int v : grown) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      int count = 0;
      each(v, [&](int from) {
        if ((*ring)[from] != number - 1) return;
        sum += levels->row(from);
        ++count;
      });
      levels->row(v) = sum / count;
    }
    front = std::move(grown);
  }
}

}  // namespace

ColorsX3 ColorsOfSome(const std::vector<std::size_t>& colored,
                      const std::vector<Eigen::Vector3d>& colors, const FacesX3& faces,
                      Eigen::Index vertices) {
  if (colored.empty()) return {};
  double most = 0;
  Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
  for (const Eigen::Vector3d& color : colors) most = std::max(most, color.maxCoeff());
  const double scale = most > 1 ? 1 : 255;
  std::vector<int> ring(static_cast<std::size_t>(vertices), -1);
  Eigen::MatrixX3d levels = Eigen::MatrixX3d::Zero(vertices, 3);
  for (std::size_t i = 0; i < colored.size(); ++i) {
    ring[colored[i]] = 0;
    levels.row(static_cast<Eigen::Index>(colored[i])) = scale * colors[i].transpose();
    mean += scale / static_cast<double>(colored.size()) * colors[i].transpose();
  }
  if (std::ssize(colored) < vertices) GrowRings(NeighboursOf(faces, vertices), &ring, &levels);
  ColorsX3 result(vertices, 3);
  for (Eigen::Index v = 0; v < vertices; ++v)
    for (int c = 0; c < 3; ++c)
      result(v, c) = ClampedLevel(ring[static_cast<std::size_t>(v)] >= 0 ? levels(v, c) : mean[c]);
  return result;
}

}  // namespace keypose
