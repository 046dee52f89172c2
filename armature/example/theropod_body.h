// A body for the generated theropod, for trying and for tests.
#pragma once

#include "core/values/mesh.h"

namespace keypose::armature {

/// A coloured body around the joints of MakeTheropodSkeleton in its zero position: one closed
/// surface each for the spine from snout to tail, for legs, arms and eyes. Metres.
/// @param vertices  it has at least as many, and few more; >= 1000
Mesh MakeTheropodBody(int vertices);

}  // namespace keypose::armature
