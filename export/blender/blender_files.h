// The animation for Blender's artists: an add-on in one file, and what it reads.
#pragma once

#include <string_view>

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// The add-on's file: File > Import > Keypose project, and `Update` after a further run. For
/// Blender 3.4 and later.
std::string_view BlenderAddOn();

/// Files below `blender/`, in Blender's axes (z up) and with one unit a metre:
///
/// - keypose_import.py  the add-on, to be installed once
/// - character.json     counts, times of the pictures, keys, weights of the textures
/// - character.bin      int32 corners F x 3, then float32 u and v of each corner (v up); little
/// endian
/// - character.pc2      float32 positions of each picture; POINTCACHE2, for Blender's Mesh Cache
///
/// A picture is a run of frames that show the same, so that a hold is level in the curve of the
/// picture over time. Textures are those in `textures/`, beside the folder.
///
/// `measured` has `pictures`.
FormatFiles MakeBlenderFiles(const Scene& scene, Progress* progress);

}  // namespace keypose::exporting
