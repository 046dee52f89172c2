#include "deform/levels/hierarchy.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "deform/levels/edge_collapse.h"

namespace keypose {

namespace {

constexpr int kInRounds = 30000;  // vertices above which a mesh is decimated in rounds

CoarseLevel LevelOf(DecimatedMesh mesh, const std::vector<int>& finer_vertices,
                    const std::vector<int>& parent) {
  CoarseLevel level;
  std::vector<int> index(parent.size(), -1);
  for (std::size_t k = 0; k < mesh.vertex.size(); ++k) index[mesh.vertex[k]] = static_cast<int>(k);
  level.up.reserve(finer_vertices.size());
  for (int v : finer_vertices) {
    while (index[v] < 0) v = parent[v];
    level.up.push_back(index[v]);
  }
  level.fine = std::move(mesh.vertex);
  level.points = std::move(mesh.points);
  level.faces.resize(std::ssize(mesh.faces), 3);
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    level.faces.row(f) << mesh.faces[f][0], mesh.faces[f][1], mesh.faces[f][2];
  return level;
}

}  // namespace

std::vector<CoarseLevel> MakeHierarchy(const PointsX3& points, const FacesX3& faces,
                                       const std::vector<int>& counts) {
  std::vector<CoarseLevel> levels;
  if (counts.empty()) return levels;
  std::vector<int> finer(points.rows()), parent;
  std::iota(finer.begin(), finer.end(), 0);
  parent = finer;
  DecimatedMesh mesh = ToDecimatedMesh(points, faces);
  std::optional<HalfEdgeDecimator> one_by_one;
  for (int count : counts) {
    if (!one_by_one) DecimateInRounds(mesh, std::max(count, kInRounds), parent);
    if (!one_by_one && SizeOf(mesh.vertex) > count) one_by_one.emplace(std::move(mesh), parent);
    if (one_by_one) one_by_one->DecimateTo(count);
    DecimatedMesh now = one_by_one ? one_by_one->Rest() : mesh;
    if (static_cast<double>(now.vertex.size()) > 0.8 * static_cast<double>(finer.size())) continue;
    levels.push_back(LevelOf(std::move(now), finer, parent));
    finer = levels.back().fine;
  }
  return levels;
}

Prolongation MakeProlongation(const PointsX3& fine_points, const CoarseLevel& coarse) {
  const std::size_t n = coarse.points.rows();
  std::vector<std::vector<int>> ring(n);
  for (Eigen::Index f = 0; f < coarse.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (int j = 1; j < 3; ++j) ring[coarse.faces(f, k)].push_back(coarse.faces(f, (k + j) % 3));
  std::vector<double> spacing(n, 0);
  for (std::size_t v = 0; v < n; ++v) {
    std::sort(ring[v].begin(), ring[v].end());
    ring[v].erase(std::unique(ring[v].begin(), ring[v].end()), ring[v].end());
    for (int w : ring[v]) spacing[v] += (coarse.points.row(v) - coarse.points.row(w)).norm();
    spacing[v] /= std::max<std::size_t>(1, ring[v].size());
  }
  Prolongation p;
  p.offset.push_back(0);
  std::vector<std::pair<double, int>> near;
  for (std::size_t i = 0; i < coarse.up.size(); ++i) {
    const int a = coarse.up[i];
    near.clear();
    const auto add = [&](int k) {
      near.emplace_back((fine_points.row(i) - coarse.points.row(k)).squaredNorm(), k);
    };
    add(a);
    for (int k : ring[a]) add(k);
    std::sort(near.begin(), near.end());
    if (near.size() > Prolongation::kNodes) near.resize(Prolongation::kNodes);
    const double width2 = std::max(0.5 * spacing[a] * spacing[a], 1e-30);
    double sum = 0;
    for (const auto& [d2, k] : near) sum += std::exp(-(d2 - near[0].first) / width2);
    for (const auto& [d2, k] : near) {
      p.node.push_back(k);
      p.weight.push_back(static_cast<float>(std::exp(-(d2 - near[0].first) / width2) / sum));
    }
    p.offset.push_back(SizeOf(p.node));
  }
  return p;
}

PointsX3 Prolong(const Prolongation& prolongation, const PointsX3& fine_rest,
                 const PointsX3& coarse_rest, const PointsX3& coarse_moved,
                 const std::vector<Eigen::Matrix3d>& rotations) {
  PointsX3 moved(fine_rest.rows(), 3);
  ParallelBlocks(fine_rest.rows(), 2048, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      double weights = 0;
      for (int s = prolongation.offset[i]; s < prolongation.offset[i + 1]; ++s) {
        const int k = prolongation.node[s];
        const double w = prolongation.weight[s];
        const Eigen::Vector3d arm = (fine_rest.row(i) - coarse_rest.row(k)).transpose();
        sum += w * (rotations[k] * arm + coarse_moved.row(k).transpose());
        weights += w;
      }
      moved.row(i) = (sum / weights).transpose();
    }
  });
  return moved;
}

}  // namespace keypose
