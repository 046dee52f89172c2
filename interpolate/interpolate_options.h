// Options of keypose-interpolate.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::interpolation {

struct InterpolateOptions {
  std::string method = "arap";
  int steps = 9;
  std::string align = "none";
  bool same_size = false;
  bool volume = true;

  void Describe(OptionVisitor& visit) {
    visit("method", method,
          {.help = "arap: as rigid as possible; volumetric: the same for the solid inside, for "
                   "strong twists; paper: exactly the paper's system; linear: straight lines",
           .unit = "",
           .choices = {"arap", "volumetric", "paper", "linear"}});
    visit("steps", steps,
          {"in-betweens of each pair of keys, where no timeline gives times",
           "frames",
           0,
           100000,
           {}});
    visit("align", align,
          {.help = "brings later keys onto the first; upright: a turn about z and a level "
                   "translation, so that each key stays on its ground",
           .unit = "",
           .choices = {"none", "upright", "rigid", "similarity"}});
    visit("same_size", same_size,
          {.help = "scales later keys to the first one's size (median edge): without a printed "
                   "calibration board the sizes of the poses differ"});
    visit("volume", volume,
          {.help = "the volume of each closed part follows the keys'; arap and volumetric only; a "
                   "timeline's own setting has precedence"});
  }
};

}  // namespace keypose::interpolation
