// Options of keypose-animate.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::motion {

struct AnimateOptions {
  double fps = 24, from = 0, to = 0;
  std::string up = "auto";
  bool all_parts = false;

  void Describe(OptionVisitor& visit) {
    visit("fps", fps, {"frames per second of the result", "", 0.1, 1000, {}});
    visit("from", from, {"where in the clip it begins", "s", 0, 1e6, {}});
    visit("to", to, {"where in the clip it ends; 0: at the clip's end", "s", 0, 1e6, {}});
    visit(
        "up", up,
        {.help = "which way is up in the clip and in the rig; auto: for each, against its legs at "
                 "rest. The result has z up",
         .unit = "",
         .choices = {"auto", "y", "z"}});
    visit("all_parts", all_parts,
          {.help = "also the mesh's small separate parts, such as teeth; else only the largest"});
  }
};

}  // namespace keypose::motion
