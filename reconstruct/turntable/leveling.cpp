#include "reconstruct/turntable/leveling.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct LevelingTuning {
  KEYPOSE_TUNED(double, kLeastTurn_deg, 8);  // rotations nearer to 0 or 180 degrees give no axis
  KEYPOSE_TUNED(double, kSharp_deg, 3);      // spread of the axes of one turntable
  // views of one ring: angle of their axis to the table's, and largest rise of the distance
  KEYPOSE_TUNED(double, kOneRing_deg, 3);
  KEYPOSE_TUNED(double, kRise, 0.1);
  // planes of the rings: second eigenvalue over the first, and largest angle to the axis so far
  KEYPOSE_TUNED(double, kFlat, 100);
  KEYPOSE_TUNED(double, kPlane_deg, 3);
  // of the distance: cameras farther from circles about the axis do not locate it
  KEYPOSE_TUNED(double, kOffCircle, 0.03);
  KEYPOSE_TUNED(double, kOutliers, 0.01);  // of the points, at each end
};

/// Axis of the rotation from view i to view j, in the world. Rotation angles near 0 and 180 degrees
/// give none.
struct PairAxis {
  int i, j;
  Vector3d axis;
  double weight;
};

std::vector<PairAxis> RelativeAxes(const std::vector<View>& views) {
  std::vector<PairAxis> axes;
  for (int i = 0; i < std::ssize(views); ++i)
    for (int j = i + 1; j < std::ssize(views); ++j) {
      const Eigen::AngleAxisd turn(
          (views[j].camera_from_world.rotation.conjugate() * views[i].camera_from_world.rotation)
              .normalized());
      const double angle = std::abs(turn.angle());
      if (angle > LevelingTuning::kLeastTurn_deg * kDegree &&
          angle < (180 - LevelingTuning::kLeastTurn_deg) * kDegree)
        axes.push_back({i, j, turn.axis(), std::sin(angle / 2)});
    }
  return axes;
}

/// Leading direction of axes within `radius` of `start`, or of all.
Vector3d MeanAxis(const std::vector<PairAxis>& axes, const Vector3d& start, double radius) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const PairAxis& a : axes)
    if (std::abs(a.axis.dot(start)) >= std::cos(radius))
      scatter += a.weight * a.axis * a.axis.transpose();
  if (scatter.trace() <= 0) return start;
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(scatter).eigenvectors().col(2);
}

/// The direction with the highest density of pair axes. Every axis (or every n-th of many) is tried
/// as a centre.
Vector3d DensestAxis(const std::vector<PairAxis>& axes) {
  const std::size_t step = std::max<std::size_t>(1, axes.size() / 1500);
  const double sharp = LevelingTuning::kSharp_deg * kDegree;
  Vector3d best = axes.front().axis;
  double best_votes = -1;
  for (std::size_t k = 0; k < axes.size(); k += step) {
    double votes = 0;
    for (std::size_t l = 0; l < axes.size(); l += step) {
      const double sine2 = 1 - std::pow(axes[k].axis.dot(axes[l].axis), 2);
      votes += axes[l].weight * std::exp(-sine2 / (2 * sharp * sharp));
    }
    if (votes > best_votes) {
      best_votes = votes;
      best = axes[k].axis;
    }
  }
  for (const double radius : {6.0, 4.0, 3.0, 3.0}) best = MeanAxis(axes, best, radius * kDegree);
  return best;
}

/// Groups of views related by rotations about the axis; groups of fewer than 4 are dropped.
std::vector<std::vector<int>> FindRings(const std::vector<View>& views,
                                        const std::vector<PairAxis>& axes, const Vector3d& axis,
                                        double distance) {
  std::vector<int> group(views.size());
  std::iota(group.begin(), group.end(), 0);
  const auto root = [&](int i) {
    while (group[i] != i) i = group[i];
    return i;
  };
  for (const PairAxis& a : axes) {
    const double rise = std::abs(axis.dot(views[a.i].Center() - views[a.j].Center()));
    if (std::abs(a.axis.dot(axis)) < std::cos(LevelingTuning::kOneRing_deg * kDegree) ||
        rise > LevelingTuning::kRise * distance)
      continue;
    const int ri = root(a.i), rj = root(a.j);
    group[std::max(ri, rj)] = std::min(ri, rj);
  }
  std::vector<std::vector<int>> by_root(views.size()), rings;
  for (int i = 0; i < std::ssize(views); ++i) by_root[root(i)].push_back(i);
  for (auto& ring : by_root)
    if (ring.size() >= 4) rings.push_back(std::move(ring));
  return rings;
}

