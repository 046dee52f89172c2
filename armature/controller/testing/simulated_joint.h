// An arm of one joint, and the box that simulates its controller.
#pragma once

#include "armature/description/description_file.h"
#include "armature/simulation/simulated_box.h"

namespace keypose::armature {

inline Armature OneJoint() {
  return DescriptionFile::Parse("node { name a axis 1 0 0 sensor 0 scale 25 }", "arm.txt")
      .armature();
}

}  // namespace keypose::armature
