// Masks of meshes from all round, for the tests of every room that asks outlines.
#pragma once

#include <filesystem>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose {

struct MaskShot {
  std::vector<View> views;
  std::vector<Image8> masks;  ///< 255 where the mesh is
};

/// The mesh as each view sees it.
MaskShot MasksOf(const Mesh& mesh, std::vector<View> views);

/// From rings of cameras at distance 4 that look at `middle`; focal length twice the pictures'
/// side, so that a pixel is 2 / side_px there.
MaskShot MasksFromRings(const Mesh& mesh, const Eigen::Vector3d& middle,
                        const std::vector<double>& elevations_deg, int views_a_ring, int side_px);

/// `images` and `model` in a folder, as capture, masks and sfm make them; the photographs show the
/// masks.
void WriteShot(const std::filesystem::path& folder, const MaskShot& shot);

}  // namespace keypose
