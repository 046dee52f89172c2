// Options of keypose-transfer.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::motion {

struct TransferStageOptions {
  std::string method = "auto", align = "auto", turns = "follow", space = "target";
  bool rest = true, volume = true, feet = true;
  double stretch = 0, scale = 0, fps = 0;

  void Describe(OptionVisitor& visit) {
    visit("method", method,
          {.help = "auto: volume kept, turns of any size, the target's proportions; paper: the "
                   "paper's system; literal: the same step by step, slow",
           .unit = "",
           .choices = {"auto", "paper", "literal"}});
    visit("align", align,
          {.help = "auto: the motion is turned to where the target faces, as its marks tell; none: "
                   "the template's own directions",
           .unit = "",
           .choices = {"auto", "none"}});
    visit("turns", turns,
          {.help = "auto: follow: a limb may turn by more than half a turn over several frames; "
                   "shortest: each frame by itself, for limbs that circle",
           .unit = "",
           .choices = {"follow", "shortest"}});
    visit("space", space,
          {.help = "where the result stands: target: with the target's size and directions; "
                   "template: over the template, as video3d needs it",
           .unit = "",
           .choices = {"target", "template"}});
    visit("rest", rest,
          {.help = "auto: limbs that the target holds otherwise at rest take the template's pose"});
    visit("volume", volume, {.help = "auto: each closed part keeps its volume"});
    visit("feet", feet,
          {.help = "auto: feet that stand do not slide, and none sinks into the ground"});
    visit(
        "stretch", stretch,
        {"auto: share of the template's own squash and stretch that is transferred", "", 0, 1, {}});
    visit("scale", scale,
          {"of the path through the room; 0: the ratio of the legs' lengths", "", 0, 1000, {}});
    visit("fps", fps,
          {"frames per second of the result; 0: the template's, else 24", "", 0, 1000, {}});
  }
};

}  // namespace keypose::motion
