// Faults of a simulated armature, made at given frames.
#pragma once

#include <string>
#include <vector>

#include "armature/description/armature.h"

namespace keypose::armature {

enum class FaultKind {
  kDrop,    ///< for 0.3 s the line loses most of its bytes
  kNoise,   ///< for 0.3 s the line changes bytes
  kGlitch,  ///< for 0.3 s a counter shows another number
  kWrap,    ///< from the start all counters stand near an end of their range, and wrap soon
  kStuck,   ///< an encoder counts no more until it is mended
  kLost,    ///< a counter alone loses power: it begins at 0
  kUnplug,  ///< the cable is out for half a second
  kPower    ///< the box loses power: all counters begin at 0
};

struct PlannedFault {
  FaultKind kind = FaultKind::kDrop;
  int sensor = -1;  ///< of kGlitch, kStuck and kLost; -1 of the others
  int frame = 0;    ///< at which it is made, from 0
};

/// "drop@5,stuck:leftKneeBend@20": kind, of some a joint's name, frame.
/// @throws UsageError  an unknown kind or joint (names the nearest), no frame, or a joint missing
std::vector<PlannedFault> ParseFaults(const std::string& text, const Armature& armature);

}  // namespace keypose::armature
