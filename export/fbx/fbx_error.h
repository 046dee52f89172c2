// How far the shapes that an FBX file shows are from the frames that it was made from.
#pragma once

#include <string>

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// Reads the file, and at each time of the film sums up the shapes with the weights that their
/// curves have then, as a player does.
///
/// @param fbx  a file that MakeFbx wrote for the scene
/// @return the largest distance to a vertex of the frame that is to be shown, over the diagonal of
/// the first frame
/// @throws Cancelled  the user asked to stop
double FbxErrorOverDiagonal(const std::string& fbx, const Scene& scene, Progress* progress);

}  // namespace keypose::exporting
