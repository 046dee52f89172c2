// Which joint of a clip moves which bone of a rig.
#pragma once

#include <string>
#include <vector>

#include "core/values/motion_clip.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion {

/// What a joint is in a body. Limbs follow: left ones first.
enum class BodyJoint {
  kNone,
  kHips,
  kSpine,
  kChest,
  kNeck,
  kHead,
  kCollarL,
  kUpperArmL,
  kForearmL,
  kHandL,
  kThighL,
  kShinL,
  kFootL,
  kToesL,
  kCollarR,
  kUpperArmR,
  kForearmR,
  kHandR,
  kThighR,
  kShinR,
  kFootR,
  kToesR
};

/// The meaning of each name, as CMU, Mixamo, MakeHuman, Blender, Poser and the `track` stage write
/// them: capitals, signs between words, prefixes such as "mixamorig:" or "Bip01 " and the place of
/// L and R do not matter. "Shoulder" is a collar where the names also have an arm or no elbow, else
/// an upper arm.
std::vector<BodyJoint> MeaningOf(const std::vector<std::string>& names);

/// A line of a person's own table.
struct JointName {
  std::string joint, bone;
};

/// For each bone of the rig the clip's joint that moves it, or -1: it moves with its parent.
/// Equal names go together; where fewer than half of a body's main joints are found so, names are
/// matched by what they mean.
/// @param given  a person's table; the bones and joints that it does not name are guessed
/// @throws InputError  the table names a joint or bone that does not exist; or neither hips nor
/// limbs are found and there is no table: lists the names
std::vector<int> MatchJoints(const MotionClip& clip, const RiggedMesh& rig,
                             const std::vector<JointName>& given);

/// Names of the hips, upper and lower arms and legs of the rig that no joint moves.
/// @param match  from MatchJoints
std::vector<std::string> BonesWithoutJoint(const RiggedMesh& rig, const std::vector<int>& match);

}  // namespace keypose::motion
