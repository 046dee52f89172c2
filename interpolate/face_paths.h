// What each triangle should look like at any moment of a timeline: turn and stretch on smooth paths through all keys.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "core/mesh.h"
#include "interpolate/arap.h"
#include "interpolate/differential_turns.h"
#include "interpolate/face_maps.h"
#include "interpolate/pair_paths.h"
#include "interpolate/poisson.h"
#include "interpolate/spline.h"
#include "interpolate/turns.h"

namespace keypose::interpolation {

/// Paths of all faces, and of the parts' centroids, through all keys.
///
/// In each span a face goes the way of its two keys alone (PairPaths). Where spans meet smoothly, the velocity of each face at the key is
/// brought to one that both spans share (VelocityAtKey), by factors that are one at the keys: its angular velocity in space, the growth of
/// its region, its shear, and its own area,
///
///     edges(s) = exp(h(s) . angular) A exp(h(s) . (growth I + shear)) A^T sqrt(1 + h(s) . area / area(s)) pair edges(s)
///
/// with the cubic Hermite weights h of HermiteWeights, and A the axes of the face at s. A region's growth is smoothed as a logarithm, the
/// face's own area as it is (as in Stretch::kBalanced), so that a bend, whose inside shrinks as its outside grows, keeps its total area. So
/// paths are C1 in time, meet every key exactly whatever the turns (no logarithm of a rotation is taken but the lifted ones of the pairs),
/// reverse with the order of the keys, and with two keys are those of two keys. Source: Kim, Kim & Shin 1995 for splines of rotations as
/// products of exponentials; the correction form is our own.
class FacePaths {
 public:
  /// @param system     of all keys; turns are smoothed with it; must outlive this
  /// @param overrides  for each span the limbs that turn further; or empty
  FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system, const Schedule& schedule,
            const std::vector<std::vector<TurnOverride>>& overrides = {}, Stretch stretch = Stretch::kBalanced);

  /// Fills the batch with wanted edges, relative to the body: BodyTurn is to be applied by PoissonSystem::Solve.
  void Evaluate(int span, const std::vector<double>& ways, EdgeBatch& edges) const;
  Eigen::Matrix3d BodyTurn(int span, double way) const;
  Eigen::Vector3d Centroid(int span, double way, int part) const;

  const TurnReport& turns(int span) const { return pairs_[span].turns; }
  int degenerate_faces() const;  ///< most, of any span

 private:
  /// Two keys by themselves, from the one that comes first in an order that they alone decide, so that the way back has the same bits.
  struct Pair {
    Pair(const PointsX3& from, const PointsX3& to, const PoissonSystem& system, const std::vector<TurnOverride>& overrides,
         Stretch stretch);
    double Time(double way) const { return reversed ? 1 - way : way; }
    void Evaluate(const std::vector<double>& ways, EdgeBatch& edges) const;

    bool still, reversed;
    SegmentMaps maps;
    TurnReport turns;
    std::optional<PairPaths> paths;
    std::optional<DifferentialTurns> differential;
    std::optional<CentroidPaths> centroids;
  };
  /// Wanted less own velocity at a span's end.
  struct Bend {
    Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< in the world
    double growth = 0;                                  ///< of the region's logarithmic scale
    Eigen::Vector2d shear = Eigen::Vector2d::Zero();    ///< (d, o) of [d o; o -d], in axes that follow from the face's first edge
    double area = 0;                                    ///< of the face's doubled area without the region's growth
  };
  struct BendPair {
    Bend start, end;
  };
  using Edges = Eigen::Matrix<double, 3, 2>;
  struct EndEdges {
    Edges at, rate;  ///< wanted edges and their velocity in the world, per way
  };

  std::vector<EndEdges> EdgesAtEnd(int span, double way) const;
  void SmoothFaces(const Schedule& schedule);
  void SmoothFace(const Schedule& schedule, Eigen::Index face, const std::vector<const EndEdges*>& starts,
                  const std::vector<const EndEdges*>& ends);
  void SmoothCentroids(const Schedule& schedule, int part_count);
  Edges Bent(int span, double way, const HermiteWeights& weights, const Eigen::Matrix3d& body, Eigen::Index face, const Edges& edges) const;

  /// Growth of the face's region over the whole span, as a logarithm.
  double GrowthOf(int span, Eigen::Index face) const;

  Eigen::Index face_count_;
  std::vector<Pair> pairs_;                                     ///< spans
  std::vector<std::vector<BendPair>> bends_;                    ///< spans x F, or empty when nothing is to be smoothed
  std::map<Eigen::Index, EndVelocities<Edges>> straight_;       ///< bends of faces without area in some key: added to their edges
  std::vector<EndVelocities<Eigen::Vector3d>> centroid_bends_;  ///< parts
};

}  // namespace keypose::interpolation
