// An option that a command line gives a step.
#pragma once

#include <string>

namespace keypose::pipeline {

/// --set STEP.OPTION=V or STEP/POSE.OPTION=V
struct Override {
  std::string step, pose, option, value;
};

}  // namespace keypose::pipeline
