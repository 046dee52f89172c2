// What a performer's body is made of: round cones of flesh and cloth along the bones of a clip.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/motion_clip.h"

namespace keypose::synth {

/// A round cone of flesh or cloth between two points of a joint's bind frame.
struct Flesh {
  int joint = 0;
  Eigen::Vector3d a = Eigen::Vector3d::Zero(), b = a;  ///< in the bind pose's world [m]
  double ra = 0, rb = 0;
  bool cloth = false;
  Eigen::Vector3d color = Eigen::Vector3d::Zero();  ///< linear RGB
};

/// Signed distance [m] to the surface; negative inside.
double FleshDistance(const Flesh& lump, const Eigen::Vector3d& x);

/// Likewise, to all lumps, with fillets where they meet.
double BodyDistance(const std::vector<Flesh>& lumps, const Eigen::Vector3d& x);

/// The joints' frames of a clip whose y is up, in a world whose z is up.
std::vector<Rigid3> UprightFrames(const MotionClip& clip, int frame);

}  // namespace keypose::synth
