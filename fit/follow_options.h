// Options of keypose-follow.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::fit {

struct FollowStageOptions {
  double stiffness = 1, calm = 1.5;
  bool grey = true, volume = true;
  int vertices = 2500, max_size = 1000;
  std::string cameras;

  void Describe(OptionVisitor& visit) {
    visit("stiffness", stiffness,
          {"of the mesh: less follows finer folds, and noise of the masks", "", 0.01, 100, {}});
    visit("calm", calm,
          {"standard deviation in time of the means over frames; more is calmer, less follows "
           "faster waves of cloth",
           "frames",
           0,
           60,
           {}});
    visit("grey", grey,
          {.help = "what two films show alike counts beside outlines, and the texture if it is "
                   "given"});
    visit("volume", volume,
          {.help = "the volume of each closed part changes in time as it does in the frames"});
    visit("vertices", vertices,
          {"of the decimated copy that is bent; the mesh follows it", "", 100, 50000, {}});
    visit("max_size", max_size, {"films are scaled down to this longer side", "px", 100, 8192, {}});
    visit("cameras", cameras,
          {.help = "names of the cameras that are used, comma-separated; empty: all"});
  }
};

}  // namespace keypose::fit
