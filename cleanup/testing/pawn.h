// A pawn of a chess set, as it is and as a scan has it: with a cap or a rod below.
#pragma once

#include <cmath>
#include <vector>

#include "cleanup/testing/damaged_meshes.h"
#include "core/testing/shots.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

constexpr double kCap = 0.06;  // about 0.4 tan(12 degrees), minus the effect of smoothing

/// A pawn that stands at z = 0, without or with a cap of the visual hull below its foot of radius
/// 0.4.
/// @param below  further rows of the profile
inline Mesh Pawn(const std::vector<Eigen::Vector2d>& below) {
  std::vector<Eigen::Vector2d> profile;
  for (int i = 1; i <= 6; ++i)
    profile.emplace_back(0.25 * std::sin(0.4 * i), 1.25 + 0.25 * std::cos(0.4 * i));
  for (int i = 0; i <= 8; ++i) profile.emplace_back(0.2 + 0.2 * i * i / 64.0, 1.0 - 0.1 * i);
  profile.emplace_back(0.4, 0.1);
  profile.emplace_back(0.4, 0);
  profile.insert(profile.end(), below.begin(), below.end());
  return MakeRevolved(profile, 64);
}

inline Mesh TruePawn() { return Pawn({{0.2, 0}}); }

inline Mesh WithCap() {
  return Pawn({{0.3, -0.25 * kCap}, {0.2, -0.5 * kCap}, {0.1, -0.75 * kCap}, {0.03, -kCap}});
}

inline MaskShot Photograph(const Mesh& mesh, const std::vector<double>& elevations_deg) {
  return MasksFromRings(mesh, {0, 0, 0.7}, elevations_deg, 10, 320);
}

}  // namespace keypose::cleanup
