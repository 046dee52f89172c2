// A small set for the generated theropod: a table before a wall, a lamp and a ball on it.
#pragma once

#include "core/values/camera.h"
#include "core/values/filmed_shot.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::armature {

/// Table and lamp, in colours; the table's top is z = 0. Metres.
Mesh MakeTheropodSet();

/// The camera of a still shot of that set. The character stands in the world as it is.
/// @param frames  of the film
FilmedShot MakeTheropodShot(int width, int height, int frames);

/// The set as that camera sees it, without the character: the background plate.
Image8 MakeTheropodPlate(const FilmedShot& shot);

}  // namespace keypose::armature
