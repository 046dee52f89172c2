// Changes of a recorded take, as an animator makes them on a dope sheet: stops stay hard, nothing
// is smoothed, and what is not named stays the same bits.
#pragma once

#include <string>
#include <vector>

#include "armature/recording/joint_curves.h"

namespace keypose::armature {

enum class EditKind {
  kHold,  ///< frames after `first` up to `last` stand as `first`
  kSet,   ///< frames from `first` to `last` get `amount`
  kAdd,   ///< frames from `first` to `last` get `amount` more
  kMove,  ///< they go `by` frames later, over what is there; what they leave stands as before them
  kDelete,  ///< they are taken out, of all joints
  kRepeat,  ///< `first` is shown `by` frames longer, in all joints
  kStep     ///< a recorded frame is shown for `by` frames of the film; the length stays
};

struct CurveEdit {
  EditKind kind = EditKind::kHold;
  int joint = -1;  ///< -1: all
  int first = 0, last = 0, by = 0;
  double amount = 0;  ///< [rad], slides [m]
  int line = 0;       ///< of the file, from 1; for messages
};

/// Lines such as `hold leftKneeBend 3-6`, `add all 4 -2.5` (degrees; slides in the description's
/// unit), `move neck 8-10 by 2`, `delete 4-5`, `repeat 7 by 3`, `step 2`. `#` begins a comment.
/// @throws InputError  names file and line, what is wrong, and the nearest joint
std::vector<CurveEdit> ParseCurveEdits(const std::string& text, const std::string& file,
                                       const Armature& armature);

/// @throws InputError  a frame that the take does not have at that moment; no frame would be left;
/// a value that is set, or added to, beyond the joint's limits; names the line
JointCurves EditedCurves(const Armature& armature, JointCurves curves,
                         const std::vector<CurveEdit>& edits);

/// A joint's value as edits and pages write it, and the unit's name: degrees; of a slide the
/// description's unit.
struct EditUnit {
  double size = 1;  ///< in [rad] or [m]
  const char* name = "";
};
EditUnit EditUnitOf(const Armature& armature, int joint);

}  // namespace keypose::armature
