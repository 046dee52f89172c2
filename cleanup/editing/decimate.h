// Fewer faces, fast: for surfaces of millions.
#pragma once

#include "core/mesh.h"

namespace keypose::cleanup {

/// Collapses edges where it changes the surface least, until at most `faces` are left or nothing
/// more can go.
///
/// @param manifold  oriented 2-manifold, possibly with boundary; boundary vertices stay where they
/// are
/// @return an oriented 2-manifold of the same topology; no face turned over; may intersect itself
/// where walls are near: check it Cost: about 5 s from 2 million faces to 100,000.
/// Same bits for any thread count.
/// Source: Garland & Heckbert, SIGGRAPH 1997.
/// Departs: no queue; each pass takes the cheapest edges whose neighbourhoods are apart, so that
/// costs are computed by all threads at once.
Mesh Decimated(const Mesh& manifold, int faces);

}  // namespace keypose::cleanup
