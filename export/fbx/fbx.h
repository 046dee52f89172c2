// Animated meshes as binary FBX 7.4, for Blender, Unity, Unreal and Maya.
#pragma once

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// One file, NAME.fbx: the first frame as a mesh, a blend shape for each further picture, named
/// after the first frame that shows it, and an animation of their weights. It is linear where
/// pictures blend, with a second key right before each step. The first texture is embedded. +y is
/// up and +z towards the viewer; a unit of the frames is one metre; the frame rate is the scene's.
/// A scene with a single picture gets no blend shapes and no animation.
///
/// measured: `shapes`, and `keys` of all their curves.
/// @throws InputError  no frames, a texture for a mesh without texture coordinates, or more than
/// the 4 GiB that the format can hold. A shape takes at most 52 bytes for each vertex that moves,
/// before compression
/// @throws Cancelled  the user asked to stop
/// Same bits for any thread count.
/// Source: see fbx_records.h.
FormatFiles MakeFbx(const Scene& scene, Progress* progress);

}  // namespace keypose::exporting
