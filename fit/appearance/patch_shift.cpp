#include "fit/appearance/patch_shift.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

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

constexpr int kMostSteps = 12;
constexpr double kSettled = 0.01;        // [px]
constexpr double kLeastVariance = 0.25;  // of brightness [grey levels^2]
constexpr double kDepthTolerance = 3;    // of a vertex, in footprints

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

/// Aligns one patch. Brightness may differ by a factor and by a plane (offset and slope), since the
/// light stays with the lamp while the figure turns: planes are projected out of all values.
class Aligner {
 public:
  Aligner(const std::vector<Pixel>& patch, const ImageF& photo, const PatchOptions& options)
      : patch_(patch), photo_(photo), options_(options) {
    PreparePlanes();
    const Eigen::Index n = SizeOf(patch_);
    render_.resize(n);
    values_.resize(n);
    gradients_.resize(n, 2);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Pixel& p = patch_[k];
      render_[k] = root_[k] * p.value;
      gradients_.row(k) = root_[k] * Eigen::RowVector2d(p.dx, p.dy);
    }
    render_ -= planes_ * (planes_.transpose() * render_);
    gradients_ -= planes_ * (planes_.transpose() * gradients_);
    hessian_ = gradients_.transpose() * gradients_;
    contrast_ = render_.squaredNorm();
  }

  PatchShift Run(double noise) {
    PatchShift result;
    const double damping = 1e-3 * hessian_.trace() + 1e-6;
    const Eigen::Matrix2d inverse = (hessian_ + damping * Eigen::Matrix2d::Identity()).inverse();
    for (int round = 0; round < kMostSteps; ++round) {
      Sample(result.shift);
      const Eigen::Vector2d step =
          inverse * (gradients_.transpose() * (render_ - Gain() * values_));
      result.shift += step;
      if (!(result.shift.norm() <= options_.reach_px)) return result;
      if (step.norm() < kSettled) break;
    }
    Sample(result.shift);
    result.correlation =
        render_.dot(values_) / std::sqrt(std::max(contrast_ * values_.squaredNorm(), 1e-12));
    if (!(result.correlation >= options_.least_correlation)) return result;
    result.found = true;
    result.confidence = Confidence(noise);
    return result;
  }

 private:
  /// An orthonormal basis of the planes over the patch, under the pixels' weights.
  void PreparePlanes() {
    const Eigen::Index n = SizeOf(patch_);
    root_.resize(n);
    planes_.resize(n, 3);
    for (Eigen::Index k = 0; k < n; ++k) {
      const Pixel& p = patch_[k];
      root_[k] = std::sqrt(p.weight);
      planes_.row(k) = root_[k] * Eigen::RowVector3d(1, p.x - patch_[0].x, p.y - patch_[0].y);
    }
    for (int c = 0; c < 3; ++c) {
      for (int d = 0; d < c; ++d)
        planes_.col(c) -= planes_.col(d).dot(planes_.col(c)) * planes_.col(d);
      planes_.col(c) /= std::max(planes_.col(c).norm(), 1e-12);
    }
  }

  void Sample(const Eigen::Vector2d& shift) {
    for (Eigen::Index k = 0; k < values_.size(); ++k) {
      const Pixel& p = patch_[k];
      values_[k] = root_[k] * SampleGrey(photo_, p.x + shift.x(), p.y + shift.y());
    }
    values_ -= planes_ * (planes_.transpose() * values_);
  }

  /// The factor that takes the photograph's contrast to the render's.
  double Gain() const {
    const double square = values_.squaredNorm();
    return square > 1e-9 ? render_.dot(values_) / square : 0;
  }

  Eigen::Matrix2d Confidence(double noise) const {
    const double gain = Gain();
    const double left = (render_ - gain * values_).squaredNorm() / root_.squaredNorm();
    const double variance = left + gain * gain * noise * noise + kLeastVariance;
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(hessian_ / variance);
    const double half = 1 / (PatchShiftTuning::kHalfConfident * PatchShiftTuning::kHalfConfident);
    Eigen::Vector2d sure = solver.eigenvalues().cwiseMax(0.0);
    sure = sure.array() / (sure.array() + half);
    return solver.eigenvectors() * sure.asDiagonal() * solver.eigenvectors().transpose();
  }

  const std::vector<Pixel>& patch_;
  const ImageF& photo_;
  const PatchOptions& options_;
  Eigen::VectorXd root_, render_, values_;
  Eigen::Matrix<double, Eigen::Dynamic, 3> planes_;
  Eigen::Matrix<double, Eigen::Dynamic, 2> gradients_;
  Eigen::Matrix2d hessian_;
  double contrast_ = 0;
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
    const std::vector<Pixel> patch = PatchOf(seen[i], render, mask, focal, options.radius);
    if (SizeOf(patch) < PatchShiftTuning::kLeastPixels * side * side) continue;
    shifts[i] = Aligner(patch, photo, options).Run(noise);
  }
  return shifts;
}

}  // namespace keypose::fit
