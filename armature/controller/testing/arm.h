// An arm of two joints.
#pragma once

#include "armature/description/description_file.h"

namespace keypose::armature {

inline Armature Arm() {
  return DescriptionFile::Parse(
             "node { name a axis 1 0 0 sensor 1 scale 25 node { name b axis 1 0 0 sensor 0 scale "
             "-10 } }",
             "arm.txt")
      .armature();
}

}  // namespace keypose::armature
