#include "fit/appearance/patch_shift.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct PatchShiftTuning {
  // A patch's pixels lie within this depth of its middle, in sides of the patch.
  KEYPOSE_TUNED(double, kDepth, 1.5);
  // Standard deviation of a shift at which its confidence is one half [px].
  KEYPOSE_TUNED(double, kHalfConfident, 0.15);
  KEYPOSE_TUNED(double, kLeastPixels, 0.4);  // share of a patch that must be usable
};

constexpr int kRounds = 12;
constexpr double kSettled = 0.01;     // [px]
constexpr double kDepthTolerance = 3; // of a vertex, in footprints

struct Pixel {
  int x, y;
  float value, dx, dy, weight;
};

/// The usable pixels of a patch of the render, with gradients.
std::vector<Pixel> PatchOf(const SeenVertex& seen, const TexturedRender& render,
                           const GreyMask& mask, double focal, int radius) {
  std::vector<Pixel> patch;
  const int cx = static_cast<int>(std::lround(seen.pixel.x())),
            cy = static_cast<int>(std::lround(seen.pixel.y()));
  const float near = static_cast<float>(PatchShiftTuning::kDepth * 2 * radius * seen.depth / focal);
  const auto usable = [&](int x, int y) {
    return std::abs(*render.depth.at(x, y) - static_cast<float>(seen.depth)) <= near;
  };
  for (int y = std::max(1, cy - radius); y <= std::min(render.grey.height - 2, cy + radius); ++y)
    for (int x = std::max(1, cx - radius); x <= std::min(render.grey.width - 2, cx + radius); ++x) {
      if (!usable(x, y) || !usable(x - 1, y) || !usable(x + 1, y) || !usable(x, y - 1) ||
          !usable(x, y + 1) || !InMask(*mask.at(x, y)))
        continue;
      const double r2 = ((x - seen.pixel.x()) * (x - seen.pixel.x()) +
                         (y - seen.pixel.y()) * (y - seen.pixel.y())) /
                        (radius * radius);
      const float *above = render.grey.at(x, y - 1), *below = render.grey.at(x, y + 1),
                  *here = render.grey.at(x, y);
      patch.push_back({x, y, here[0], (here[1] - here[-1]) / 2, (below[0] - above[0]) / 2,
                       static_cast<float>(std::exp(-r2))});
    }
  return patch;
}

/// Weighted moments of a patch's values and those of the photograph under a shift.
struct Moments {
  double weight = 0, mean_t = 0, mean_i = 0, var_t = 0, var_i = 0, cov = 0;
};

class Aligner {
 public:
  Aligner(std::vector<Pixel> patch, const ImageF& photo, const PatchOptions& options)
      : patch_(std::move(patch)), photo_(photo), options_(options), values_(patch_.size()) {
    PrepareTemplate();
  }

  PatchShift Run(double noise) {
    PatchShift result;
    const Eigen::Matrix2d inverse = InverseOf(hessian_);
    for (int round = 0; round < kRounds; ++round) {
      const Eigen::Vector2d step = inverse * Gradient(result.shift);
      result.shift += step;
      if (!(result.shift.norm() <= options_.reach_px)) return result;
      if (step.norm() < kSettled) break;
    }
    const Moments m = Measure(result.shift);
    result.correlation = m.cov / std::sqrt(std::max(m.var_t * m.var_i, 1e-12));
    if (!(result.correlation >= options_.least_correlation)) return result;
    result.found = true;
    result.confidence = Confidence(m, noise);
    return result;
  }

 private:
  void PrepareTemplate() {
    double weight = 0;
    Eigen::Vector2d mean_gradient = Eigen::Vector2d::Zero();
    for (const Pixel& p : patch_) {
      weight += p.weight;
      mean_gradient += p.weight * Eigen::Vector2d(p.dx, p.dy);
    }
    mean_gradient /= std::max(weight, 1e-9);
    // The offset of brightness is eliminated: gradients without their mean.
    for (const Pixel& p : patch_) {
      const Eigen::Vector2d g = Eigen::Vector2d(p.dx, p.dy) - mean_gradient;
      hessian_ += p.weight * g * g.transpose();
    }
  }

  static Eigen::Matrix2d InverseOf(const Eigen::Matrix2d& h) {
    const double damping = 1e-3 * h.trace() + 1e-6;
    return (h + damping * Eigen::Matrix2d::Identity()).inverse();
  }

