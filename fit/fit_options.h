// Options of keypose-fit.
#pragma once

#include "core/values/options.h"

namespace keypose::fit {

struct FitStageOptions {
  int max_size = 1600;
  double min_iou = 0.8;  ///< a lower overlap with the masks throws QualityError

  void Describe(OptionVisitor& visit) {
    visit("max_size", max_size,
          {"photographs are scaled down to this longer side", "px", 128, 16384});
    visit("min_iou", min_iou,
          {"fail when the result's outlines overlap with the masks by less than this (intersection "
           "over union, mean of the photographs)",
           "", 0, 1});
  }
};

}  // namespace keypose::fit
