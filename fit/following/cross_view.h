// Where two films show a surface alike: how far it must move for both to show the same there.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "fit/appearance/patch_shift.h"
#include "fit/appearance/textured_render.h"
#include "fit/bending/view_constraints.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// A view at the resolution in use, with its picture and what it shows of the mesh.
struct ShownView {
  FitView at;
  const ImageF* grey = nullptr;
  const GreyMask* mask = nullptr;
  double noise = 1;              ///< standard deviation of the picture [grey levels]
  TexturedRender shape;          ///< faces and depth of the mesh as it is now
  std::vector<SeenVertex> seen;  ///< of the vertices that are compared
};

/// Pairs of views whose directions to `middle` are neighbours, between 5 and 80 degrees apart.
std::vector<std::pair<int, int>> NeighbouringViews(const std::vector<ShownView>& views,
                                                   const Eigen::Vector3d& middle);

/// What `other` shows of the surface, as `view` would see it. Where `other` does not see the
/// surface, the depth is infinite.
TexturedRender ShownBy(const ShownView& other, const ShownView& view);

/// Constraints along the surface's normals. The brightness that `other` shows is laid on the mesh
/// and seen from `view`; a shift against what `view` shows tells how far along `other`'s ray the
/// surface truly is. Needs no texture, but a surface that has one.
/// @param areas  of the vertices, over the whole area
std::vector<Constraint> CrossViewConstraints(const PointsX3& points, const PointsX3& normals,
                                             const ShownView& view, const ShownView& other,
                                             const Eigen::VectorXd& areas, double weight);

}  // namespace keypose::fit
