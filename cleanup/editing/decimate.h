// Fast decimation for surfaces with millions of faces.
#pragma once

#include "core/values/mesh.h"

namespace keypose::cleanup {

/// Collapses the edges that change the surface least, until at most `faces` faces are left or no
/// edge can be collapsed.
///
/// @param manifold  oriented 2-manifold, possibly with boundary; boundary vertices do not move
/// @return an oriented 2-manifold of the same topology; no face is turned over; may intersect
/// itself where two walls are near to each other: check it
/// Cost: about 5 s from 2 million faces to 100,000.
/// Same bits for any thread count.
/// Source: Garland & Heckbert, SIGGRAPH 1997.
/// Departs: no queue. Each pass collapses the cheapest edges whose neighbourhoods do not overlap,
/// so that all threads compute costs in parallel.
Mesh Decimated(const Mesh& manifold, int faces);

}  // namespace keypose::cleanup
