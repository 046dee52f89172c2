#include "reconstruct/bundle/bundle_adjustment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/bundle/bundle_projection.h"

namespace keypose::reconstruct {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct BundleTuning {
  /// of the largest error at the end: errors that enter the first solve
  KEYPOSE_TUNED(double, kFirstErrors, 8);
};

using Intrinsics = std::array<double, 8>;  // fx, fy over fx, cx cy k1 k2 p1 p2

/// Projects with the unknown focal length and aspect ratio.
Eigen::Vector2d ProjectWith(const double* in, const Eigen::Vector3d& x,
                            Eigen::Matrix<double, 2, 8>* of_intrinsics,
                            Eigen::Matrix<double, 2, 3>* of_point) {
  const double camera[8] = {in[0], in[0] * in[1], in[2], in[3], in[4], in[5], in[6], in[7]};
  const Eigen::Vector2d pixel = ProjectPoint(camera, x, of_intrinsics, of_point);
  if (of_intrinsics) {
    of_intrinsics->col(0) += in[1] * of_intrinsics->col(1);
    of_intrinsics->col(1) *= in[0];
  }
  return pixel;
}

/// Pixel error of one observation. The distortion is Brown's, as in core/values/camera.h. Analytic
/// derivatives: automatic ones of 18 unknowns cost more than the solve.
class ReprojectionError : public ceres::SizedCostFunction<2, 8, 4, 3, 3> {
 public:
  explicit ReprojectionError(const Eigen::Vector2d& pixel) : pixel_(pixel) {}

  bool Evaluate(const double* const* parameters, double* residual,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[1]);
    const Eigen::Map<const Eigen::Vector3d> t(parameters[2]), x(parameters[3]);
    Eigen::Matrix<double, 2, 8> of_camera;
    Eigen::Matrix<double, 2, 3> of_point;
    const Eigen::Vector3d in_camera = q * x + t;
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = ProjectWith(parameters[0], in_camera, jacobians ? &of_camera : nullptr,
                    jacobians ? &of_point : nullptr) -
        pixel_;
    if (!jacobians) return true;
    if (jacobians[0]) JacobianRows<8>(jacobians[0]) = of_camera;
    if (jacobians[1]) JacobianRows<4>(jacobians[1]) = of_point * RotatedByQuaternion(q, x);
    if (jacobians[2]) JacobianRows<3>(jacobians[2]) = of_point;
    if (jacobians[3]) JacobianRows<3>(jacobians[3]) = of_point * q.toRotationMatrix();
    return true;
  }

 private:
  Eigen::Vector2d pixel_;
};

/// Pixel error of a known point of a body with an unknown pose.
class BodyError : public ceres::SizedCostFunction<2, 8, 4, 3, 4, 3> {
 public:
  BodyError(const Eigen::Vector3d& on_body, const Eigen::Vector2d& pixel)
      : on_body_(on_body), pixel_(pixel) {}

  bool Evaluate(const double* const* parameters, double* residual,
                double** jacobians) const override {
    const Eigen::Map<const Eigen::Quaterniond> q(parameters[1]), body_q(parameters[3]);
    const Eigen::Map<const Eigen::Vector3d> t(parameters[2]), body_t(parameters[4]);
    Eigen::Matrix<double, 2, 8> of_camera;
    Eigen::Matrix<double, 2, 3> of_point;
    const Eigen::Vector3d in_world = body_q * on_body_ + body_t, in_camera = q * in_world + t;
    Eigen::Map<Eigen::Vector2d> r(residual);
    r = ProjectWith(parameters[0], in_camera, jacobians ? &of_camera : nullptr,
                    jacobians ? &of_point : nullptr) -
        pixel_;
    if (!jacobians) return true;
    const Eigen::Matrix<double, 2, 3> of_world = of_point * q.toRotationMatrix();
    if (jacobians[0]) JacobianRows<8>(jacobians[0]) = of_camera;
    if (jacobians[1]) JacobianRows<4>(jacobians[1]) = of_point * RotatedByQuaternion(q, in_world);
    if (jacobians[2]) JacobianRows<3>(jacobians[2]) = of_point;
    if (jacobians[3])
      JacobianRows<4>(jacobians[3]) = of_world * RotatedByQuaternion(body_q, on_body_);
    if (jacobians[4]) JacobianRows<3>(jacobians[4]) = of_world;
    return true;
  }

