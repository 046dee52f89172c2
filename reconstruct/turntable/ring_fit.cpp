#include "reconstruct/turntable/ring_fit.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct RingFitTuning {
  /// degrees: standard deviation of a view's angle from even steps, which nothing tells here
  KEYPOSE_TUNED(double, kAnglePrior_deg, 10);
};

/// Rotation nearest to the mean of some.
Eigen::Quaterniond MeanRotation(const std::vector<Eigen::Quaterniond>& rotations) {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  for (const Eigen::Quaterniond& q : rotations)
    sum += q.coeffs() * (q.dot(rotations[0]) < 0 ? -1 : 1);
  Eigen::Quaterniond mean;
  mean.coeffs() = sum.normalized();
  return mean;
}

/// Azimuth of the camera's centre about the axis.
double AngleOf(const View& view) {
  const Vector3d c = view.Center();
  return std::atan2(c.y(), c.x());
}

int UnknownsOf(const Scene& scene, int points, bool ring, const RingModel* model) {
  const int cameras = ring ? static_cast<int>(6 * model->rings.size() + model->views.size()) - 2 -
                                 SizeOf(model->rings)
                           : static_cast<int>(6 * scene.views.size()) - 7;
  return cameras + 3 * points;
}

/// Sum of Cauchy losses at the solution, over the same observations for both models.
double ChiSquared(const Scene& scene, const std::vector<Observation>& observations,
                  double robust_px) {
  double sum = 0;
  for (const Observation& o : observations) {
    const double error =
        (scene.views[o.view].Project(scene.points[o.point].position) - o.pixel).norm() / robust_px;
    sum += robust_px * robust_px * std::log1p(error * error);
  }
  return sum;
}

/// A ring has one camera on a tripod; photographs of several sizes are of several.
bool HasOneSize(const Scene& scene) {
  const Camera& first = scene.views.front().camera;
  return std::all_of(scene.views.begin(), scene.views.end(), [&](const View& view) {
    return view.camera.width == first.width && view.camera.height == first.height;
  });
}

}  // namespace

RingModel NearestRingModel(const Scene& scene, const Leveling& leveling) {
  const Scene level = Transformed(leveling.level_from_model, scene);
  std::map<int, std::vector<int>> members;
  int next = leveling.rings;
  for (std::size_t v = 0; v < level.views.size(); ++v) {
    const int ring = leveling.ring_of_view[v];
    members[ring < 0 ? next++ : ring].push_back(static_cast<int>(v));
  }
  RingModel model;
  model.camera = scene.views[0].camera;
  // With a single ring, free cameras do not determine the pixels' aspect ratio, and their value
  // would be kept: pixels are square.
  model.camera.fx = model.camera.fy = 0.5 * (model.camera.fx + model.camera.fy);
  model.views.resize(level.views.size());
  for (const auto& [name, views] : members) {
    std::vector<Eigen::Quaterniond> rotations;
    Vector3d translation = Vector3d::Zero();
    const auto ring = SizeOf(model.rings);
    const double step = 2 * kPi / static_cast<double>(std::max<std::size_t>(views.size(), 3));
    for (const int v : views) {
      const View& view = level.views[v];
      // A camera at azimuth a equals the ring's own with the table rotated back by a.
      const double angle = -AngleOf(view);
      model.views[v] = {v, ring, angle / step, angle};
      rotations.push_back(view.camera_from_world.rotation *
                          Eigen::Quaterniond(RotationAboutZ(-angle)));
      translation += view.camera_from_world.translation / static_cast<double>(views.size());
    }
    model.rings.push_back({MeanRotation(rotations), translation});
    model.step_rad.push_back(step);
  }
  return model;
}

RingFit AdjustOnRings(const Scene& scene, const std::vector<Observation>& observations,
                      const RingFitOptions& options, Progress* progress) {
  RingFit fit;
  fit.result = AdjustBundle(scene, observations, options.bundle, progress);
  if (scene.views.size() < 5 || fit.result.scene.points.size() < 10 || !HasOneSize(scene))
    return fit;
  const Leveling leveling = LevelScene(fit.result.scene);
  if (leveling.rings < 1 || !leveling.centered_on_axis ||
      leveling.plane_rms > options.most_off_axis || leveling.circle_rms > options.most_off_axis)
    return fit;
  fit.tried = true;
  const RingModel start = NearestRingModel(fit.result.scene, leveling);
  // The given points: the adjustment has renumbered its own.
  std::vector<SparsePoint> points = Transformed(leveling.level_from_model, scene).points;
  RingBundleOptions ring_options = options.ring;
  ring_options.angle_prior_deg = RingFitTuning::kAnglePrior_deg;
  ring_options.robust_px = options.bundle.robust_px;
  ring_options.max_error_px = options.bundle.max_error_px;
  const RingBundleResult ring = AdjustRingBundle(start, points, observations, ring_options);
  fit.ring_px = ring.mean_error_px;
  std::vector<std::string> names;
  for (const View& view : scene.views) names.push_back(view.name);
  const Scene on_rings = SceneOf(ring.model, names, ring.points);
  // Both are compared on the observations that the ring keeps, after an adjustment of free cameras
  // to exactly these.
  BundleOptions free_options = options.bundle;
  free_options.max_error_px = 1e3;
  const BundleResult free = AdjustBundle(on_rings, ring.observations, free_options, progress);
  const double chi_ring = ChiSquared(on_rings, ring.observations, options.bundle.robust_px);
  const auto count = 2.0 * static_cast<double>(ring.observations.size());
  const double ring_freedom =
                   count - UnknownsOf(scene, SizeOf(free.scene.points), true, &ring.model),
               free_freedom = count - UnknownsOf(scene, SizeOf(free.scene.points), false, nullptr);
  if (ring_freedom <= 0 || free_freedom <= 0 || chi_ring <= 0) return fit;
  fit.chi2_ratio = free.chi2 / free_freedom / (chi_ring / ring_freedom);
  fit.is_ring = fit.chi2_ratio >= options.release_share;
  if (!fit.is_ring) return fit;
  BundleOptions as_it_is = options.bundle;
  as_it_is.max_iterations = 0;
  fit.result = AdjustBundle(Transformed(leveling.level_from_model.Inverse(), on_rings),
                            observations, as_it_is, progress);
  return fit;
}

}  // namespace keypose::reconstruct
