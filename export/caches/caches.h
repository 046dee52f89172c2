// The animation as point caches: the positions of all vertices per frame, which other programs bind
// to a mesh with the same vertices.
#pragma once

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// Both formats write `cache/NAME.obj`, the mesh to bind the cache to, with its .mtl, and beside
/// them `cache/NAME.pc2` or `cache/NAME.mdd`. The vertices are those of the frames that belong to
/// a face, in their order, not split along seams. One sample per picture of the film (ShownFrames),
/// in single precision, with +y up: (x, y, z) -> (x, z, -y) if the scene has z up. One unit of the
/// frames is one unit.

/// PC2: sample i belongs to frame i of the animation, so the first frame is 0. The format has no
/// frame rate.
/// Source: 3ds Max's Point Cache 2, little endian, header of 32 bytes.
FormatFiles MakePc2(const Scene& scene, Progress* progress);

/// MDD: sample i has the time i / fps [s]; big endian.
/// Source: LightWave's Motion Designer Data.
FormatFiles MakeMdd(const Scene& scene, Progress* progress);

}  // namespace keypose::exporting
