// A painted ball that turns between several cameras: a small world with known truth for tests of
// 3D video.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::motion {

/// Texture coordinates that give each face a triangle of its own in a grid of cells.
void GiveUvs(Mesh* mesh);

struct BallWorld {
  Mesh painted;                               ///< fine, with colours of its vertices, for pictures
  Mesh mesh;                                  ///< coarser, with UVs
  std::vector<View> views;                    ///< a ring about the origin
  View held_out;                              ///< between two of them
  Eigen::Vector3d background{0.9, 0.2, 0.8};  ///< sRGB

  /// @param cameras  in the ring
  explicit BallWorld(int cameras, int size_px = 160);
  /// Points of `mesh` in a frame: the ball turns about z and walks along x.
  PointsX3 Points(int frame) const;
  /// What a camera films; `gain` is its exposure.
  Image8 Picture(const View& view, int frame, double gain = 1) const;
  /// 255 where the ball is.
  Image8 Mask(const View& view, int frame) const;
};

}  // namespace keypose::motion
