// The outlines of a bent template over the photographs, for a person to look at.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/bending/bend.h"

namespace keypose::fit {

/// The cropped photographs with the mesh's silhouette in each, in a contact sheet. Picks are
/// crosses, with a line to where the mesh shows their places.
/// @param cameras  camera from world, one a view
Image8 OutlinePicture(const Mesh& mesh, const std::vector<BendView>& views,
                      const std::vector<Rigid3>& cameras, const std::vector<PixelPick>& picks);

}  // namespace keypose::fit
