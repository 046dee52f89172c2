// Compares a textured mesh with one photograph: the report's own judgement of a pose, independent
// of the stages' measurements.
#pragma once

#include <string>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "report/evidence/missing_part.h"

namespace keypose::report {

/// A photograph with its camera and the mask that was first made of it.
struct Shot {
  View view;          ///< of the photograph's size
  Image8 photograph;  ///< 3 channels
  Image8 mask;        ///< 1 channel, object where >= 128
};

/// How well the mesh reproduces one photograph. No value depends on the figure's size in the
/// picture, on light or on exposure.
struct ViewEvidence {
  std::string name;
  double iou = 0;  ///< intersection over union of the mesh's and the mask's pixels
  /// mean distance of the two outlines / diagonal of the mask's bounding box; 1: no overlap
  double outline_off = 1;
  double structure = 0;  ///< correlation of the render's details with the photograph's, -1 to 1
  /// share of the mesh's outline across which the photograph changes its colour, 0 to 1
  double edges = 0;
  /// One number to rank the views: 1 if outline or details are just acceptable, more if they are
  /// worse.
  double Misfit() const;
};

/// The part of the shot with the mesh or the mask, and a margin, without the bend of its lens: then
/// the mesh is drawn by scan conversion.
Shot Cropped(const Shot& shot, const PointsX3& points);

/// 255 where the ray through the pixel's centre meets the mesh.
Image8 Covered(const Mesh& mesh, const RayScene& scene, const View& view);

/// @param texture  for a mesh with UVs; null: the mesh's colours. @pre photograph, mask and camera
/// have one size
ViewEvidence CompareView(const Mesh& mesh, const RayScene& scene, const Image8* texture,
                         const Shot& shot);

/// Photograph (left) and render from the same camera (right), with the mask's outline in both.
Image8 SideBySide(const Mesh& mesh, const RayScene& scene, const Image8* texture, const Shot& shot);

/// The median over the views of each measure, which single bad photographs do not affect.
struct PoseEvidence {
  std::vector<ViewEvidence> views;  ///< by name
  double outline_off = 1, structure = 0, edges = 0;
  std::vector<int> worst;  ///< indices of views, worst first, at most three
  MissingPart missing;
};
PoseEvidence Summarize(std::vector<ViewEvidence> views);

}  // namespace keypose::report
