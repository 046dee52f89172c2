// Frames through any number of keys on a schedule, one by one.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "core/progress.h"
#include "interpolate/surface/frame_source.h"
#include "interpolate/timing/rules.h"
#include "interpolate/timing/timeline.h"

namespace keypose::interpolation {

enum class AlignKeys { kNone, kUpright, kRigid, kSimilarity };

/// Later keys brought onto the first by corresponding vertices. Upright: a turn about z and a level
/// translation; heights stay. kNone changes nothing. A pose that comes twice has the same bits each
/// time, and the first key its own.
std::vector<PointsX3> AlignedKeys(const std::vector<PointsX3>& keys, AlignKeys align);

/// Later keys in the first one's size, scaled about the origin, which is on the ground: cameras
/// tell no size without a printed calibration board, so that poses of one figure come out up to
/// some per cent apart. The size is the median of the edges' ratios, which bending a limb leaves
/// alone.
/// @param faces  of all keys
std::vector<PointsX3> SameSized(const std::vector<PointsX3>& keys, const FacesX3& faces);

enum class Method { kArap, kPaper, kLinear, kVolumetric };

/// @param keys   two or more with the same faces, as many as the schedule's
/// @param rules  kArap keeps all of them, kVolumetric the volume; kPaper and kLinear none
/// @throws InputError   other numbers of vertices (named), unusable mesh, a loop whose last key is
/// not its first
/// @throws SolverError
std::unique_ptr<FrameSource> MakeFrameSource(const std::vector<PointsX3>& keys,
                                             const FacesX3& faces, const Schedule& schedule,
                                             Method method, const Rules& rules);

/// A frame on its way out. `points` lives until the next frame.
struct FrameView {
  int index = 0;
  const PlannedFrame& plan;
  const PointsX3& points;
  double volume_move = 0;
  int on_table = 0;
};

/// Calls `take` for every frame of the schedule in order. Keys come with their own bits, repeated
/// frames with those that they repeat. Holds one batch of frames in memory (about 16, fewer of
/// large meshes), however long the schedule is.
/// @throws SolverError  a frame that is not finite
/// @throws Cancelled, and whatever `take` throws
void StreamFrames(const std::vector<PointsX3>& keys, const Schedule& schedule, FrameSource& source,
                  const std::function<void(const FrameView&)>& take, Progress* progress = nullptr);

}  // namespace keypose::interpolation
