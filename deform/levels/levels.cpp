#include "deform/levels/levels.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/surfaces/geometry.h"

namespace keypose {

namespace {

// vertices; larger levels only refine the result of coarser ones
constexpr Eigen::Index kMostFactored = 30000;
constexpr Eigen::Index kFarApart =
    20;  // times fewer vertices: a coarser level would leave too much to the finer one

Eigen::VectorXd Rows(const Eigen::VectorXd& values, const std::vector<int>& rows) {
  if (values.size() == 0) return {};
  Eigen::VectorXd some(std::ssize(rows));
  for (std::size_t k = 0; k < rows.size(); ++k)
    some[static_cast<Eigen::Index>(k)] = values[rows[k]];
  return some;
}

int NearestCorner(const SurfacePoint& point) {
  int k = 0;
  point.weights.maxCoeff(&k);
  return point.vertices[k];
}

}  // namespace

Levels::Levels(const PointsX3& rest, const FacesX3& faces, const std::vector<int>& coarse_counts,
               const Eigen::VectorXd& stiffness, double smoothing,
               const std::vector<LandmarkGoal>& landmarks) {
  levels_.emplace_back();
  levels_[0].rest = rest;
  levels_[0].faces = faces;
  for (Eigen::Index v = 0; v < rest.rows(); ++v) levels_[0].fine.push_back(static_cast<int>(v));
  for (CoarseLevel& coarse : MakeHierarchy(rest, faces, coarse_counts)) {
    down_.push_back(MakeProlongation(levels_.back().rest, coarse));
    up_.push_back(std::move(coarse.up));
    Level level;
    level.rest = std::move(coarse.points);
    level.faces = std::move(coarse.faces);
    level.fine = std::move(coarse.fine);
    levels_.push_back(std::move(level));
  }
  const std::vector<char> rim = BoundaryVertices(static_cast<int>(rest.rows()), faces);
  if (std::find(rim.begin(), rim.end(), 1) != rim.end())
    for (Level& level : levels_)
      for (int v : level.fine) level.rim.push_back(rim[v]);
  for (const LandmarkGoal& landmark : landmarks) {
    const Eigen::Vector3d at = PositionOf(landmark.source, rest);
    int vertex = NearestCorner(landmark.source);
    for (int l = 0; l < count(); ++l) {
      if (l > 0) vertex = up_[l - 1][vertex];
      levels_[l].marks.push_back(
          {vertex, at - levels_[l].rest.row(vertex).transpose(), landmark.target});
    }
  }
  for (int l = 0; l < count(); ++l) {
    Level& level = levels_[l];
    const bool follows =
        l + 1 < count() && levels_[l + 1].rest.rows() * kFarApart > level.rest.rows();
    const bool factor = level.rest.rows() <= kMostFactored || !follows;
    level.fit.emplace(level.rest, level.faces, Rows(stiffness, level.fine), smoothing, factor);
    level.moved = level.rest;
  }
  pending_.assign(levels_.size(), 1.0);
}

void Levels::Descend(int level) {
  const Level& coarse = (*this)[level];
  Level& fine = (*this)[level - 1];
  fine.moved = Prolong(down_[level - 1], fine.rest, coarse.rest, coarse.moved, coarse.fit->maps());
  std::vector<Eigen::Matrix3d> maps;
  maps.reserve(up_[level - 1].size());
  for (int v : up_[level - 1]) maps.push_back(coarse.fit->maps()[v]);
  fine.fit->SetMaps(std::move(maps));
  fine.fit->FitMaps(fine.moved);
}

Level& Levels::operator[](int at) {
  last_asked_ = at;
  Level& level = levels_[at];
  const double factor = std::exchange(pending_[at], 1.0);
  if (factor == 1) return level;
  level.rest *= factor;
  for (Mark& mark : level.marks) mark.arm *= factor;
  level.fit->ScaleRest(factor);
  return level;
}

void Levels::ScaleRest(double factor) {
  for (double& pending : pending_) pending *= factor;
  (*this)[last_asked_];
}

}  // namespace keypose
