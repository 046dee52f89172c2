// A room in few small photographs.
#pragma once

#include <cstdint>
#include <string>

#include "synth/rooms/room_plan.h"

namespace keypose::synth {

/// A small room in about a second.
inline RoomOptions Small(const std::string& kind, std::uint64_t seed = 3, int photographs = 6) {
  RoomOptions options;
  options.kind = kind, options.seed = seed, options.photographs = photographs;
  options.width = 240, options.height = 160;
  options.second = "none", options.hands = 0;
  options.detail = 0.06, options.spacing_m = 0.007;
  return options;
}

}  // namespace keypose::synth