 private:
  Eigen::Vector3d on_body_;
  Eigen::Vector2d pixel_;
};

Intrinsics FromCamera(const Camera& c) {
  return {c.fx, c.fy / c.fx, c.cx, c.cy, c.k1, c.k2, c.p1, c.p2};
}

void ToCamera(const Intrinsics& in, Camera& c) {
  c.fx = in[0];
  c.fy = in[0] * in[1];
  c.cx = in[2];
  c.cy = in[3];
  c.k1 = in[4];
  c.k2 = in[5];
  c.p1 = in[6];
  c.p2 = in[7];
}

void RequireValid(const Scene& scene, const std::vector<Observation>& observations,
                  const Bodies& bodies) {
  for (const BodyObservation& o : bodies.observations)
    if (o.view < 0 || o.view >= std::ssize(scene.views) || o.body < 0 ||
        o.body >= std::ssize(bodies.world_from_body))
      throw InputError("bundle adjustment: an observation names view " + std::to_string(o.view) +
                       " and body " + std::to_string(o.body) + ", which the scene does not have");
  if (scene.views.size() < 2)
    throw InputError("bundle adjustment needs two views or more, got " +
                     std::to_string(scene.views.size()));
  for (const Observation& o : observations)
    if (o.view < 0 || o.view >= std::ssize(scene.views) || o.point < 0 ||
        o.point >= std::ssize(scene.points))
      throw InputError("bundle adjustment: an observation names view " + std::to_string(o.view) +
                       " and point " + std::to_string(o.point) + ", which the scene does not have");
}

double ErrorOf(const Scene& scene, const Observation& o) {
  const View& view = scene.views[o.view];
  const Eigen::Vector3d x = view.camera_from_world * scene.points[o.point].position;
  if (x.z() <= 0) return std::numeric_limits<double>::infinity();
  return (view.camera.Project(x) - o.pixel).norm();
}

double MeanError(const Scene& scene, const std::vector<Observation>& observations) {
  double sum = 0, count = 0;
  for (const Observation& o : observations)
    if (const double error = ErrorOf(scene, o); std::isfinite(error)) {
      sum += error;
      count += 1;
    }
  return count > 0 ? sum / count : 0;
}

std::vector<int> FixedIntrinsics(const BundleOptions& options) {
  std::vector<int> fixed;
  if (options.keep_aspect) fixed.push_back(1);
  if (!options.refine_principal_point) fixed.insert(fixed.end(), {2, 3});
  if (!options.refine_distortion) fixed.insert(fixed.end(), {5, 6, 7});
  return fixed;
}

/// The lenses of a scene: views with equal cameras share one.
struct Lenses {
  std::vector<Intrinsics> unknowns;
  std::vector<std::size_t> of_view;

  explicit Lenses(const Scene& scene) {
    std::vector<const Camera*> first;
    for (const View& view : scene.views) {
      const auto same = std::find_if(first.begin(), first.end(), [&](const Camera* c) {
        return c->width == view.camera.width && c->height == view.camera.height &&
               FromCamera(*c) == FromCamera(view.camera);
      });
      of_view.push_back(static_cast<std::size_t>(same - first.begin()));
      if (same != first.end()) continue;
      first.push_back(&view.camera);
      unknowns.push_back(FromCamera(view.camera));
    }
  }
  double* Of(int view) { return unknowns[of_view[static_cast<std::size_t>(view)]].data(); }
};

