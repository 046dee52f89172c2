// Options of `keypose armature bake`.
#pragma once

#include <string>
#include <vector>

#include "armature/live/puppet_files.h"
#include "core/values/options.h"

namespace keypose::armature {

struct BakeOptions {
  PuppetChoices puppet;
  std::string between = "hold";
  int step = 0;
  double fps = 0, smooth = 0;

  void Describe(OptionVisitor& visit) {
    visit("between", between,
          {.help = "from one recorded frame to the next: it stands (hard stops), or moves at even "
                   "pace, or along a smooth curve that goes beyond none of them; keys: only the "
                   "recorded poses, for interpolate",
           .choices = {"hold", "linear", "smooth", "keys"}});
    visit("step", step,
          {"frames of the film for each recorded one: 1 on ones, 2 on twos, more between key "
           "poses; 0: as recorded",
           "frames",
           0,
           1000,
           {}});
    visit("fps", fps, {"frames per second of the film; 0: as recorded", "", 0, 1000, {}});
    visit("smooth", smooth,
          {"width of a Gaussian over the joints' curves, in recorded frames; stops stay; 0: none",
           "frames",
           0,
           100,
           {}});
    puppet.Describe(visit);
  }
  std::vector<std::string> Problems() const {
    if (fps > 0 && fps < 0.1) return {"fps must be 0 or at least 0.1"};
    return {};
  }
};

}  // namespace keypose::armature
