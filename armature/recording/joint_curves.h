// Recorded motion: one value for each joint and frame.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "armature/description/armature.h"
#include "core/values/motion_clip.h"

namespace keypose::armature {

/// A recorded frame is shown for `step` frames of the film: 1 is "on ones", 2 "on twos". Nothing is
/// smoothed between them.
struct JointCurves {
  double fps = 24;  ///< of the film
  int step = 1;
  std::vector<std::string> joints;    ///< names, in the order of the armature's joints
  Eigen::MatrixXd values;             ///< recorded frames x joints, from zero: [rad], slides [m]
  std::vector<std::string> left_out;  ///< joints of the file that the armature has not
  int frame_count() const { return static_cast<int>(values.rows()); }
};

/// Values with all their digits: read again, they are the same bits.
std::string CurvesJson(const Armature& armature, const JointCurves& curves);

/// Curves of that format, in the order of the armature's joints.
/// @param file  its name, for messages
/// @throws InputError  malformed, a joint that the armature has is missing, or has another unit
JointCurves ParseCurvesJson(const std::string& text, const std::string& file,
                            const Armature& armature);

/// What of a take is not taken, in words for the user; "" if all is.
std::string LeftOutWords(const JointCurves& curves);

/// How a take's joints differ from the armature's, in words that follow on "the take"; "" if they
/// are the same in the same order.
std::string MisfitOf(const std::vector<std::string>& joints, const Armature& armature);

/// A line a frame: its number, its time, a column for each joint in degrees, slides in the unit of
/// lengths.
std::string CurvesCsv(const Armature& armature, const JointCurves& curves);

/// The armature as a skeleton that moves, a frame for each frame of the film; rods are offsets,
/// each node turns by Euler angles, rods and groups by none. Its root "armature" (or another name
/// that no node has) stands still.
MotionClip CurvesClip(const Armature& armature, const JointCurves& curves);

}  // namespace keypose::armature
