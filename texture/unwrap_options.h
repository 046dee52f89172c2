// Options of keypose-unwrap.
#pragma once

#include "core/values/options.h"
#include "texture/unwrap/unwrap.h"

namespace keypose::texture {

struct UnwrapStageOptions : UnwrapOptions {
  bool keep = false;

  void Describe(OptionVisitor& visit) {
    visit("keep", keep, {.help = "a mesh that has texture coordinates already keeps them"});
    UnwrapOptions::Describe(visit);
  }
};

}  // namespace keypose::texture