/// Normal of the rings' common plane direction; `axis` itself if their arcs are too short.
Vector3d RefineByPlanes(const std::vector<View>& views, const std::vector<std::vector<int>>& rings,
                        const Vector3d& axis) {
  Matrix3d scatter = Matrix3d::Zero();
  for (const auto& ring : rings) {
    Vector3d mean = Vector3d::Zero();
    for (const int i : ring) mean += views[i].Center() / static_cast<double>(ring.size());
    for (const int i : ring) {
      const Vector3d d = views[i].Center() - mean;
      scatter += d * d.transpose();
    }
  }
  if (scatter.trace() <= 0) return axis;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(scatter);
  const Vector3d normal = solver.eigenvectors().col(0);
  const bool well_posed =
      solver.eigenvalues()(1) > LevelingTuning::kFlat * std::max(solver.eigenvalues()(0), 0.0) +
                                    1e-12 * solver.eigenvalues()(2);
  return well_posed && std::abs(normal.dot(axis)) > std::cos(LevelingTuning::kPlane_deg * kDegree)
             ? normal
             : axis;
}

/// Rotation whose third row is `up`.
Matrix3d UprightRotation(const Vector3d& up) {
  return Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ()).toRotationMatrix();
}

struct CommonCenter {
  Eigen::Vector2d center = Eigen::Vector2d::Zero();
  double rms = 0;
  bool valid = false;
};

/// Circles of any radii about one centre, in the plane perpendicular to the axis: linear in the
/// centre and one number per ring.
CommonCenter FitCenter(const std::vector<View>& views, const std::vector<std::vector<int>>& rings,
                       const Matrix3d& upright) {
  CommonCenter result;
  Eigen::Index rows = 0;
  for (const auto& ring : rings) rows += std::ssize(ring);
  if (rows < 5) return result;
  const auto unknowns = static_cast<Eigen::Index>(2 + rings.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(rows, unknowns);
  Eigen::VectorXd b(rows);
  Eigen::Index row = 0;
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (const int i : rings[r]) {
      const Eigen::Vector2d p = (upright * views[i].Center()).head<2>();
      a.row(row).head<2>() = 2 * p.transpose();
      a(row, static_cast<Eigen::Index>(2 + r)) = 1;
      b(row++) = p.squaredNorm();
    }
  const Eigen::VectorXd x = a.colPivHouseholderQr().solve(b);
  result.center = x.head<2>();
  double sum = 0;
  for (std::size_t r = 0; r < rings.size(); ++r) {
    const double radius =
        std::sqrt(std::max(0.0, x(static_cast<Eigen::Index>(2 + r)) + result.center.squaredNorm()));
    for (const int i : rings[r])
      sum += std::pow(((upright * views[i].Center()).head<2>() - result.center).norm() - radius, 2);
  }
  result.rms = std::sqrt(sum / static_cast<double>(rows));
  result.valid = x.allFinite();
  return result;
}

/// Quantile box of the points in the upright frame.
struct Box {
  Vector3d low, middle, high;
};

Box ObjectBox(const Scene& scene, const Matrix3d& upright) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const SparsePoint& point : scene.points)
      values.push_back(upright.row(k).dot(point.position));
    box.low(k) = QuantileFloor(values, LevelingTuning::kOutliers);
    box.high(k) = QuantileFloor(values, 1 - LevelingTuning::kOutliers);
  }
  box.middle = (box.low + box.high) / 2;
  return box;
}