/// Adds residuals of known points; body 0 is fixed.
void AddBodies(ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering, Scene& scene,
               Bodies& bodies, Lenses& lenses, ceres::LossFunction* loss,
               ceres::Manifold* manifold) {
  for (const BodyObservation& o : bodies.observations) {
    View& view = scene.views[o.view];
    Rigid3& body = bodies.world_from_body[o.body];
    problem.AddResidualBlock(new BodyError(o.on_body, o.pixel), loss, lenses.Of(o.view),
                             view.camera_from_world.rotation.coeffs().data(),
                             view.camera_from_world.translation.data(),
                             body.rotation.coeffs().data(), body.translation.data());
  }
  for (std::size_t b = 0; b < bodies.world_from_body.size(); ++b) {
    double *rotation = bodies.world_from_body[b].rotation.coeffs().data(),
           *translation = bodies.world_from_body[b].translation.data();
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetManifold(rotation, manifold);
    ordering.AddElementToGroup(rotation, 2);
    ordering.AddElementToGroup(translation, 2);
    if (b == 0 || bodies.fixed) {
      problem.SetParameterBlockConstant(rotation);
      problem.SetParameterBlockConstant(translation);
    }
  }
}

double BodiesRms(const Scene& scene, const Bodies& bodies) {
  double sum = 0;
  for (const BodyObservation& o : bodies.observations) {
    const Rigid3& body = bodies.world_from_body[o.body];
    sum += (scene.views[o.view].Project(body * o.on_body) - o.pixel).squaredNorm();
  }
  return bodies.observations.empty()
             ? 0
             : std::sqrt(sum / static_cast<double>(bodies.observations.size()));
}

/// Parameters of the lenses and the poses. One group per array, because Ceres orders a group by
/// address, makes the sums independent of memory locations.
/// @param gauge_is_free  nothing else fixes the frame: the first pose stays
void AddCameras(ceres::Problem& problem, ceres::ParameterBlockOrdering& ordering, Scene& scene,
                Lenses& lenses, bool gauge_is_free, ceres::EigenQuaternionManifold* manifold) {
  for (Intrinsics& lens : lenses.unknowns)
    if (problem.HasParameterBlock(lens.data())) ordering.AddElementToGroup(lens.data(), 1);
  bool first = gauge_is_free;
  for (View& view : scene.views) {
    double *rotation = view.camera_from_world.rotation.coeffs().data(),
           *translation = view.camera_from_world.translation.data();
    if (!problem.HasParameterBlock(rotation)) continue;
    problem.SetManifold(rotation, manifold);
    ordering.AddElementToGroup(rotation, 3);
    ordering.AddElementToGroup(translation, 3);
    if (first) {
      problem.SetParameterBlockConstant(rotation);
      problem.SetParameterBlockConstant(translation);
    }  // the gauge, except for scale
    first = false;
  }
}

ceres::Solver::Options SolverFor(const BundleOptions& options,
                                 const std::shared_ptr<ceres::ParameterBlockOrdering>& ordering) {
  ceres::Solver::Options solver;
  // Eigen on one thread; the sparse solver would use a threaded BLAS
  solver.linear_solver_type = ceres::DENSE_SCHUR;
  solver.linear_solver_ordering = ordering;
  solver.max_num_iterations = options.max_iterations;
  solver.function_tolerance = 1e-6;
  // a larger radius gains nothing, and rounding would make the reduced system indefinite
  solver.max_trust_region_radius = 1e8;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  return solver;
}

/// One solve. Poses, points and the camera are changed in place.
/// @return number of iterations
int Solve(Scene& scene, Bodies& bodies, const std::vector<Observation>& observations,
          const BundleOptions& options) {
  Lenses lenses(scene);
  ceres::Problem problem;
  ceres::LossFunction* loss = new ceres::CauchyLoss(options.robust_px);
  auto* manifold = new ceres::EigenQuaternionManifold;
  auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
  for (const Observation& o : observations) {
    View& view = scene.views[o.view];
    double* point = scene.points[o.point].position.data();
    problem.AddResidualBlock(new ReprojectionError(o.pixel), loss, lenses.Of(o.view),
                             view.camera_from_world.rotation.coeffs().data(),
                             view.camera_from_world.translation.data(), point);
    ordering->AddElementToGroup(point, 0);
  }
  AddBodies(problem, *ordering, scene, bodies, lenses, loss, manifold);
  AddCameras(problem, *ordering, scene, lenses, bodies.observations.empty(), manifold);
  if (const auto fixed = FixedIntrinsics(options); !fixed.empty())
    for (Intrinsics& lens : lenses.unknowns)
      if (problem.HasParameterBlock(lens.data()))
        problem.SetManifold(lens.data(), new ceres::SubsetManifold(8, fixed));
  ceres::Solver::Summary summary;
  ceres::Solve(SolverFor(options, ordering), &problem, &summary);
  if (!summary.IsSolutionUsable())
    throw SolverError("sfm: bundle adjustment failed: " + summary.message);
  if (problem.NumResidualBlocks() == 0) return 0;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    View& view = scene.views[v];
    view.camera_from_world.rotation.normalize();
    ToCamera(lenses.unknowns[lenses.of_view[v]], view.camera);
  }
  for (Rigid3& body : bodies.world_from_body) body.rotation.normalize();
  return SizeOf(summary.iterations);
}

