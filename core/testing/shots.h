// Masks of meshes as seen from all sides, for tests in all rooms.
#pragma once

#include <filesystem>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

struct MaskShot {
  std::vector<View> views;
  std::vector<Image8> masks;  ///< 255 where the mesh is
};

/// Renders the mask of the mesh in each view.
MaskShot MasksOf(const Mesh& mesh, std::vector<View> views);

/// The same, from rings of cameras at distance 4 that look at `middle`. The focal length is twice
/// the side of the picture, so a pixel is 2 / side_px wide at `middle`.
MaskShot MasksFromRings(const Mesh& mesh, const Eigen::Vector3d& middle,
                        const std::vector<double>& elevations_deg, int views_a_ring, int side_px);

/// Writes the folders `images` and `model` as capture, masks and sfm write them. The photographs
/// show the masks.
void WriteShot(const std::filesystem::path& folder, const MaskShot& shot);

}  // namespace keypose
