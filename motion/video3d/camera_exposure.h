// Exposure and white balance of several cameras, levelled by what they show of the same
// surface.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::motion {

/// A point of the surface that two cameras show.
struct ColorPair {
  int a = 0, b = 0;                  ///< cameras
  Eigen::Vector3f color_a, color_b;  ///< linear light
  float weight = 1;
};

struct CameraExposures {
  /// per camera: factors of its linear colours after which all agree; their geometric mean is 1
  std::vector<Eigen::Vector3f> gains;
  std::vector<char> compared;  ///< per camera: 0: it shares no surface with the others; gain 1
};

/// Least squares of logarithms, with weights that fall for pairs that disagree (Cauchy): highlights
/// and wrong places have little say. Pairs that are darker than 2 % are left out.
/// Same bits for any thread count.
CameraExposures LevelExposures(const std::vector<ColorPair>& pairs, int cameras);

}  // namespace keypose::motion
