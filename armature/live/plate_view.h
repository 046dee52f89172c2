// The posed puppet over the background plate of its shot, with the scene's geometry.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::armature {

/// What a picture shows besides the puppet.
struct PlateView {
  View view;  ///< in the world
  Similarity3 world_from_character;
  Image8 plate;  ///< RGB of the camera's size; empty: a plain backdrop
};

/// What all pictures of a puppet share. References must outlive the calls.
struct PuppetLook {
  const Mesh& mesh;       ///< faces, colours and texture coordinates; its points are not used
  const Image8& texture;  ///< RGB; empty: the mesh's colours
  const Mesh& set;        ///< tables, lamps, in the world; without faces: none
};

/// @param points  of the puppet, in the character's coordinates
/// @param ghosts  earlier poses, oldest first: drawn faintly below the puppet, the oldest faintest
/// @return RGB of the camera's size. The set is drawn as if of glass; where it stands before the
/// puppet, that is seen through it.
/// @throws InputError  the plate has another size than the camera, or another number of channels
Image8 DrawPuppet(const PuppetLook& look, const PlateView& where, const PointsX3& points,
                  const std::vector<const PointsX3*>& ghosts);

}  // namespace keypose::armature
