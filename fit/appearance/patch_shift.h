// Shifts of small patches of a render that make them agree with a photograph.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "fit/appearance/textured_render.h"

namespace keypose::fit {

struct PatchShift {
  bool found = false;
  Eigen::Vector2d shift = Eigen::Vector2d::Zero();  ///< from the render to the photograph [px]
  /// confidence by direction, symmetric with eigenvalues in [0, 1]: 0 where the texture has no
  /// gradient in a direction
  Eigen::Matrix2d confidence = Eigen::Matrix2d::Zero();
  double correlation = 0;  ///< of the two patches after the shift
};

struct PatchOptions {
  int radius = 6;       ///< half the patch's side [px]
  double reach_px = 4;  ///< largest shift
  double least_correlation = 0.6;
};

/// Places of the mesh's vertices in a view, for those that it shows.
struct SeenVertex {
  int vertex = 0;
  Eigen::Vector2d pixel;
  double depth = 0;
  double facing = 0;  ///< cosine of the angle between normal and ray
};
/// Vertices at the front of the render that face the camera by at least `least_facing`.
std::vector<SeenVertex> SeenVertices(const PointsX3& points, const PointsX3& normals,
                                     const TexturedRender& render, const Pinhole& camera,
                                     const Rigid3& camera_from_world, double least_facing);

/// The shift of the patch around each seen vertex, by Lucas and Kanade's method with a factor, an
/// offset and a slope of brightness. Pixels beside the vertex's own surface and outside of the mask
/// have no weight.
///
/// @param photo  brightness of the photograph, of the render's size
/// @param mask   of the same size; the lowest bit is set inside
/// @param noise  standard deviation of the photograph [grey levels]
/// Source: Baker, Matthews, "Lucas-Kanade 20 years on", IJCV 2004 (inverse compositional).
std::vector<PatchShift> FindShifts(const std::vector<SeenVertex>& seen,
                                   const TexturedRender& render, const ImageF& photo,
                                   const GreyMask& mask, double focal, double noise,
                                   const PatchOptions& options);

}  // namespace keypose::fit
