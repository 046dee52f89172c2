// Options of keypose-masks.
#pragma once

#include <string>
#include <vector>

#include "capture/agreement/space_options.h"
#include "capture/segmentation/mask_options.h"
#include "core/values/figure_strokes.h"
#include "core/values/options.h"

namespace keypose::capture {

struct MasksOptions {
  int mask_px = MaskOptions{}.working_px;
  double mask_smoothness = MaskOptions{}.smoothness;
  int resolution = SpaceOptions{}.resolution;
  std::string figure;  ///< as ParseFigureStrokes reads it

  MaskOptions Masking() const {
    MaskOptions masking;
    masking.working_px = mask_px;
    masking.smoothness = mask_smoothness;
    return masking;
  }
  SpaceOptions Space() const {
    SpaceOptions space;
    space.resolution = resolution;
    return space;
  }
  void Describe(OptionVisitor& visit) {
    visit("mask_px", mask_px, {"longer side at which masks are segmented", "px", 64, 4096, {}});
    visit("mask_smoothness", mask_smoothness,
          {"cost of a mask border through a surface of one colour", "log odds", 0, 200, {}});
    visit("resolution", resolution,
          {"voxels along the longest side of the space that the masks share", "", 16, 256, {}});
    visit("figure", figure, {kFigureHelp});
  }
  std::vector<std::string> Problems() const { return FigureTextProblems(figure); }
};

}  // namespace keypose::capture
