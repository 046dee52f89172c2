#include "composite/light/plate_exposure.h"

#include <vector>

#include "core/numbers/statistics.h"

namespace keypose::composite {
namespace {

constexpr float kBlack = 0.02f, kWhite = 0.92f;  // linear light
constexpr std::size_t kFewest = 200;
constexpr int kStep = 3;  // pixels; neighbours say the same

double MedianOr(std::vector<float>& values, double otherwise) {
  if (values.size() < kFewest) return otherwise;
  return UpperMedianInPlace(values);
}

}  // namespace

Eigen::Vector3d ExposureOf(const ImageF& picture, const ImageF& plate, const Image8& away) {
  Eigen::Vector3d factors;
  for (int c = 0; c < 3; ++c) {
    std::vector<float> ratios;
    for (int y = kStep / 2; y < plate.height; y += kStep)
      for (int x = kStep / 2; x < plate.width; x += kStep) {
        if (!away.empty() && *away.at(x, y) > 127) continue;
        const float p = plate.at(x, y)[c], f = picture.at(x, y)[c];
        if (p > kBlack && p < kWhite && f > kBlack && f < kWhite) ratios.push_back(f / p);
      }
    factors[c] = MedianOr(ratios, 1);
  }
  return factors;
}

}  // namespace keypose::composite
