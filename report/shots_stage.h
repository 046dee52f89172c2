// Shots resampled by the image library to the size at which renders are compared with them.
#pragma once

#include "report/view_evidence.h"

namespace keypose::report {

/// The shot scaled by `factor`; unchanged if the factor is 1 or more.
Shot Shrunk(const Shot& shot, double factor);

}  // namespace keypose::report
