#include "export/fbx/fbx.h"

#include <utility>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "export/fbx/fbx_animation.h"
#include "export/fbx/fbx_document.h"
#include "export/fbx/fbx_error.h"
#include "export/fbx/fbx_mesh.h"

namespace keypose::exporting {
namespace {

void RequireFits(const Scene& scene) {
  if (scene.frames.empty())
    throw InputError("export: there are no frames; run `interpolate` first");
  if (!scene.textures.empty() && !scene.frames[0].has_uvs()) {
    throw InputError("export: the texture " + scene.textures[0].name +
                     " cannot be used, since the first frame has no texture coordinates; unwrap "
                     "the template before it is registered");
  }
}

double KeyCount(const FbxObjects& objects) {
  double keys = 0;
  for (const FbxRecord& object : objects.objects)
    if (object.name == "AnimationCurve")
      keys += SizeOf(object.Inner("KeyTime").values.at(0).AsTimes());
  return keys;
}

}  // namespace

FormatFiles MakeFbx(const Scene& scene, Progress* progress) {
  RequireFits(scene);
  SubProgress shapes_progress(progress, 0, 0.7), error_progress(progress, 0.7, 1);
  const std::vector<int> frames = FbxShapeFrames(scene.clip);
  FbxObjects objects;
  AddFbxMesh(scene, objects);
  AddFbxShapes(scene, frames, objects, &shapes_progress);
  AddFbxAnimation(scene, frames, objects);

  FormatFiles made;
  made.measured["shapes"] = SizeOf(frames);
  made.measured["keys"] = KeyCount(objects);
  const FbxDocument document{scene.name, frames.empty() ? "" : scene.name, scene.playback.fps,
                             FbxSeconds(scene)};
  made.files.push_back({scene.name + ".fbx", WriteFbx(FbxFile(document, std::move(objects)))});
  made.error_over_diagonal = FbxErrorOverDiagonal(made.files[0].bytes, scene, &error_progress);
  return made;
}

}  // namespace keypose::exporting
