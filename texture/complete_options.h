// Options of keypose-complete.
#pragma once

#include "core/values/options.h"

namespace keypose::texture {

struct CompleteOptions {
  int gutter = 12;

  void Describe(OptionVisitor& visit) {
    visit("gutter", gutter, {"width by which colours continue around each chart", "px", 0, 256});
  }
};

}  // namespace keypose::texture
