#include "reconstruct/turntable/ring_bundle.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/tuned.h"
#include "reconstruct/bundle/bundle_projection.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct RingBundleTuning {
  /// of the largest error at the end: errors that enter the first solve
  KEYPOSE_TUNED(double, kFirstErrors, 8);
};

/// The unknown intrinsics: f and k1. The camera's other parameters are constant.
struct SharedIntrinsics {
  std::array<double, 2> focal_k1;
  Camera camera;
  std::array<double, 8> All() const {
    const double aspect = camera.fy / camera.fx;
    return {
        focal_k1[0], focal_k1[0] * aspect, camera.cx, camera.cy, focal_k1[1], camera.k2, camera.p1,
        camera.p2};
  }
};

/// Pixel error by (f, k1), ring rotation, ring translation, table angle, point.
class RingError : public ceres::SizedCostFunction<2, 2, 4, 3, 1, 3> {
 public:
  RingError(const Camera& camera, const Eigen::Vector2d& pixel) : camera_(camera), pixel_(pixel) {}
  bool Evaluate(const double* const* parameters, double* residual,
                double** jacobians) const override {
    const SharedIntrinsics intrinsics{{parameters[0][0], parameters[0][1]}, camera_};
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[1]);
    const Eigen::Map<const Vector3d> t(parameters[2]), x(parameters[4]);
    const double c = std::cos(parameters[3][0]), s = std::sin(parameters[3][0]);
    const Vector3d turned(c * x.x() - s * x.y(), s * x.x() + c * x.y(), x.z());
    Eigen::Matrix<double, 2, 8> of_camera;
    Eigen::Matrix<double, 2, 3> of_point;
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = ProjectPoint(intrinsics.All().data(), q * turned + t, jacobians ? &of_camera : nullptr,
                     jacobians ? &of_point : nullptr) -
        pixel_;
    if (!jacobians) return true;
    const Eigen::Matrix<double, 2, 3> of_turned = of_point * q.toRotationMatrix();
    if (jacobians[0]) {
      JacobianRows<2>(jacobians[0]).col(0) =
          of_camera.col(0) + camera_.fy / camera_.fx * of_camera.col(1);
      JacobianRows<2>(jacobians[0]).col(1) = of_camera.col(4);
    }
    if (jacobians[1]) JacobianRows<4>(jacobians[1]) = of_point * RotatedByQuaternion(q, turned);
    if (jacobians[2]) JacobianRows<3>(jacobians[2]) = of_point;
    if (jacobians[3])
      JacobianRows<1>(jacobians[3]) = of_turned * Vector3d(-turned.y(), turned.x(), 0);
    if (jacobians[4]) {
      Eigen::Matrix3d turn;
      turn << c, -s, 0, s, c, 0, 0, 0, 1;
      JacobianRows<3>(jacobians[4]) = of_turned * turn;
    }
    return true;
  }

 private:
  Camera camera_;
  Eigen::Vector2d pixel_;
};

/// weight * (value - goal).
struct Prior {
  double goal, weight;
  template <class T>
  bool operator()(const T* value, T* residual) const {
    residual[0] = weight * (value[0] - goal);
    return true;
  }
};

/// Priors of focal length and k1.
struct CameraPrior {
  double focal, focal_weight, k1, k1_weight;
  template <class T>
  bool operator()(const T* focal_k1, T* residual) const {
    residual[0] = focal_weight * (focal_k1[0] - focal);
    residual[1] = k1_weight * (focal_k1[1] - k1);
    return true;
  }
};

/// weight * (angle - index * step).
struct StepPrior {
  double index, weight;
  template <class T>
  bool operator()(const T* angle, const T* step, T* residual) const {
    residual[0] = weight * (angle[0] - index * step[0]);
    return true;
  }
};

/// Fixes the first ring's distance to the axis' origin, and that origin opposite the camera.
struct Gauge {
  double squared_distance, along_axis, weight;
  template <class T>
  bool operator()(const T* rotation, const T* translation, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q(rotation);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(translation);
    residual[0] = weight * (t.squaredNorm() - T(squared_distance));
    residual[1] = weight * ((q * Eigen::Matrix<T, 3, 1>(T(0), T(0), T(1))).dot(t) - T(along_axis));
    return true;
  }
};