Vector3d MeanUp(const std::vector<View>& views) {
  Vector3d up = Vector3d::Zero();
  for (const View& view : views)
    up -= view.camera_from_world.rotation.conjugate() * Vector3d::UnitY();
  return up;
}

double PlaneRms(const std::vector<View>& views, const std::vector<std::vector<int>>& rings,
                const Vector3d& axis) {
  double sum = 0, count = 0;
  for (const auto& ring : rings) {
    double mean = 0;
    for (const int i : ring) mean += axis.dot(views[i].Center()) / static_cast<double>(ring.size());
    for (const int i : ring) {
      sum += std::pow(axis.dot(views[i].Center()) - mean, 2);
      count += 1;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

double MeanDistance(const std::vector<View>& views, const Vector3d& from) {
  double sum = 0;
  for (const View& view : views) sum += (view.Center() - from).norm();
  return sum / static_cast<double>(views.size());
}

void RequireFit(const Scene& scene) {
  if (scene.views.size() < 3 || scene.points.size() < 10)
    throw InputError("sfm: the model has " + std::to_string(scene.views.size()) + " cameras and " +
                     std::to_string(scene.points.size()) +
                     " points, too few to find the turntable's axis; take more photographs all "
                     "round the object");
  double spread = 0;
  for (const View& view : scene.views)
    spread = std::max(spread, (view.Center() - scene.views[0].Center()).norm());
  if (!(spread > 0))
    throw InputError(
        "sfm: all cameras came out in one place; photograph the object from all round");
}

}  // namespace

Leveling LevelScene(const Scene& scene) {
  RequireFit(scene);
  const std::vector<PairAxis> axes = RelativeAxes(scene.views);
  Vector3d axis = axes.empty() ? MeanUp(scene.views).normalized() : DensestAxis(axes);
  const Box rough = ObjectBox(scene, Matrix3d::Identity());
  const double distance = MeanDistance(scene.views, rough.middle);
  std::vector<std::vector<int>> rings;
  for (int round = 0; round < 3; ++round) {
    rings = FindRings(scene.views, axes, axis, distance);
    axis = RefineByPlanes(scene.views, rings, axis);
  }
  if (axis.dot(MeanUp(scene.views)) < 0) axis = -axis;
  Matrix3d rotation = UprightRotation(axis);
  const Box box = ObjectBox(scene, rotation);
  const CommonCenter ring_center = FitCenter(scene.views, rings, rotation);
  Leveling level;
  level.rings = SizeOf(rings);
  level.ring_of_view.assign(scene.views.size(), -1);
  for (std::size_t r = 0; r < rings.size(); ++r)
    for (const int i : rings[r]) level.ring_of_view[i] = static_cast<int>(r);
  // The axis is used if the rings agree on it and it passes through the object's box; else the
  // object's centre.
  const Eigen::Vector2d half = ((box.high - box.low) / 2).head<2>();
  const Eigen::Vector2d off = (ring_center.center - box.middle.head<2>()).cwiseAbs();
  level.centered_on_axis = ring_center.valid &&
                           ring_center.rms < LevelingTuning::kOffCircle * distance &&
                           (off.array() < half.array()).all();
  Vector3d origin(box.middle.x(), box.middle.y(), box.low.z());
  if (level.centered_on_axis) origin.head<2>() = ring_center.center;
  const Vector3d first = rotation * scene.views[0].Center() - origin;
  const double azimuth = std::atan2(first.y(), first.x());
  const Matrix3d turn =
      Eigen::AngleAxisd(-std::acos(-1.0) / 2 - azimuth, Vector3d::UnitZ()).toRotationMatrix();
  const double scale = 1 / MeanDistance(scene.views, rotation.transpose() * box.middle);
  level.level_from_model.scale = scale;
  level.level_from_model.rotation = turn * rotation;
  level.level_from_model.translation = -scale * (turn * origin);
  level.plane_rms = PlaneRms(scene.views, rings, axis) * scale;
  level.circle_rms = ring_center.rms * scale;
  return level;
}

}  // namespace keypose::reconstruct
