// The wanted shape of each triangle at any moment of a timeline: turn and stretch on smooth paths
// through all keys.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/surface/arap.h"
#include "interpolate/surface/pair_paths.h"
#include "interpolate/timing/spline.h"
#include "interpolate/turns/differential_turns.h"
#include "interpolate/turns/turns.h"

namespace keypose::interpolation {

/// Paths of all faces, and of the parts' centroids, through all keys.
///
/// In each span a face's path depends on the span's two keys alone (PairPaths). Where spans meet
/// smoothly, each face gets one velocity at the shared key (VelocityAtKey). The velocity has four
/// parts: rotation in space, growth of the region, shear, and growth of the face's own area. The
/// part that all faces have in common is a change of pace: the pair's path is evaluated at
/// sigma(s), a cubic whose end slopes fit all faces' velocities best. So a span that comes to rest
/// slows down on the path of its two keys. The rest of each face's velocity is added by factors
/// that are one at the keys:
///
///     edges(s) = exp(h(s) . angular) A exp(h(s) . (growth I + shear)) A^T
///                sqrt(1 + h(s) . area / area(s)) pair edges(sigma(s))
///
/// h are the cubic Hermite weights of HermiteWeights, and A the axes of the face at s. A region's
/// growth is smoothed as a logarithm, the face's own area directly (as in Stretch::kBalanced),
/// because a bend's inside shrinks as its outside grows. The paths are C1 in time and pass exactly
/// through every key, for turns of any size: logarithms are only taken of the rotations between two
/// keys, whose turns are already consistent. Reversed keys give the reversed path, and two keys
/// give the path of the pair.
/// Source: Kim, Kim & Shin 1995 for splines of rotations as products of exponentials; the
/// correction form is our own.
class FacePaths {
 public:
  /// @param system     of all keys; turns are smoothed with it; must outlive this
  /// @param overrides  for each span, the limbs that make extra turns; or empty
  FacePaths(const std::vector<PointsX3>& keys, const PoissonSystem& system,
            const Schedule& schedule, const std::vector<std::vector<TurnOverride>>& overrides = {},
            Stretch stretch = Stretch::kBalanced);

  /// Fills the batch with wanted edges, relative to the body. PoissonSystem::Solve must apply
  /// BodyTurn.
  void Evaluate(int span, const std::vector<double>& ways, EdgeBatch& edges) const;
  Eigen::Matrix3d BodyTurn(int span, double way) const;
  Eigen::Vector3d Centroid(int span, double way, int part) const;

  const TurnReport& turns(int span) const { return pairs_[span].turns; }
  int degenerate_faces() const;  ///< maximum over the spans

 private:
  /// Two keys, computed from the one that comes first in an order that depends on the keys alone,
  /// so that swapped keys give the same bits.
  struct Pair {
    Pair(const PointsX3& from, const PointsX3& to, const PoissonSystem& system,
         const std::vector<TurnOverride>& overrides, Stretch stretch);
    double Time(double way) const { return reversed ? 1 - way : way; }
    void Evaluate(const std::vector<double>& ways, EdgeBatch& edges) const;

    bool still, reversed;
    Eigen::Vector3d body_turn;
    std::vector<double> growth;    ///< F, in the order of computation
    std::vector<char> degenerate;  ///< F
    TurnReport turns;
    std::optional<PairPaths> paths;
    std::optional<DifferentialTurns> differential;
    std::optional<CentroidPaths> centroids;
  };
  /// A face's velocity at a span's end, per span.
  struct Motion {
    Eigen::Vector3d angular = Eigen::Vector3d::Zero();  ///< in the world
    double growth = 0;                                  ///< of the region's logarithmic scale
    Eigen::Vector2d shear = Eigen::Vector2d::Zero();    ///< (d, o) of [d o; o -d], in axes that the
                                                        ///< face's first edge defines
    double area = 0;  ///< half the rate of log area, less the region's growth
    double Dot(const Motion& other) const;
    Motion Less(double share, const Motion& other) const;
  };
  struct MotionPair {
    Motion start, end;
  };
  /// sigma's slopes at a span's ends.
  struct Pace {
    double start = 1, end = 1;
  };
  using Edges = Eigen::Matrix<double, 3, 2>;
  struct EndEdges {
    Edges at, rate;  ///< wanted edges and their velocity in the world, per span
  };

  std::vector<EndEdges> EdgesAtEnd(int span, double way) const;
  void SmoothFaces(const Schedule& schedule);
  std::vector<MotionPair> OwnMotions(int span, const std::vector<EndEdges>& starts,
                                     const std::vector<EndEdges>& ends) const;
  std::vector<std::vector<MotionPair>> SmoothMotions(
      const Schedule& schedule, const std::vector<std::vector<MotionPair>>& own) const;
  Pace PaceOf(const std::vector<EndEdges>& starts, const std::vector<EndEdges>& ends,
              const std::vector<MotionPair>& own, const std::vector<MotionPair>& wanted) const;
  void SmoothStraight(const Schedule& schedule, Eigen::Index face,
                      const std::vector<std::vector<EndEdges>>& starts,
                      const std::vector<std::vector<EndEdges>>& ends);
  double Sigma(int span, double way) const;
  void SmoothCentroids(const Schedule& schedule, int part_count);
  Edges Bent(int span, double sigma, const HermiteWeights& weights, const Eigen::Matrix3d& body,
             Eigen::Index face, const Edges& edges) const;

  /// Growth of the face's region over the whole span, as a logarithm.
  double GrowthOf(int span, Eigen::Index face) const;

  Eigen::Index face_count_;
  std::vector<Pair> pairs_;                     ///< spans
  std::vector<Pace> paces_;                     ///< spans
  std::vector<std::vector<MotionPair>> bends_;  ///< spans x F: the wanted motion that sigma does
                                                ///< not provide; empty when nothing is smoothed
  /// corrections for faces without area in some key: added to their edges
  std::map<Eigen::Index, EndVelocities<Edges>> straight_;
  std::vector<EndVelocities<Eigen::Vector3d>> centroid_bends_;  ///< parts
};

}  // namespace keypose::interpolation
