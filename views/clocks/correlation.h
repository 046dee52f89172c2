// Correlation of two rows of numbers at all lags.
#pragma once

#include <vector>

namespace keypose {

/// Sums of a[i] b[i + lag], for lags from -(a.size() - 1) to b.size() - 1, in this order; empty if
/// a or b is. By FFTW, in n log n. Same bits for any thread count.
std::vector<double> CrossCorrelation(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace keypose
