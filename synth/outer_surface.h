// What one sees of a posed surface whose parts are pressed into each other.
#pragma once

#include "core/mesh.h"

namespace keypose::synth {

/// The boundary of the solid that a closed surface wraps at least once: where parts overlap, the
/// walls inside are gone and the parts are one. Its genus is that of the posed solid, which may
/// have handles that the rest pose lacks. Along the seam, crevices narrower than `spacing` are
/// closed. Has no correspondence to `posed`.
///
/// @param posed    closed, outward oriented; may cross itself
/// @param spacing  of the lattice that it is made on [m]
/// @throws InputError  no faces
Mesh OuterSurface(const Mesh& posed, double spacing);

/// Handles of a closed mesh, over all its components.
int Genus(const Mesh& closed);

}  // namespace keypose::synth
