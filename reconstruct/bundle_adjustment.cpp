#include "reconstruct/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/errors.h"

namespace keypose::reconstruct {
namespace {

using Intrinsics = std::array<double, 8>;  // fx fy cx cy k1 k2 p1 p2

/// Pixel error of one observation. The distortion is Brown's, as in core/camera.h. Derivatives by hand: automatic ones of 18 unknowns cost
/// more than the solve.
class ReprojectionError : public ceres::SizedCostFunction<2, 8, 4, 3, 3> {
 public:
  explicit ReprojectionError(const Eigen::Vector2d& pixel) : pixel_(pixel) {}

  bool Evaluate(const double* const* parameters, double* residual, double** jacobians) const override {
    const double* camera = parameters[0];
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[1]);
    const Eigen::Map<const Eigen::Vector3d> t(parameters[2]), x(parameters[3]);
    const Eigen::Vector3d turned = q * x, in_camera = turned + t;
    const double u = in_camera.x() / in_camera.z(), v = in_camera.y() / in_camera.z(), r2 = u * u + v * v;
    const double k1 = camera[4], k2 = camera[5], p1 = camera[6], p2 = camera[7], radial = 1 + r2 * (k1 + r2 * k2);
    const double du = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u), dv = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v);
    residual[0] = camera[0] * du + camera[2] - pixel_.x();
    residual[1] = camera[1] * dv + camera[3] - pixel_.y();
    if (!jacobians) return true;
    if (jacobians[0]) {
      Rows<8>(jacobians[0]) << du, 0, 1, 0, camera[0] * u * r2, camera[0] * u * r2 * r2, camera[0] * 2 * u * v,
          camera[0] * (r2 + 2 * u * u),  //
          0, dv, 0, 1, camera[1] * v * r2, camera[1] * v * r2 * r2, camera[1] * (r2 + 2 * v * v), camera[1] * 2 * u * v;
    }
    const double slope = 2 * (k1 + 2 * r2 * k2);  // of `radial` by r2, twice: d radial / du = slope u
    Eigen::Matrix2d of_ray;
    of_ray(0, 0) = camera[0] * (radial + u * u * slope + 2 * p1 * v + 6 * p2 * u);
    of_ray(0, 1) = camera[0] * (u * v * slope + 2 * p1 * u + 2 * p2 * v);
    of_ray(1, 0) = camera[1] * (u * v * slope + 2 * p2 * v + 2 * p1 * u);
    of_ray(1, 1) = camera[1] * (radial + v * v * slope + 2 * p2 * u + 6 * p1 * v);
    Eigen::Matrix<double, 2, 3> ray_of_point;
    ray_of_point << 1 / in_camera.z(), 0, -u / in_camera.z(), 0, 1 / in_camera.z(), -v / in_camera.z();
    const Eigen::Matrix<double, 2, 3> of_point = of_ray * ray_of_point;
    if (jacobians[1]) Rows<4>(jacobians[1]) = of_point * ByQuaternion(q, x);
    if (jacobians[2]) Rows<3>(jacobians[2]) = of_point;
    if (jacobians[3]) Rows<3>(jacobians[3]) = of_point * q.toRotationMatrix();
    return true;
  }

 private:
  template <int kColumns>
  static Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>> Rows(double* values) {
    return Eigen::Map<Eigen::Matrix<double, 2, kColumns, Eigen::RowMajor>>(values);
  }
  /// Derivative of q * x by the coefficients (x, y, z, w) of a unit q, where q * x = x + 2 w (v x x) + 2 v x (v x x).
  static Eigen::Matrix<double, 3, 4> ByQuaternion(const Eigen::Quaterniond& q, const Eigen::Vector3d& x) {
    const Eigen::Vector3d v = q.vec();
    Eigen::Matrix3d cross;
    cross << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0;
    Eigen::Matrix<double, 3, 4> j;
    j.leftCols<3>() = 2 * (v.dot(x) * Eigen::Matrix3d::Identity() + v * x.transpose() - 2 * x * v.transpose() - q.w() * cross);
    j.col(3) = 2 * v.cross(x);
    return j;
  }

  Eigen::Vector2d pixel_;
};

Intrinsics FromCamera(const Camera& c) { return {c.fx, c.fy, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2}; }

void ToCamera(const Intrinsics& in, Camera& c) {
  c.fx = in[0], c.fy = in[1], c.cx = in[2], c.cy = in[3];
  c.k1 = in[4], c.k2 = in[5], c.p1 = in[6], c.p2 = in[7];
}

void RequireValid(const Scene& scene, const std::vector<Observation>& observations) {
  if (scene.views.size() < 2) throw InputError("bundle adjustment needs two views or more, got " + std::to_string(scene.views.size()));
  for (const View& view : scene.views)
    if (FromCamera(view.camera) != FromCamera(scene.views[0].camera))
      throw InputError("bundle adjustment: " + view.name + " has another camera than " + scene.views[0].name + "; one camera is assumed");
  for (const Observation& o : observations)
    if (o.view < 0 || o.view >= static_cast<int>(scene.views.size()) || o.point < 0 || o.point >= static_cast<int>(scene.points.size()))
      throw InputError("bundle adjustment: an observation names view " + std::to_string(o.view) + " and point " + std::to_string(o.point) +
                       ", which the scene does not have");
}

