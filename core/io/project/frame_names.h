// Which number in the names of a film's pictures counts its frames.
#pragma once

#include <string>
#include <vector>

namespace keypose {

struct FrameNumbering {
  std::vector<long> numbers;  ///< one for each name; empty: see fault
  /// Whether they are frames, so that a gap takes time. Dates and times of day only give an order:
  /// their numbers are 0, 1, 2, ...
  bool counted = true;
  std::string fault;  ///< why they cannot be numbered, with the cure; empty: they are
};

/// The number that differs from name to name counts, wherever it stands: in shot_0001.v2 the first,
/// in A001_0001_1920x1080 the second. Where several differ: a date with a time gives the order;
/// else the one that runs evenly counts. A minus before it (f_-2) is its sign. A camera's counter
/// that ran over from 9999 to 0001 goes on. Two names may get one number.
/// @param stems  names without their endings
FrameNumbering NumberNames(const std::vector<std::string>& stems);

}  // namespace keypose
