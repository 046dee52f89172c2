#include "views/clocks/correlation.h"

#include <fftw3.h>

#include <algorithm>
#include <memory>
#include <mutex>

namespace keypose {
namespace {

struct FreeFftw {
  void operator()(void* memory) const { fftw_free(memory); }
};
using Reals = std::unique_ptr<double[], FreeFftw>;
using Spectrum = std::unique_ptr<fftw_complex[], FreeFftw>;

/// FFTW makes plans in one thread at a time.
std::mutex& Planning() {
  static std::mutex mutex;
  return mutex;
}

void Run(fftw_plan plan) {
  fftw_execute(plan);
  const std::lock_guard<std::mutex> lock(Planning());
  fftw_destroy_plan(plan);
}

Spectrum SpectrumOf(const std::vector<double>& values, int size) {
  Reals padded(fftw_alloc_real(static_cast<std::size_t>(size)));
  Spectrum spectrum(fftw_alloc_complex(static_cast<std::size_t>(size / 2 + 1)));
  fftw_plan plan;
  {
    const std::lock_guard<std::mutex> lock(Planning());
    plan = fftw_plan_dft_r2c_1d(size, padded.get(), spectrum.get(), FFTW_ESTIMATE);
  }
  std::copy(values.begin(), values.end(), padded.get());
  std::fill(padded.get() + values.size(), padded.get() + size, 0.0);
  Run(plan);
  return spectrum;
}

int PowerOfTwo(std::size_t least) {
  int size = 2;
  while (static_cast<std::size_t>(size) < least) size *= 2;
  return size;
}

}  // namespace

std::vector<double> CrossCorrelation(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.empty() || b.empty()) return {};
  const int size = PowerOfTwo(a.size() + b.size());
  const Spectrum of_a = SpectrumOf(a, size), of_b = SpectrumOf(b, size);
  for (int i = 0; i <= size / 2; ++i) {
    const double re = of_a[i][0] * of_b[i][0] + of_a[i][1] * of_b[i][1];
    const double im = of_a[i][0] * of_b[i][1] - of_a[i][1] * of_b[i][0];
    of_a[i][0] = re / size, of_a[i][1] = im / size;
  }
  Reals sums(fftw_alloc_real(static_cast<std::size_t>(size)));
  fftw_plan plan;
  {
    const std::lock_guard<std::mutex> lock(Planning());
    plan = fftw_plan_dft_c2r_1d(size, of_a.get(), sums.get(), FFTW_ESTIMATE);
  }
  Run(plan);
  // Negative lags are at the end.
  std::vector<double> lags(sums.get() + size - (a.size() - 1), sums.get() + size);
  lags.insert(lags.end(), sums.get(), sums.get() + b.size());
  return lags;
}

}  // namespace keypose
