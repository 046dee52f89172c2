// The second file: which joints of the armature and of the computer skeleton are one place, and
// which chains between them are matched.
//
//     anchor hips  physical pelvis    computer Hips     # NAME, node, joint
//     anchor head  physical skullTip  computer Head
//     chain neck  from hips to head  physical { neck1 neck2 }  computer { Neck Neck1 }  mode match
//
// The whole of it is in docs/file-formats.md. The paper only says that there is such a file.
#pragma once

#include <string>

#include "armature/description/armature.h"

namespace keypose::armature {

/// @param file  its name, for messages
/// @throws InputError  with line and column: malformed, an unknown word, node or anchor (names the
/// nearest known one), a name given twice, ends in different trees, a joint that is not on the way
/// between both ends, chains in a circle, two chains with one far end
ChainPlan ParseChains(const std::string& text, const std::string& file, const Armature& armature);

std::string ChainsText(const Armature& armature, const ChainPlan& plan);

}  // namespace keypose::armature
