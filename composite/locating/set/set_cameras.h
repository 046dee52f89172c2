// The way of a moving camera and its lens, from places of the set that several pictures show.
#pragma once

#include <optional>
#include <vector>

#include "composite/locating/lens/normal_equations.h"
#include "composite/locating/set/set_tracks.h"

namespace keypose::composite {

struct SetCameraInput {
  int pictures = 0;  ///< in the order of time; the camera moves little from one to the next
  std::vector<SetTrack> tracks;
  /// The first picture's camera as the character has it, whose frame is the world: z is up, and the
  /// table lies at `table_height`. It has the lens to start from.
  Placement first;
  double table_height = 0;
  /// What that picture says of the character: the equations at `first`, about `center`.
  NormalEquations character{{}, Eigen::Vector3d::Zero(), 1};
  /// Their weights times this are inverse variances: they are too sure of themselves where the mesh
  /// is not quite what was filmed.
  double character_weight = 1;
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 1;
  /// What else is known of the focal length, as from the character in other pictures, wherever it
  /// stands there: the normal equation of its logarithm, at the lens of `first`, with inverse
  /// variances.
  double focal_information = 0, focal_gradient = 0;
  bool focal_free = true;  ///< the rest of the lens stays as it is
};

struct SetCameras {
  std::vector<Placement> cameras;  ///< camera_from_mesh is camera from world
  std::vector<int> seen;           ///< places of the set that each picture shows
  int places = 0;                  ///< of the set, that are used
  int on_table = 0;                ///< of them, those that lie on the table
  double rms_px = 0;               ///< of their sightings
  double focal_deviation = 0;      ///< of the focal length's logarithm; 0: it is not solved
};

/// One picture after the other, then all at once: least squares for cameras, lens and places by
/// Gauss and Newton, with the places eliminated (Schur). Sightings that lie far off count less and
/// less. Pictures alone do not say how large the set is; the table, which the character stands on,
/// does.
///
/// @return none if the set, or its table, shows too few places
/// Deterministic. Cost: a round is quadratic in the pictures that a place is seen in.
/// Source: Triggs et al., "Bundle adjustment: a modern synthesis", 2000.
std::optional<SetCameras> SolveSetCameras(const SetCameraInput& input);

}  // namespace keypose::composite
