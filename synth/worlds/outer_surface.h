// The visible surface of a pose whose parts are pressed into each other.
#pragma once

#include "core/values/mesh.h"

namespace keypose::synth {

/// The boundary of the region with a winding number of at least 1: overlapping parts become one,
/// without walls inside. Its genus is that of the posed solid, which may have handles that the rest
/// pose lacks. Along the seam, crevices narrower than `spacing` are closed. Its vertices do not
/// correspond to those of `posed`.
///
/// @param posed    closed, oriented outwards; may intersect itself
/// @param spacing  lattice spacing [m]
/// @throws InputError  no faces
Mesh OuterSurface(const Mesh& posed, double spacing);

/// Number of handles of a closed mesh, over all its components.
int Genus(const Mesh& closed);

}  // namespace keypose::synth
