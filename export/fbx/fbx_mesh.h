// The mesh of an animation, its material and its shapes, as objects of an FBX file.
#pragma once

#include <vector>

#include "core/values/progress.h"
#include "export/animation/scene.h"
#include "export/fbx/fbx_document.h"

namespace keypose::exporting {

// Ids of the objects that exist once.
constexpr std::int64_t kFbxGeometryId = 1000, kFbxModelId = 1001, kFbxMaterialId = 1002,
                       kFbxTextureId = 1003, kFbxVideoId = 1004, kFbxBlendShapeId = 1005,
                       kFbxStackId = 1006, kFbxLayerId = 1007;

/// Ids of the objects that each shape has.
struct FbxShapeIds {
  explicit FbxShapeIds(int shape);
  std::int64_t shape, channel, curve_node, curve;
};

/// The frames whose pictures are new: all but the first picture, in order.
std::vector<int> FbxShapeFrames(const Clip& clip);

/// The first frame as a mesh in the scene, with its material and, if there is one, the first
/// texture.
void AddFbxMesh(const Scene& scene, FbxObjects& out);

/// A blend shape with a channel for each frame, named after it. A shape has the vertices that move
/// or turn, relative to the first frame, in single precision.
void AddFbxShapes(const Scene& scene, const std::vector<int>& frames, FbxObjects& out,
                  Progress* progress);

}  // namespace keypose::exporting
