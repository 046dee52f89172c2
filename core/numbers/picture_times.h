// At which rate pictures follow each other, by their times.
#pragma once

#include <vector>

namespace keypose {

struct PictureRate {
  double per_second = 0;  ///< while no picture is missing; 0: one picture alone
  /// Each picture lies within a quarter of a frame of where this rate has it.
  bool constant = true;
};

/// @param times_s  ascending [s]
/// @param header   what a header says [1/s]; taken exactly where the times confirm it. 0: nothing
PictureRate RateOf(const std::vector<double>& times_s, double header);

/// How many frames of the rate after the first one each picture begins: 0, 1, 2, ... where it is
/// constant. Ascending: of two that fall on one frame the later moves on.
std::vector<int> FrameNumbers(const std::vector<double>& times_s, const PictureRate& rate);

}  // namespace keypose
