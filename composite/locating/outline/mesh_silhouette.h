// The outlines of a mesh as a camera sees it.
#pragma once

#include <vector>

#include "composite/locating/lens/normal_equations.h"
#include "core/surfaces/face_pairs.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::composite {

/// A mesh in one pose, ready for rays.
struct Figure {
  PointsX3 points;
  FacesX3 faces;
  FacePairs pairs;
  RayScene scene;
  Eigen::Vector3d center;  ///< of the surface
  double radius;           ///< root mean square distance of the surface from its centre

  /// @throws InputError  no faces
  Figure(const PointsX3& points, const FacesX3& faces);
};
/// With at most about `vertices` vertices, for rough work.
Figure Simplified(const PointsX3& points, const FacesX3& faces, int vertices);

/// A piece of an edge between a face towards the camera and one away from it.
struct SilhouettePoint {
  Eigen::Vector3d position;       ///< in the mesh's frame
  Eigen::Vector2d pixel, normal;  ///< unit, in the picture, away from the surface
  double length_px = 0;           ///< of the piece
  bool inner = false;             ///< the picture shows another part of the mesh beyond it
};

/// @param step_px  longest piece
/// @param inner    also those outlines beyond which the mesh continues behind
/// Cost: linear in the faces, and a ray or two for each piece.
std::vector<SilhouettePoint> FindSilhouette(const Figure& figure, const Placement& at,
                                            double step_px, bool inner = false);

/// 255 where the mesh is seen. 1 channel, of the camera's size. Same bits for any thread count.
Image8 Covered(const Figure& figure, const Placement& at);

}  // namespace keypose::composite
