// The animation as textures that a vertex shader reads: one texel per vertex and frame.
#pragma once

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// Writes into `vat/`, in the layout of VatLayout, +y up, one unit of the frames being one metre:
///
/// | file | what |
/// |---|---|
/// | NAME.glb | the first frame with split vertices; TEXCOORD_1 addresses the texel |
/// | NAME.json | counts, bounds, frame rate, keys ([format](docs/vertex-animation-textures.md)) |
/// | NAME_positions.png | 16 bits: 0 is `minimum`, 65535 is `maximum`, per axis |
/// | NAME_positions.exr | the same positions as single-precision numbers, without bounds |
/// | NAME_normals.png | 8 bits: 0 is -1, 255 is 1; they need normalizing |
/// | PICTURE.import | of each picture: how Godot reads it |
///
/// There is a frame for each picture of the film (RoundOf), so a shader that shows frame
/// floor(seconds * fps) shows what the film shows.
///
/// @return `error_over_diagonal` of the PNG, decoded in single precision as a shader does;
/// measured: `quantum_over_diagonal` (half a step of all three axes, which bounds it),
/// `exr_error_over_diagonal`, `normal_error_deg` (largest angle), `columns`, `rows`
/// @throws InputError  too many frames for a texture, or a texture without texture coordinates
FormatFiles MakeVat(const Scene& scene, Progress* progress);

}  // namespace keypose::exporting
