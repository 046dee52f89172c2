// A textured mesh against one photograph: what the report says of a pose by itself, whatever the
// stages said.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/ray_scene.h"

namespace keypose::report {

/// A photograph with its camera and the mask that was first made of it.
struct Shot {
  View view;          ///< of the photograph's size
  Image8 photograph;  ///< 3 channels
  Image8 mask;        ///< 1 channel, object where >= 128
};

/// How well the mesh repeats one photograph. Nothing here depends on the figure's size in the
/// picture, on light, or on exposure.
struct ViewEvidence {
  std::string name;
  double iou = 0;          ///< of the mesh's pixels and the mask's
  double outline_off = 1;  ///< mean distance of the two outlines, over the diagonal of the mask's
                           ///< bounding box; 1: nothing in common
  double structure = 0;    ///< correlation of the render's details with the photograph's, -1 to 1
  /// share of the mesh's outline across which the photograph changes its colour, 0 to 1
  double edges = 0;
  /// One number to find the worst view by: 1 where outline or details are as bad as is still taken.
  double Misfit() const;
};

/// The part of the shot that shows the mesh or the mask, with a margin.
Shot Cropped(const Shot& shot, const PointsX3& points);

/// @param texture  of a mesh with UVs; null takes the mesh's colours @pre photograph, mask and
/// camera of one size
ViewEvidence CompareView(const Mesh& mesh, const RayScene& scene, const Image8* texture,
                         const Shot& shot);

/// Photograph (left) and render from the same camera (right), the mask's outline drawn in both.
Image8 SideBySide(const Mesh& mesh, const RayScene& scene, const Image8* texture, const Shot& shot);

/// The middle one of all views, by each measure; what single bad photographs cannot move.
struct PoseEvidence {
  std::vector<ViewEvidence> views;  ///< by name
  double outline_off = 1, structure = 0, edges = 0;
  std::vector<int> worst;  ///< indices of views, worst first, at most three
};
PoseEvidence Summarize(std::vector<ViewEvidence> views);

}  // namespace keypose::report
