// The plane that turns before a tripod: a mat, a disc.
//
// Two photographs from one place that show a plane turned about an axis that stands on it are
// related by a homography which is, seen from above, that turn. Whatever the turn, three places of
// the picture stay where they are: the one it turns round, and the images of the plane's circular
// points, which say how the plane is inclined. So even matches at a wrong turn, of a scale's ticks
// or of marks in four corners, tell where the plane is.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// In the camera's frame.
struct TurningPlane {
  Eigen::Vector3d middle;  ///< unit, towards the place that it turns round
  Eigen::Vector3d normal;  ///< unit, towards the camera's side
  int pairs = 0;           ///< of photographs that say so
};

struct TurningPlaneOptions {
  double least_turn = 0.15;   ///< [rad]: smaller ones say little
  double unlike_turn = 0.25;  ///< eigenvalues' and circular points' relative distance from a turn's
  double same_middle = 0.03;  ///< [rad] between two pairs' that agree
  double same_normal = 0.12;  ///< likewise
  double on_plane_px = 5;     ///< of matches, at the features' pixels
  int fewest_matches = 14;
  int fewest_pairs = 4;
};

/// @param homography  of directions in the camera's frame, from one photograph to another
/// @return nothing where it is no turn
/// Source: Hartley & Zisserman, "Multiple View Geometry", 2nd ed. 2004, 2.4.4 (what a planar motion
/// leaves in place) and 8.6 (circular points).
std::optional<TurningPlane> PlaneOfTurn(const Eigen::Matrix3d& homography,
                                        const TurningPlaneOptions& options = {});

/// The plane that most pairs before one tripod agree on, their mean.
std::optional<TurningPlane> CommonPlane(const std::vector<TurningPlane>& of_pairs,
                                        const TurningPlaneOptions& options = {});

/// Directions of matches that follow one homography between two photographs.
struct FlatMatches {
  std::vector<Eigen::Vector3d> first, second;                ///< z = 1
  Eigen::Matrix3d homography = Eigen::Matrix3d::Identity();  ///< second ~ homography * first
};

/// @return nothing where fewer than asked for follow one
/// Same result for any thread count.
std::optional<FlatMatches> MatchesOnPlane(const Features& first, const Camera& first_lens,
                                          const Features& second, const Camera& second_lens,
                                          const PairMatches& pair,
                                          const TurningPlaneOptions& options = {});

/// How far a direction meets the plane from its middle, if the camera is at distance 1 from that;
/// nothing where it does not meet it.
std::optional<double> RadiusOnPlane(const TurningPlane& plane, const Eigen::Vector3d& direction);

/// The camera that sees the plane so, with the plane at z = 0 and its middle at the origin; seen
/// from above it stands in direction x.
Rigid3 CameraOver(const TurningPlane& plane, double distance);

}  // namespace keypose::reconstruct
