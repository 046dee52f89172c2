// When each shape of an animation shows, as objects of an FBX file.
#pragma once

#include <vector>

#include "export/animation/scene.h"
#include "export/fbx/fbx_document.h"

namespace keypose::exporting {

/// A curve for the weight of each shape, linear between its keys, in an animation of the scene's
/// name. A curve has keys where its shape comes and goes, and at both ends of the animation.
///
/// @param frames  the frame of each shape, as returned by FbxShapeFrames
void AddFbxAnimation(const Scene& scene, const std::vector<int>& frames, FbxObjects& out);

/// The end of the animation [s].
double FbxSeconds(const Scene& scene);

}  // namespace keypose::exporting
