#include "fit/bending/schedule.h"

#include <algorithm>

namespace keypose::fit {

// Chosen on the clay creature's seeds 1 to 4 (synth).
std::vector<Round> FarRounds(bool cameras_known) {
  std::vector<Round> rounds;
  if (!cameras_known)
    rounds = {{2, 100, 1, 0, 0, 10, 0.60, 1, 20, 10},
              {2, 30, 1, 0, 0, 10, 0.40, 1, 20, 8},
              {2, 10, 1, 0, 0, 10, 0.30, 1, 20, 6}};
  for (const Round& round : std::vector<Round>{{2, 3.0, 1, 0, 0, 10, 0.60, 1, 30, 4},
                                               {2, 2.0, 1, 0, 0, 10, 0.30, 1, 30, 4},
                                               {2, 1.0, 1, 0, 0, 10, 0.15, 1, 30, 4},
                                               {2, 1.0, 1, 1, 0, 10, 0.30, 2, 30, 3},
                                               {2, 0.5, 1, 1, 0, 10, 0.20, 2, 30, 4}})
    rounds.push_back(round);
  return rounds;
}

// Clicks are less exact than grey values, so picks let go.
std::vector<Round> NearRounds() {
  return {{2, 0.5, 1, 1, 1, 3, 0.15, 2, 30, 4, 0.15, 1},
          {1, 0.3, 1, 1, 1, 2, 0.10, 2, 30, 4, 0.06, 0.3},
          {1, 0.2, 1, 1, 1, 1, 0.08, 1, 20, 4, 0.04, 0.3},
          {0, 0.1, 0.5, 0.3, 1, 0.2, 0.05, 1, 10, 2},
          {0, 0.1, 0, 0.1, 1, 0.1, 0.03, 0, 10, 4}};
}

// In the order of Round's fields; the appearance asks for the overlap alone.
std::vector<Round> UntexturedRounds() {
  return {{2, 0.5, 0, 1, 1, 10, 0.20, 2, 30, 4},
          {1, 0.5, 0, 1, 1, 10, 0.15, 1, 20, 4},
          {1, 0.5, 0, 1, 1, 10, 0.10, 1, 20, 4},
          {0, 0.5, 0, 1, 1, 10, 0.05, 0, 10, 3}};
}

// The first rounds draw a pick's place from anywhere; later a wrong pick lets go.
double MarkScale(const Round& round) {
  constexpr double kWholeFigure = 2, kLeast = 0.3;
  return round.outlines > 0 ? std::max(round.scale, kLeast) : kWholeFigure;
}

}  // namespace keypose::fit