double ErrorOf(const Scene& scene, const Observation& o) {
  const View& view = scene.views[static_cast<std::size_t>(o.view)];
  const Eigen::Vector3d x = view.camera_from_world * scene.points[static_cast<std::size_t>(o.point)].position;
  if (x.z() <= 0) return std::numeric_limits<double>::infinity();
  return (view.camera.Project(x) - o.pixel).norm();
}

double MeanError(const Scene& scene, const std::vector<Observation>& observations) {
  double sum = 0, count = 0;
  for (const Observation& o : observations)
    if (const double error = ErrorOf(scene, o); std::isfinite(error)) sum += error, count += 1;
  return count > 0 ? sum / count : 0;
}

std::vector<int> FixedIntrinsics(const BundleOptions& options) {
  std::vector<int> fixed;
  if (!options.refine_principal_point) fixed.insert(fixed.end(), {2, 3});
  if (!options.refine_distortion) fixed.insert(fixed.end(), {5, 6, 7});
  return fixed;
}

/// One solve. Poses, points and the camera are changed in place. @return iterations
int Solve(Scene& scene, const std::vector<Observation>& observations, const BundleOptions& options) {
  Intrinsics camera = FromCamera(scene.views[0].camera);
  ceres::Problem problem;
  ceres::LossFunction* loss = new ceres::CauchyLoss(options.robust_px);
  auto* manifold = new ceres::EigenQuaternionManifold;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const Observation& o : observations) {
    View& view = scene.views[static_cast<std::size_t>(o.view)];
    double* point = scene.points[static_cast<std::size_t>(o.point)].position.data();
    problem.AddResidualBlock(new ReprojectionError(o.pixel), loss, camera.data(), view.camera_from_world.rotation.coeffs().data(),
                             view.camera_from_world.translation.data(), point);
    ordering->AddElementToGroup(point, 0);
  }
  ordering->AddElementToGroup(camera.data(), 1);
  bool first = true;
  for (View& view : scene.views) {
    double *rotation = view.camera_from_world.rotation.coeffs().data(), *translation = view.camera_from_world.translation.data();
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetManifold(rotation, manifold);
    ordering->AddElementToGroup(rotation, 1);
    ordering->AddElementToGroup(translation, 1);
    if (first) problem.SetParameterBlockConstant(rotation), problem.SetParameterBlockConstant(translation);  // the gauge, but for scale
    first = false;
  }
  if (const auto fixed = FixedIntrinsics(options); !fixed.empty()) problem.SetManifold(camera.data(), new ceres::SubsetManifold(8, fixed));
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_SCHUR;  // by Eigen on one thread; the sparse one would go through a threaded BLAS
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-6;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  if (!summary.IsSolutionUsable()) throw SolverError("sfm: bundle adjustment failed: " + summary.message);
  if (problem.NumResidualBlocks() == 0) return 0;
  for (View& view : scene.views) {
    view.camera_from_world.rotation.normalize();
    ToCamera(camera, view.camera);
  }
  return static_cast<int>(summary.iterations.size());
}

/// Observations within the limit, of points that keep at least two.
std::vector<Observation> Inliers(const Scene& scene, const std::vector<Observation>& observations, double max_error_px) {
  std::vector<Observation> kept;
  std::vector<int> count(scene.points.size(), 0);
  for (const Observation& o : observations)
    if (ErrorOf(scene, o) <= max_error_px) kept.push_back(o), ++count[static_cast<std::size_t>(o.point)];
  std::erase_if(kept, [&](const Observation& o) { return count[static_cast<std::size_t>(o.point)] < 2; });
  return kept;
}

/// Points that are still observed, with their views and mean errors.
void RebuildPoints(Scene& scene, const std::vector<Observation>& observations) {
  std::vector<int> count(scene.points.size(), 0);
  for (SparsePoint& point : scene.points) point.views.clear(), point.error_px = 0;
  for (const Observation& o : observations) {
    SparsePoint& point = scene.points[static_cast<std::size_t>(o.point)];
    point.views.push_back(o.view);
    point.error_px += ErrorOf(scene, o);
    ++count[static_cast<std::size_t>(o.point)];
  }
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    SparsePoint& point = scene.points[p];
    if (count[p] > 0) point.error_px /= count[p];
    std::sort(point.views.begin(), point.views.end());
    point.views.erase(std::unique(point.views.begin(), point.views.end()), point.views.end());
  }
  std::erase_if(scene.points, [](const SparsePoint& point) { return point.views.size() < 2; });
}

}  // namespace

BundleResult AdjustBundle(const Scene& scene, const std::vector<Observation>& observations, const BundleOptions& options,
                          Progress* progress) {
  RequireValid(scene, observations);
  BundleResult result;
  result.scene = scene;
  result.before_px = MeanError(scene, observations);
  std::vector<Observation> kept = Inliers(result.scene, observations, 8 * options.max_error_px);
  for (int round = 0; round < 2; ++round) {
    Step(progress, 0.5 * round, "bundle adjustment");
    result.iterations += Solve(result.scene, kept, options);
    kept = Inliers(result.scene, observations, options.max_error_px);
  }
  result.observations = static_cast<int>(kept.size());
  result.dropped = static_cast<int>(observations.size() - kept.size());
  result.after_px = MeanError(result.scene, kept);
  RebuildPoints(result.scene, kept);
  return result;
}

}  // namespace keypose::reconstruct