double ErrorOf(const RingModel& model, const std::vector<SparsePoint>& points,
               const Observation& o) {
  const Vector3d x = model.CameraFromTable(model.views[o.view]) * points[o.point].position;
  return x.z() > 0 ? (model.camera.Project(x) - o.pixel).norm()
                   : std::numeric_limits<double>::infinity();
}

std::vector<Observation> Inliers(const RingModel& model, const std::vector<SparsePoint>& points,
                                 const std::vector<Observation>& all, double limit) {
  std::vector<int> count(points.size(), 0);
  std::vector<Observation> kept;
  for (const Observation& o : all)
    if (ErrorOf(model, points, o) <= limit) {
      kept.push_back(o);
      ++count[o.point];
    }
  std::erase_if(kept, [&](const Observation& o) { return count[o.point] < 2; });
  return kept;
}

/// One solve; model and points change in place.
class RingProblem {
 public:
  RingProblem(RingModel& model, std::vector<SparsePoint>& points,
              const std::vector<Observation>& observations, const RingBundleOptions& options,
              double focal_px)
      : model_(model),
        options_(options),
        camera_{{model.camera.fx, model.camera.k1}, model.camera} {
    for (const Observation& o : observations) AddObservation(o, points);
    AddPriors(focal_px);
    OrderCameras();
  }

  void Solve() {
    ceres::Solver::Options solver;
    solver.linear_solver_type = ceres::DENSE_SCHUR;  // on one thread, as in bundle_adjustment.cpp
    solver.linear_solver_ordering = ordering_;
    solver.max_num_iterations = options_.max_iterations;
    solver.function_tolerance = 1e-7;
    // a larger radius gains nothing, and rounding would make the reduced system indefinite
    solver.max_trust_region_radius = 1e7;
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &problem_, &summary);
    if (!summary.IsSolutionUsable())
      throw SolverError("sfm: ring bundle adjustment failed: " + summary.message);
    const double aspect = model_.camera.fy / model_.camera.fx;
    model_.camera.fx = camera_.focal_k1[0];
    model_.camera.fy = camera_.focal_k1[0] * aspect;
    model_.camera.k1 = camera_.focal_k1[1];
    for (Rigid3& ring : model_.rings) ring.rotation.normalize();
  }

 private:
  void AddObservation(const Observation& o, std::vector<SparsePoint>& points) {
    RingView& view = model_.views[o.view];
    Rigid3& ring = model_.rings[view.ring];
    double* point = points[o.point].position.data();
    problem_.AddResidualBlock(new RingError(model_.camera, o.pixel), &loss_,
                              camera_.focal_k1.data(), ring.rotation.coeffs().data(),
                              ring.translation.data(), &view.angle_rad, point);
    ordering_->AddElementToGroup(point, 0);
  }

  void AddPriors(double focal_px) {
    using ceres::AutoDiffCostFunction;
    // Residuals are pixels; one standard deviation of a prior has the weight of an error of
    // noise_px.
    const double slop = options_.noise_px / (options_.angle_prior_deg * kDegree),
                 step = options_.noise_px / (options_.step_prior_deg * kDegree);
    for (RingView& view : model_.views)
      problem_.AddResidualBlock(
          new AutoDiffCostFunction<StepPrior, 1, 1, 1>(new StepPrior{view.index, slop}), nullptr,
          &view.angle_rad, &model_.step_rad[view.ring]);
    for (double& value : model_.step_rad)
      problem_.AddResidualBlock(new AutoDiffCostFunction<Prior, 1, 1>(new Prior{value, step}),
                                nullptr, &value);
    Rigid3& first = model_.rings[0];
    const double squared = first.translation.squaredNorm();
    problem_.AddResidualBlock(
        new AutoDiffCostFunction<Gauge, 2, 4, 3>(
            new Gauge{squared, (first.rotation * Vector3d::UnitZ()).dot(first.translation),
                      1e3 / std::max(squared, 1e-12)}),
        nullptr, first.rotation.coeffs().data(), first.translation.data());
    problem_.AddResidualBlock(new AutoDiffCostFunction<CameraPrior, 2, 2>(new CameraPrior{
                                  focal_px, options_.noise_px / (options_.focal_prior * focal_px),
                                  0.0, options_.noise_px / options_.k1_prior}),
                              nullptr, camera_.focal_k1.data());
    if (!options_.refine_camera) problem_.SetParameterBlockConstant(camera_.focal_k1.data());
  }

  void OrderCameras() {
    // Ceres orders a group by address. One group per array makes the sums independent of memory
    // locations.
    ordering_->AddElementToGroup(camera_.focal_k1.data(), 1);
    for (Rigid3& ring : model_.rings) {
      if (!problem_.HasParameterBlock(ring.rotation.coeffs().data())) continue;
      problem_.SetManifold(ring.rotation.coeffs().data(), &quaternions_);
      ordering_->AddElementToGroup(ring.rotation.coeffs().data(), 2);
      ordering_->AddElementToGroup(ring.translation.data(), 2);
    }
    for (RingView& view : model_.views) ordering_->AddElementToGroup(&view.angle_rad, 3);
    for (double& step : model_.step_rad) ordering_->AddElementToGroup(&step, 4);
  }

  static ceres::Problem::Options Owned() {
    ceres::Problem::Options options;
    options.loss_function_ownership = options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    return options;
  }

  RingModel& model_;
  const RingBundleOptions& options_;
  SharedIntrinsics camera_;
  ceres::CauchyLoss loss_{options_.robust_px};
  ceres::EigenQuaternionManifold quaternions_;
  std::shared_ptr<ceres::ParameterBlockOrdering> ordering_ =
      std::make_shared<ceres::ParameterBlockOrdering>();
  ceres::Problem problem_{Owned()};
};

