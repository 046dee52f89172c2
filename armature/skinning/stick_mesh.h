// A ball at each joint and a stick along each bone: a character for armatures that have none.
#pragma once

#include <vector>

#include "armature/skinning/skin.h"
#include "core/values/mesh.h"

namespace keypose::armature {

struct StickFigure {
  Mesh mesh;  ///< with colours: sticks light, balls dark
  SkinWeights weights;
};

/// @param bones  at rest; a ball stands at both ends of each
/// @throws InputError  no bone has a length
StickFigure MakeStickFigure(const std::vector<SkinBone>& bones);

}  // namespace keypose::armature
