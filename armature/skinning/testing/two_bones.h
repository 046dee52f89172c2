// A cylinder with two bones in it.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "armature/skinning/skin.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"

namespace keypose::armature {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// A tube along z with a bone in its lower and one in its upper half.
struct TwoBones {
  Mesh mesh = MakeCylinder(0.25, 4, 48, 80);
  std::vector<SkinBone> bones = {{"lower", {0, 0, 0}, {0, 0, 2}}, {"upper", {0, 0, 2}, {0, 0, 4}}};

  static std::vector<Rigid3> Bent(double degrees) {
    const Quaterniond turn(Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitX()));
    return {{}, {turn, Vector3d(0, 0, 2) - turn * Vector3d(0, 0, 2)}};
  }
};

}  // namespace keypose::armature
