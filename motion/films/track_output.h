// What the stage `track` writes besides meshes: numbers of the poses, the actor, a picture.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "motion/tracking/tracker.h"
#include "views/shot/clock_wish.h"

namespace keypose::motion {

/// Per frame: time, the 38 numbers and their variances. Positions in the calibration's unit, angles
/// in radians; the root's turn as a rotation vector that does not jump.
/// @param units_per_metre  of the calibration
std::string AnglesCsv(const std::vector<TrackedFrame>& frames, double fps, double units_per_metre);

/// Names of numbers whose standard deviation is more than `most_deg` in at least half of the
/// frames.
std::vector<std::string> UnseenAngles(const std::vector<TrackedFrame>& frames, double most_deg);

/// {"schema": 1, "offsets": {"cam1": 0, ...}}: frame f of the result is frame f + offset of the
/// film; where the films' clocks were set, also "films": {"cam1": {"begin_s": 0, "rate": 1}, ...}.
std::string ClocksText(const std::vector<int>& offsets,
                       const std::vector<SilhouetteCamera>& cameras,
                       const std::map<std::string, FilmClock>& films);

/// Bone lengths and girths as JSON, in metres.
std::string ActorText(const BodyShape& shape);
/// @throws InputError  not what ActorText writes
BodyShape ParseActor(const std::string& text, const std::string& name);

/// The picture with the template's segments drawn over it, each in a colour, half transparent.
Image8 Overlay(const Image8& rgb, const View& view, const PointsX3& points);

}  // namespace keypose::motion