/// Observations within the limit, of points that keep at least two.
std::vector<Observation> Inliers(const Scene& scene, const std::vector<Observation>& observations,
                                 double max_error_px) {
  std::vector<Observation> kept;
  std::vector<int> count(scene.points.size(), 0);
  for (const Observation& o : observations)
    if (ErrorOf(scene, o) <= max_error_px) {
      kept.push_back(o);
      ++count[o.point];
    }
  std::erase_if(kept, [&](const Observation& o) { return count[o.point] < 2; });
  return kept;
}

/// Keeps the points that are still observed and updates their views and mean errors; the
/// observations get the new indices.
void RebuildPoints(Scene& scene, std::vector<Observation>& observations) {
  std::vector<int> count(scene.points.size(), 0);
  for (SparsePoint& point : scene.points) {
    point.views.clear();
    point.error_px = 0;
  }
  for (const Observation& o : observations) {
    SparsePoint& point = scene.points[o.point];
    point.views.push_back(o.view);
    point.error_px += ErrorOf(scene, o);
    ++count[o.point];
  }
  for (std::size_t p = 0; p < scene.points.size(); ++p) {
    SparsePoint& point = scene.points[p];
    if (count[p] > 0) point.error_px /= count[p];
    std::sort(point.views.begin(), point.views.end());
    point.views.erase(std::unique(point.views.begin(), point.views.end()), point.views.end());
  }
  std::vector<int> index(scene.points.size(), -1);
  int next = 0;
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    if (scene.points[p].views.size() >= 2) index[p] = next++;
  std::erase_if(scene.points, [](const SparsePoint& point) { return point.views.size() < 2; });
  std::erase_if(observations, [&](const Observation& o) { return index[o.point] < 0; });
  for (Observation& o : observations) o.point = index[o.point];
}

}  // namespace

BundleResult AdjustBundle(const Scene& scene, const std::vector<Observation>& observations,
                          const BundleOptions& options, Progress* progress, const Bodies& bodies) {
  RequireValid(scene, observations, bodies);
  BundleResult result;
  result.scene = scene;
  result.bodies = bodies;
  result.before_px = MeanError(scene, observations);
  std::vector<Observation> kept =
      Inliers(result.scene, observations, BundleTuning::kFirstErrors * options.max_error_px);
  for (int round = 0; round < 2; ++round) {
    ReportProgress(progress, 0.5 * round, "bundle adjustment");
    result.iterations += Solve(result.scene, result.bodies, kept, options);
    kept = Inliers(result.scene, observations, options.max_error_px);
  }
  result.observations = SizeOf(kept);
  result.dropped = static_cast<int>(observations.size() - kept.size());
  result.after_px = MeanError(result.scene, kept);
  for (const Observation& o : observations)
    if (const double error = ErrorOf(result.scene, o) / options.robust_px; std::isfinite(error))
      result.chi2 += options.robust_px * options.robust_px * std::log1p(error * error);
  result.bodies_rms_px = BodiesRms(result.scene, result.bodies);
  RebuildPoints(result.scene, kept);
  result.kept = std::move(kept);
  return result;
}

}  // namespace keypose::reconstruct
