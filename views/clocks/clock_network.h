// The clocks of several films from offsets between pairs of them.
#pragma once

#include <vector>

#include "views/clocks/signal_offset.h"

namespace keypose {

/// What a film's clock shows, by one that all have in common: rate * time + begin_s.
struct FilmClock {
  double begin_s = 0;
  double rate = 1;
};

/// Two films whose clocks were compared.
struct ClockLink {
  int a = 0, b = 0;  ///< films
  ClockDrift drift;  ///< from a to b; confident
};

struct ClockNetwork {
  std::vector<FilmClock> clocks;  ///< a film each; the earliest begin is 0
  double worst_s = 0;             ///< by which a link contradicts them
  int worst_link = -1;
};

/// Which of these links say the same as two others by way of a third film.
/// @param links  a < b in each, a pair once
std::vector<bool> ConfirmedByThird(const std::vector<ClockLink>& links, double within_s);

/// Numbers films so that those which links join have the same one, counted from 0 in the films'
/// order.
std::vector<int> LinkedGroups(int films, const std::vector<ClockLink>& links);

/// Clocks that agree with all links as well as possible (least squares). Rates other than 1 are
/// found only where the two ends of a link differ by more than `least_drift_s`.
/// @param links  that join all films
ClockNetwork SolveClocks(int films, const std::vector<ClockLink>& links, double least_drift_s);

}  // namespace keypose
