// How dark the character's shadow on the table is, and where the lamp stands that throws it.
#pragma once

#include <vector>

#include "composite/layer/table_shadow.h"
#include "core/surfaces/ray_scene.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// Places of the table in one frame, and the share of light that each has lost there over a clean
/// plate, or over another frame, which has a shadow of its own elsewhere. The second needs no
/// plate: light = table * (1 - shadow) in both, so their ratio is free of the table, and 1 - ratio
/// = shadow - ratio * shadow of the other, which is linear in the strengths.
struct ShadowSamples {
  const RayScene* figure = nullptr;  ///< of the frame
  std::vector<Eigen::Vector3d> places;
  std::vector<double> lost;         ///< 1 - light of the frame / light of the plate or other
  const RayScene* other = nullptr;  ///< figure of the other frame; null: a plate without shadow
};

struct ShadowFit {
  ShadowStrength strength;
  double explained = 0;  ///< share of the lost light's variance that the fit explains, 0 to 1
  int samples = 0;
};

/// Searches the lamp's direction and size, and solves for both strengths, none below 0.
/// With fewer than 50 samples, or where nothing is lost, both strengths are 0.
/// Same bits for any thread count.
ShadowFit FitShadow(const std::vector<ShadowSamples>& frames, const Ground& ground);

}  // namespace keypose::composite
