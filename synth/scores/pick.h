// Simulates an artist who clicks named points on a reconstructed mesh.
#pragma once

#include <string>
#include <vector>

#include "core/io/project/landmarks_io.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

struct Picks {
  std::vector<Landmark> landmarks;        ///< on the mesh
  std::vector<std::string> out_of_reach;  ///< names of points that the mesh lacks
};

/// The points of the mesh closest to the true landmarks.
///
/// @param truth            the surface whose vertices the landmarks refer to
/// @param truth_from_mesh  e.g. from ScoreCameras
/// @param reach            landmarks farther from the mesh than this share of its diagonal are left
/// out
Picks PickLandmarks(const Mesh& truth, const std::vector<TruthLandmark>& landmarks,
                    const Mesh& mesh, const Similarity3& truth_from_mesh, double reach = 0.03);

}  // namespace keypose::synth
