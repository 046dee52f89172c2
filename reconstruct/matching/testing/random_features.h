// Features at random, and the same in another order.
#pragma once

#include <gmock/gmock.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// Random unit-512 descriptors, as SIFT's are: non-negative 8-bit numbers.
inline Features RandomFeatures(int count, std::mt19937& random) {
  Features features;
  features.positions.resize(count, 2);
  features.scales.resize(count);
  std::uniform_real_distribution<float> uniform(0, 1);
  for (int i = 0; i < count; ++i) {
    features.positions.row(i) << 640 * uniform(random), 480 * uniform(random);
    features.scales(i) = 1 + 10 * uniform(random);
    Eigen::VectorXd d(128);
    for (int k = 0; k < 128; ++k) d(k) = std::pow(uniform(random), 4);
    d *= 512 / d.norm();
    for (int k = 0; k < 128; ++k)
      features.descriptors.push_back(static_cast<std::int16_t>(std::min(255.0, std::round(d(k)))));
  }
  return features;
}

inline Features Permuted(const Features& features, const std::vector<int>& order) {
  Features out;
  out.positions.resize(std::ssize(order), 2);
  out.scales.resize(std::ssize(order));
  for (std::size_t i = 0; i < order.size(); ++i) {
    out.positions.row(i) = features.positions.row(order[i]);
    out.scales(static_cast<Eigen::Index>(i)) = features.scales(order[i]);
    const auto from = features.descriptors.begin() + static_cast<std::ptrdiff_t>(order[i]) * 128;
    out.descriptors.insert(out.descriptors.end(), from, from + 128);
  }
  return out;
}

inline std::vector<int> Shuffled(int count, std::mt19937& random) {
  std::vector<int> order(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) order[i] = i;
  for (int i = count - 1; i > 0; --i)
    std::swap(order[i], order[random() % static_cast<unsigned>(i + 1)]);
  return order;
}

}  // namespace keypose::reconstruct
