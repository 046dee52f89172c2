// Shots in the size at which renders are compared with them; resampling is the image library's.
#pragma once

#include "report/view_evidence.h"

namespace keypose::report {

/// The shot at `factor` of its size; as it is where the factor is 1 or more.
Shot Shrunk(const Shot& shot, double factor);

}  // namespace keypose::report