  Moments Measure(const Eigen::Vector2d& shift) {
    Moments m;
    for (int k = 0; k < SizeOf(patch_); ++k) {
      const Pixel& p = patch_[k];
      values_[k] = SampleGrey(photo_, p.x + shift.x(), p.y + shift.y());
      m.weight += p.weight;
      m.mean_t += p.weight * p.value;
      m.mean_i += p.weight * values_[k];
    }
    m.mean_t /= m.weight, m.mean_i /= m.weight;
    for (int k = 0; k < SizeOf(patch_); ++k) {
      const Pixel& p = patch_[k];
      const double t = p.value - m.mean_t, i = values_[k] - m.mean_i;
      m.var_t += p.weight * t * t, m.var_i += p.weight * i * i, m.cov += p.weight * t * i;
    }
    return m;
  }

  /// The right-hand side: gradients times what the photograph lacks, in the render's contrast.
  Eigen::Vector2d Gradient(const Eigen::Vector2d& shift) {
    const Moments m = Measure(shift);
    const double gain = m.var_i > 1e-9 ? m.cov / m.var_i : 0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (int k = 0; k < SizeOf(patch_); ++k) {
      const Pixel& p = patch_[k];
      const double lack = p.value - m.mean_t - gain * (values_[k] - m.mean_i);
      sum += p.weight * lack * Eigen::Vector2d(p.dx, p.dy);
    }
    return sum;
  }

  Eigen::Matrix2d Confidence(const Moments& m, double noise) const {
    const double gain = m.var_i > 1e-9 ? m.cov / m.var_i : 0;
    const double left = std::max(0.0, m.var_t - gain * m.cov) / m.weight;
    const double variance = left + gain * gain * noise * noise + 0.25;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(hessian_ / variance);
    const double half = 1 / (PatchShiftTuning::kHalfConfident * PatchShiftTuning::kHalfConfident);
    Eigen::Vector2d sure = solver.eigenvalues().cwiseMax(0.0);
    sure = sure.array() / (sure.array() + half);
    return solver.eigenvectors() * sure.asDiagonal() * solver.eigenvectors().transpose();
  }

  std::vector<Pixel> patch_;
  const ImageF& photo_;
  const PatchOptions& options_;
  std::vector<float> values_;
  Eigen::Matrix2d hessian_ = Eigen::Matrix2d::Zero();
};

}  // namespace

std::vector<SeenVertex> SeenVertices(const PointsX3& points, const PointsX3& normals,
                                     const TexturedRender& render, const Pinhole& camera,
                                     const Rigid3& camera_from_world, double least_facing) {
  std::vector<SeenVertex> seen;
  const Eigen::Vector3d eye = camera_from_world.Inverse().translation;
  for (int v = 0; v < points.rows(); ++v) {
    const Eigen::Vector3d p = points.row(v), x = camera_from_world * p;
    if (x.z() <= 0) continue;
    const double facing = normals.row(v).dot((eye - p).normalized());
    if (facing < least_facing) continue;
    const Eigen::Vector2d pixel = camera.Project(x);
    const int px = static_cast<int>(std::lround(pixel.x())),
              py = static_cast<int>(std::lround(pixel.y()));
    if (px < 0 || py < 0 || px >= camera.width || py >= camera.height) continue;
    const double tolerance = kDepthTolerance * x.z() / camera.fx / std::max(facing, 0.2);
    if (std::abs(*render.depth.at(px, py) - x.z()) > tolerance) continue;
    seen.push_back({v, pixel, x.z(), facing});
  }
  return seen;
}

std::vector<PatchShift> FindShifts(const std::vector<SeenVertex>& seen,
                                   const TexturedRender& render, const ImageF& photo,
                                   const GreyMask& mask, double focal, double noise,
                                   const PatchOptions& options) {
  std::vector<PatchShift> shifts(seen.size());
  const double side = 2 * options.radius + 1;
  for (int i = 0; i < SizeOf(seen); ++i) {
    std::vector<Pixel> patch = PatchOf(seen[i], render, mask, focal, options.radius);
    if (SizeOf(patch) < PatchShiftTuning::kLeastPixels * side * side) continue;
    shifts[i] = Aligner(std::move(patch), photo, options).Run(noise);
  }
  return shifts;
}

}  // namespace keypose::fit
