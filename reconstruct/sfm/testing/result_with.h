// A result of a strategy.
#pragma once

#include <gmock/gmock.h>

#include <string>

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Of 16 photographs, all placed.
inline StrategyResult ResultWith(const std::string& method, double hull_overlap) {
  StrategyResult result{.method = method};
  result.evidence.images = result.evidence.placed = 16;
  result.evidence.outlines = true;
  result.evidence.hull_iou = hull_overlap;
  return result;
}

}  // namespace keypose::reconstruct
