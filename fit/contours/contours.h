// The occluding contours of a mesh in a view.
#pragma once

#include <vector>

#include "core/surfaces/face_pairs.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// A point of a contour, midway on an edge between a face towards the camera and one away from it.
struct ContourPoint {
  int a = 0, b = 0;        ///< the edge
  Eigen::Vector2d pixel;   ///< of the edge's middle
  Eigen::Vector2d normal;  ///< unit, in the picture, away from the surface
  double length_px = 0;    ///< of the edge in the picture
  double depth = 0;        ///< z of the middle in the camera's frame
};

/// The points of the mesh's silhouette: contours beyond which the picture shows no other part.
///
/// @param points  V x 3, in the frame of `camera_from_world`
/// @param scene   of the same points
/// Cost: linear in the faces, and a ray for each contour edge.
std::vector<ContourPoint> FindSilhouette(const PointsX3& points, const FacesX3& faces,
                                         const FacePairs& pairs, const RayScene& scene,
                                         const Pinhole& camera, const Rigid3& camera_from_world);

}  // namespace keypose::fit
