#include "deform/arap/rigid_pieces.h"

#include <algorithm>
#include <utility>

#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "deform/solvers/sparse_pattern.h"

namespace keypose {

namespace {

constexpr std::size_t kFewest = 3;  // vertices that determine a rotation

struct Fit {
  Similarity3 motion;  ///< of the rest shape, without scale
  double scale = 1;    ///< scale that would fit best
  double weight = 0;
};

Fit FitPiece(const PointsX3& rest, const PointsX3& moved, const Eigen::VectorXd& areas,
             const std::vector<int>& piece) {
  const PointsX3 from = rest(piece, Eigen::all), to = moved(piece, Eigen::all);
  const Eigen::VectorXd weights = areas(piece);
  Fit fit;
  if (!(weights.sum() > 0) || !((from.rowwise() - from.row(0)).squaredNorm() > 0)) return fit;
  fit.motion = FitSimilarity(from, to, weights, false);
  const Eigen::RowVector3d a = weights.transpose() * from / weights.sum(),
                           b = weights.transpose() * to / weights.sum();
  const PointsX3 turned = (from.rowwise() - a) * fit.motion.rotation.transpose();
  const double across = (weights.asDiagonal() * turned).cwiseProduct(to.rowwise() - b).sum();
  fit.weight = (weights.asDiagonal() * turned).cwiseProduct(turned).sum();
  if (fit.weight > 0 && across > 0) fit.scale = across / fit.weight;
  return fit;
}

}  // namespace

RigidPieces::RigidPieces(const FacesX3& faces, const Eigen::VectorXd& stiffness,
                         const Eigen::VectorXd& areas)
    : areas_(areas) {
  if (stiffness.size() == 0 || stiffness.maxCoeff() < kFrom) return;
  std::vector<std::pair<int, int>> edges;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      if (stiffness[a] >= kFrom && stiffness[b] >= kFrom)
        edges.emplace_back(std::min(a, b), std::max(a, b));
    }
  int count = 0;
  const std::vector<int> component = Components(SizeOf(stiffness), edges, count);
  std::vector<std::vector<int>> members(count);
  for (Eigen::Index v = 0; v < stiffness.size(); ++v)
    if (stiffness[v] >= kFrom) members[component[v]].push_back(static_cast<int>(v));
  double own = 0;
  for (std::vector<int>& piece : members) {
    if (piece.size() < kFewest) continue;
    own += areas(piece).sum();
    pieces_.push_back(std::move(piece));
  }
  share_ = own / areas.sum();
}

void RigidPieces::ShareMaps(const PointsX3& rest, const PointsX3& moved,
                            std::vector<Eigen::Matrix3d>& maps) const {
  for (const std::vector<int>& piece : pieces_) {
    const Eigen::Matrix3d rotation = FitPiece(rest, moved, areas_, piece).motion.rotation;
    for (int v : piece) maps[v] = rotation;
  }
}

double RigidPieces::Straighten(const PointsX3& rest, PointsX3& moved) const {
  double across = 0, own = 0;
  for (const std::vector<int>& piece : pieces_) {
    const Fit fit = FitPiece(rest, moved, areas_, piece);
    if (!(fit.weight > 0)) continue;
    across += fit.scale * fit.weight;
    own += fit.weight;
    for (int v : piece) moved.row(v) = fit.motion * Eigen::Vector3d(rest.row(v));
  }
  return own > 0 ? across / own : 1;
}

}  // namespace keypose
