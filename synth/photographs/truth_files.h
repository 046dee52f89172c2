// The exact truth of synthetic photographs, in files beside them.
//
// - truth/POSE/cameras/: COLMAP's binary model: exact cameras in the character's frame [m], points
//   on the true surface
// - truth/POSE/masks/NAME.png: 255 = character
// - truth/POSE/surface.ply: vertex i is the same material point in every pose
// - truth/POSE/outer.ply: the visible surface of the solid, without walls inside; only for a pose
//   with parts pressed into each other
// - truth/POSE/smooth.ply: only if finger-prints move the surface: its vertices without them
// - truth/POSE/landmarks.json: named vertices of surface.ply
// - truth/POSE/world.json: what was rendered
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "synth/photographs/photographer.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

/// The truth of one pose.
struct Truth {
  Scene cameras;  ///< views sorted by name
  /// vertex i is the same material point in every pose; intersects itself where parts are pressed
  /// together
  Mesh surface;
  Mesh outer;       ///< its visible surface; equal to `surface` unless parts are pressed together
  PointsX3 smooth;  ///< vertices of `surface` without finger-prints
  std::vector<TruthLandmark> landmarks;
  /// of a pose with few photographs: those of the rig that were taken from the same places; only
  /// written
  std::vector<std::string> rig_photographs;
};

/// @throws InputError  a file missing or malformed @throws DiskError
Truth ReadTruth(const std::filesystem::path& folder);

/// Writes everything except the masks.
/// @throws DiskError
void WriteTruth(const std::filesystem::path& folder, const Truth& truth, const World& world,
                const Pose& pose, const WorldOptions& world_options,
                const PhotographerOptions& options);

}  // namespace keypose::synth
