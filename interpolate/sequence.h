// Frames through any number of keys on a schedule, one by one.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "interpolate/surface/frame_source.h"
#include "interpolate/timing/frame_schedule.h"
#include "interpolate/timing/rules.h"

namespace keypose::interpolation {

enum class AlignKeys { kNone, kUpright, kRigid, kSimilarity };

/// Later keys aligned to the first by corresponding vertices. Upright: a rotation about z and a
/// horizontal translation; heights stay. kNone changes nothing. The first key stays as it is, and a
/// repeated pose gets the same bits each time.
std::vector<PointsX3> AlignedKeys(const std::vector<PointsX3>& keys, AlignKeys align);

/// For each key its size over that of the first: the median of the edges' length ratios, which
/// bending a limb does not change.
/// @param faces  of all keys
std::vector<double> RelativeSizes(const std::vector<PointsX3>& keys, const FacesX3& faces);

/// Later keys scaled to the first key's size, about the origin, which is on the ground. Cameras do
/// not give a scale without a printed calibration board, so poses of one figure differ in size by
/// some per cent.
std::vector<PointsX3> SameSized(const std::vector<PointsX3>& keys, const FacesX3& faces);

enum class Method { kArap, kPaper, kLinear, kVolumetric };

/// @param keys   two or more with the same faces, as many as the schedule's
/// @param rules  kArap uses all of them, kVolumetric only the volume, kPaper and kLinear none
/// @throws InputError   different numbers of vertices (names the key), an unusable mesh, or a loop
/// whose last key is not its first
/// @throws SolverError
std::unique_ptr<FrameSource> MakeFrameSource(const std::vector<PointsX3>& keys,
                                             const FacesX3& faces, const Schedule& schedule,
                                             Method method, const Rules& rules);

/// One frame for the caller. `points` is valid until the next frame.
struct FrameView {
  int index = 0;
  const PlannedFrame& plan;
  const PointsX3& points;
  double volume_move = 0;
  int on_table = 0;
};

/// Calls `take` for every frame of the schedule, in order. A frame at a key has the key's own bits,
/// a repeated frame those of the frame that it repeats. Memory holds one batch of frames (about 16,
/// fewer for large meshes), however long the schedule is.
/// @throws SolverError  a frame that is not finite
/// @throws Cancelled, and whatever `take` throws
void StreamFrames(const std::vector<PointsX3>& keys, const Schedule& schedule, FrameSource& source,
                  const std::function<void(const FrameView&)>& take, Progress* progress = nullptr);

}  // namespace keypose::interpolation
