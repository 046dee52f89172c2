#include "capture/films/film_exposure.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"

namespace keypose::capture {
namespace {

constexpr int kStride = 3;                // every so many pixels is looked at
constexpr int kDark = 24, kBright = 235;  // values beyond say little about the exposure
constexpr std::size_t kFewest = 200;      // pixels, for a median
constexpr std::size_t kMostForMedian = 31;

}  // namespace

ExposureGain ExposureGainOf(const Image8& frame, const Image8& usual) {
  ExposureGain gain{1, 1, 1};
  std::vector<float> ratios;
  for (std::size_t c = 0; c < 3; ++c) {
    ratios.clear();
    for (std::size_t p = c; p < frame.data.size(); p += 3 * kStride) {
      const int here = frame.data[p], there = usual.data[p];
      if (std::min(here, there) < kDark || std::max(here, there) > kBright) continue;
      ratios.push_back(static_cast<float>(there) / static_cast<float>(here));
    }
    if (ratios.size() < kFewest) return {1, 1, 1};
    gain[c] = UpperMedianInPlace(ratios);
  }
  return gain;
}

Image8 WithGain(const Image8& frame, const ExposureGain& gain) {
  std::array<std::array<std::uint8_t, 256>, 3> table;
  for (std::size_t c = 0; c < 3; ++c)
    for (std::size_t v = 0; v < 256; ++v)
      table[c][v] = static_cast<std::uint8_t>(
          std::lround(std::clamp(static_cast<double>(v) * gain[c], 0.0, 255.0)));
  Image8 even = frame;
  for (std::size_t p = 0; p < even.data.size(); ++p) even.data[p] = table[p % 3][even.data[p]];
  return even;
}

Image8 MedianOf(const std::vector<Image8>& frames) {
  Image8 median = frames.front();
  const std::size_t count = std::min(kMostForMedian, frames.size());
  const std::size_t row = static_cast<std::size_t>(median.width) * 3;
  ParallelFor(median.height, [&](std::int64_t y) {
    std::vector<std::uint8_t> values(count);
    for (std::size_t i = static_cast<std::size_t>(y) * row, end = i + row; i < end; ++i) {
      for (std::size_t k = 0; k < count; ++k) values[k] = frames[k * frames.size() / count].data[i];
      median.data[i] = UpperMedianInPlace(values);
    }
  });
  return median;
}

std::vector<ExposureGain> ExposureGains(const std::vector<Image8>& frames) {
  if (frames.empty()) return {};
  const Image8 usual = MedianOf(frames);
  std::vector<ExposureGain> gains(frames.size());
  ParallelFor(std::ssize(frames), [&](std::int64_t i) {
    gains[static_cast<std::size_t>(i)] = ExposureGainOf(frames[static_cast<std::size_t>(i)], usual);
  });
  return gains;
}

}  // namespace keypose::capture
