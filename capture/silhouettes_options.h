// Options of keypose-silhouettes.
#pragma once

#include <string>
#include <vector>

#include "capture/segmentation/mask_options.h"
#include "core/values/figure_strokes.h"
#include "core/values/options.h"

namespace keypose::capture {

struct SilhouettesOptions {
  double clean_plate_difference = MaskOptions{}.clean_plate_difference;
  int mask_px = MaskOptions{}.working_px;
  std::string figure;
  bool network = true;

  void Describe(OptionVisitor& visit) {
    visit("clean_plate_difference", clean_plate_difference,
          {"colour difference to the empty set at which actor and set are equally likely",
           "CIE Lab",
           1,
           50,
           {}});
    visit("mask_px", mask_px, {"longer side at which masks are segmented", "px", 64, 4096, {}});
    visit("figure", figure,
          {"for films without the empty set: what is the actor, said by clicks and strokes in "
           "frames, CAMERA/FRAME:X,Y or CAMERA/FRAME:X,Y-X,Y...; a ! before it says what is not"});
    visit("network", network,
          {"for films without the empty set: ask the network for salient objects, where it is "
           "installed"});
  }
  std::vector<std::string> Problems() const { return FigureTextProblems(figure); }
};

}  // namespace keypose::capture
