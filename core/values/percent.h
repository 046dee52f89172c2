// Shares as texts in percent.
#pragma once

#include <string>

namespace keypose {

/// "13 %" of 0.125: whole percent, halves away from zero.
std::string PercentHalfUp(double share);
/// "12 %" of 0.125: whole percent, halves to the even number, as printf and fmt round.
std::string PercentHalfEven(double share);

}  // namespace keypose