void RequireValid(const RingModel& model, const std::vector<SparsePoint>& points,
                  const std::vector<Observation>& observations) {
  for (const RingView& view : model.views)
    if (view.ring < 0 || view.ring >= std::ssize(model.rings) ||
        model.step_rad.size() != model.rings.size())
      throw InputError("ring bundle adjustment: a view names ring " + std::to_string(view.ring) +
                       ", which the model does not have");
  for (const Observation& o : observations)
    if (o.view < 0 || o.view >= std::ssize(model.views) || o.point < 0 ||
        o.point >= std::ssize(points))
      throw InputError("ring bundle adjustment: an observation names view " +
                       std::to_string(o.view) + " and point " + std::to_string(o.point) +
                       ", which the model does not have");
}

}  // namespace

RingBundleResult AdjustRingBundle(const RingModel& model, const std::vector<SparsePoint>& points,
                                  const std::vector<Observation>& observations,
                                  const RingBundleOptions& options) {
  RequireValid(model, points, observations);
  RingBundleResult result;
  result.model = model;
  result.points = points;
  result.observations =
      Inliers(model, points, observations, RingBundleTuning::kFirstErrors * options.max_error_px);
  for (int round = 0; round < 2; ++round) {
    RingProblem(result.model, result.points, result.observations, options,
                options.focal_px > 0 ? options.focal_px : model.camera.fx)
        .Solve();
    result.observations = Inliers(result.model, result.points, observations, options.max_error_px);
  }
  for (const Observation& o : result.observations) {
    const double error = ErrorOf(result.model, result.points, o),
                 scale2 = options.robust_px * options.robust_px;
    result.mean_error_px += error / static_cast<double>(result.observations.size());
    result.chi2 += scale2 * std::log1p(error * error / scale2);
  }
  result.unknowns = static_cast<int>(6 * result.model.rings.size() - 2 +
                                     result.model.step_rad.size() + result.model.views.size()) +
                    2;
  for (const RingView& view : result.model.views)
    result.slop_rad.push_back(view.angle_rad - view.index * result.model.step_rad[view.ring]);
  return result;
}

Scene SceneOf(const RingModel& model, const std::vector<std::string>& names,
              const std::vector<SparsePoint>& points) {
  Scene scene;
  for (const RingView& ring_view : model.views) {
    View view;
    view.name = names[ring_view.image];
    view.camera = model.camera;
    view.camera_from_world = model.CameraFromTable(ring_view);
    scene.views.push_back(view);
  }
  scene.points = points;
  return scene;
}

}  // namespace keypose::reconstruct
