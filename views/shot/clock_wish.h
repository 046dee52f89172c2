// Which clock the films of several cameras are joined by.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "views/clocks/clock_network.h"

namespace keypose {

struct ClockWish {
  enum class How {
    kStamps,  ///< each film's time stamps, as if all cameras had one clock
    kFound,   ///< offsets between them are looked for, in sound and motion
    kGiven,
  };
  How how = How::kStamps;
  std::vector<double> begins_s;            ///< of kGiven, a film each, in the order of their names
  std::map<std::string, FilmClock> named;  ///< of kGiven, instead, by cameras
};

/// What is wrong with the text of an option `clock_offsets`; empty: nothing.
std::vector<std::string> ClockWishProblems(const std::string& text);

/// @param text  auto, off, or when each film began [s], comma-separated; without problems
ClockWish ParseClockWish(const std::string& text);

/// What the option's help says.
inline constexpr const char* kClockOffsetsHelp =
    "offsets between the films' clocks: auto: found in their sound, else in what moves, where they "
    "are clear; off: as the time stamps say; or when each film began, in seconds, comma-separated, "
    "in the order of the cameras' names";

}  // namespace keypose
