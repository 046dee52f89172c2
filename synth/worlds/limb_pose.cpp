#include "synth/worlds/limb_pose.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/self_intersections.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr int kTriesPerAngle = 12;         // tried at one angle
constexpr int kAngleSteps = 8;             // each closer to the least one
constexpr double kAngleShrink = 0.7;       // of what the angle has above the least one
constexpr double kCheckSpacing_m = 0.006;  // of the surface that poses are checked on
/// A bend across this much of the common hinge [sine] or less would turn the limb another way.
constexpr double kLeastAcross = 0.35;

/// The nearest rotation: the derivative beyond a joint is one up to rounding.
Matrix3d RotationOf(const Matrix3d& jacobian) {
  const Eigen::JacobiSVD<Matrix3d> svd(jacobian, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d signs(1, 1, (svd.matrixU() * svd.matrixV().transpose()).determinant());
  return svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
}

Mesh CheckedSurface(const Clay& clay) {
  Vector3d low, high;
  clay.Bounds(&low, &high);
  return Polygonize([&](const Vector3d& x) { return clay.Distance(x); }, low, high,
                    kCheckSpacing_m);
}

/// Bends every joint of a limb about the same axis in space, as far as its direction permits.
/// @param hinge  unit, in the rest pose's space
/// @return nothing if a joint lies along the hinge
std::optional<std::vector<Deformation>> BendLimb(const Pose& before, const PosableLimb& limb,
                                                 const Vector3d& hinge, double degrees) {
  double all = 0;
  for (const Joint& joint : limb.joints) all += joint.most_deg;
  Pose pose = before;
  std::vector<Deformation> bends;
  for (const Joint& joint : limb.joints) {
    // What is bent nearer to the root carries this joint with it.
    const Matrix3d turned = RotationOf(pose.Jacobian(joint.spine.back()));
    const Vector3d axis = turned * joint.axis;
    const Vector3d across = hinge - hinge.dot(axis) * axis;
    if (across.norm() < kLeastAcross) return std::nullopt;
    Deformation bend;
    bend.kind = Deformation::Kind::kBend;
    bend.origin = pose(joint.spine.back()) - turned * (joint.spine.back() - joint.origin);
    bend.axis = axis;
    bend.hinge = across.normalized();
    bend.begin = joint.begin;
    bend.end = joint.end;
    bend.angle = degrees * joint.most_deg / all * kPi / 180;
    bend.spine = joint.spine;
    bend.radius = joint.radius;
    bend.falloff = joint.falloff;
    bends.push_back(bend);
    pose.steps.push_back(bend);
  }
  return bends;
}

/// What a pose must keep, on a surface of fixed resolution.
class PoseCheck {
 public:
  PoseCheck(const Clay& clay, const LimbPoseOptions& options)
      : options_(options), rest_(CheckedSurface(clay)) {
    top_ = 1.1 * rest_.points.col(2).maxCoeff();
    reach_ = 1.1 * rest_.points.leftCols<2>().rowwise().norm().maxCoeff();
  }

  bool Accepts(const Pose& pose) const {
    const PointsX3 posed = pose(rest_.points);
    return StaysInPlace(posed) && StaysApart(posed) && StaysOneToOne(pose) &&
           !HasSelfIntersections(posed, rest_.faces, TouchingFaces::kLeftOut);
  }

 private:
  bool StaysInPlace(const PointsX3& posed) const {
    for (Eigen::Index i = 0; i < posed.rows(); ++i) {
      if (posed.row(i) == rest_.points.row(i)) continue;
      if (posed(i, 2) < std::min(rest_.points(i, 2), options_.clearance_m) - 1e-4) return false;
      if (posed(i, 2) > top_ || posed.row(i).head<2>().norm() > reach_) return false;
    }
    return true;
  }

  bool StaysApart(const PointsX3& posed) const {
    constexpr double kFar = 0.02;  // [m] farther apart than a joint is long when it is bent
    const KdTree tree(posed);
    for (Eigen::Index i = 0; i < posed.rows(); ++i) {
      if (posed.row(i) == rest_.points.row(i)) continue;
      for (const KdTree::Neighbor& near : tree.Within(posed.row(i), options_.clearance_m))
        if ((rest_.points.row(i) - rest_.points.row(near.index)).norm() > kFar) return false;
    }
    return true;
  }

  bool StaysOneToOne(const Pose& pose) const {
    std::vector<char> good(static_cast<std::size_t>(rest_.points.rows()));
    const auto check = [&](std::int64_t i) {
      good[i] = pose.Jacobian(rest_.points.row(i)).determinant() >= options_.least_determinant;
    };
    ParallelFor(rest_.points.rows(), check, 256);
    return std::all_of(good.begin(), good.end(), [](char ok) { return ok != 0; });
  }

  LimbPoseOptions options_;
  Mesh rest_;
  double top_, reach_;
};

/// Adds one limb's bends to the pose; other directions and smaller angles where it collides.
void MoveLimb(const PosableLimb& limb, const PoseCheck& check, const LimbPoseOptions& options,
              Random& random, Pose& pose) {
  const Vector3d u = limb.joints.front().axis.unitOrthogonal(),
                 v = limb.joints.front().axis.cross(u);
  double degrees = random.Uniform(options.least_deg, options.most_deg);
  for (int k = 0; k < kAngleSteps; ++k) {
    for (int i = 0; i < kTriesPerAngle; ++i) {
      const double azimuth = random.Uniform(0, 2 * kPi);
      const auto bends =
          BendLimb(pose, limb, std::cos(azimuth) * u + std::sin(azimuth) * v, degrees);
      if (!bends) continue;
      Pose moved = pose;
      moved.steps.insert(moved.steps.end(), bends->begin(), bends->end());
      const double angle = LimbAngleDeg(moved, limb);
      if (angle < options.least_deg || angle > options.most_deg || !check.Accepts(moved)) continue;
      pose = std::move(moved);
      return;
    }
    degrees = options.least_deg + kAngleShrink * (degrees - options.least_deg);
  }
  throw InputError("synth: the limb '" + limb.name +
                   "' collides whichever way it is moved; take another --pose-seed");
}

}  // namespace

double LimbAngleDeg(const Pose& pose, const PosableLimb& limb) {
  return Eigen::AngleAxisd(RotationOf(pose.Jacobian(limb.tip))).angle() * 180 / kPi;
}

Pose RandomLimbPose(const Clay& clay, const std::vector<PosableLimb>& limbs, std::uint64_t seed,
                    const LimbPoseOptions& options) {
  const PoseCheck check(clay, options);
  Random random(Hash(seed) + 61);
  Pose pose{"limbs", {}};
  for (const PosableLimb& limb : limbs) MoveLimb(limb, check, options, random, pose);
  return pose;
}

}  // namespace keypose::synth
