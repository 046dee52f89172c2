// How dark the character's shadow on the table is, and where the lamp stands that throws it.
#pragma once

#include <vector>

#include "composite/layer/table_shadow.h"
#include "core/ray_scene.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// Places of the table in one frame, and the share of its light that each has lost.
struct ShadowSamples {
  const RayScene* figure = nullptr;  ///< of the frame
  std::vector<Eigen::Vector3d> places;
  std::vector<double> lost;  ///< 1 - frame / plate
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
