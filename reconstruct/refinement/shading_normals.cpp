#include "reconstruct/refinement/shading_normals.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

using Basis = Eigen::Matrix<double, 9, 1>;
using Eigen::Vector3d;

constexpr int kShadingGrain = 256;
constexpr int kFits = 3;   // alternating fits of light and albedo
constexpr int kTurns = 4;  // Gauss-Newton steps of a normal
constexpr int kLeastViews = 5;

// No record of the data; the results are on the synthetic rings (docs/results/rings.md).
// Sensitivity: docs/results/sensitivity.md.
struct ShadingTuning {
  KEYPOSE_TUNED(double, kRelativeError, 0.03);  // typical error, as a share of the brightness
  KEYPOSE_TUNED(double, kPrior, 0.25);          // rad; larger rotations of normals are unlikely
};

Basis Harmonics(const Vector3d& n) {
  Basis b;
  b << 1, n.x(), n.y(), n.z(), n.x() * n.y(), n.x() * n.z(), n.y() * n.z(),
      n.x() * n.x() - n.y() * n.y(), 3 * n.z() * n.z() - 1;
  return b;
}

// Gradient of light * Harmonics(n).
Vector3d Slope(const Basis& l, const Vector3d& n) {
  return {l[1] + l[4] * n.y() + l[5] * n.z() + 2 * l[7] * n.x(),
          l[2] + l[4] * n.x() + l[6] * n.z() - 2 * l[7] * n.y(),
          l[3] + l[5] * n.x() + l[6] * n.y() + 6 * l[8] * n.z()};
}

// Mean linear brightness of 3 x 3 pixels; vertices are several pixels apart.
float Brightness(const Image8& color, double x, double y) {
  const int ix = static_cast<int>(x + 0.5), iy = static_cast<int>(y + 0.5);
  if (ix < 1 || iy < 1 || ix >= color.width - 1 || iy >= color.height - 1) return 0;
  float sum = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const std::uint8_t* p = color.at(ix + dx, iy + dy);
      sum += 0.2126f * LinearOf(p[0]) + 0.7152f * LinearOf(p[1]) + 0.0722f * LinearOf(p[2]);
    }
  return sum / 9;
}

double Robust(double error) { return 1 / (1 + error * error); }

class Shading {
 public:
  Shading(const Mesh& mesh, const PointsX3& normals, const std::vector<PreparedView>& views,
          const std::vector<std::vector<float>>& sights)
      : normals_(normals),
        brightness_(views.size()),
        light_(views.size(), Basis::Zero()),
        own_(mesh.vertex_count(), 1.0f) {
    ParallelFor(std::ssize(views), [&](std::int64_t i) {
      brightness_[i].assign(mesh.vertex_count(), 0.0f);
      const PreparedView& view = views[i];
      for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (sights[i][v] <= 0) continue;
        const Eigen::Vector2d p =
            view.camera().Project(view.camera_from_world * Vector3d(mesh.points.row(v)));
        brightness_[i][v] = Brightness(view.color, p.x(), p.y());
      }
    });
    for (int fit = 0; fit < kFits; ++fit) {
      ParallelFor(std::ssize(views),
                  [&](std::int64_t i) { FitLight(static_cast<int>(i), fit > 0); });
      ParallelFor(
          mesh.vertex_count(),
          [&](std::int64_t v) { own_[v] = static_cast<float>(Own(v, normals_.row(v))); },
          kShadingGrain);
    }
  }

  // Rotates the normal of v; also gives its weight, and relative errors before and after.
  void Solve(std::int64_t v, Vector3d* normal, float* weight, float* before, float* after) const {
    const Vector3d start = normals_.row(v), first = start.unitOrthogonal(),
                   second = start.cross(first);
    Eigen::Vector2d turn = Eigen::Vector2d::Zero();
    double own = own_[v];
    *weight = 0;
    *before = *after = Error(v, start, own);
    *normal = start;
    if (own <= 0) return;
    Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
    for (int step = 0; step < kTurns; ++step) {
      const Vector3d n = (start + turn.x() * first + turn.y() * second).normalized();
      Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
      Vector3d b = Vector3d::Zero();
      int count = 0;
      for (std::size_t i = 0; i < light_.size(); ++i) {
        const double seen = brightness_[i][v];
        if (seen <= 0) continue;
        const double light = light_[i].dot(Harmonics(n));
        const Vector3d slope = Slope(light_[i], n);
        const double sigma = ShadingTuning::kRelativeError * own * std::max(0.1, light_[i][0]),
                     error = (seen - own * light) / sigma;
        const Vector3d row =
            Vector3d(own * slope.dot(first), own * slope.dot(second), light) / sigma;
        const double w = Robust(error / 2);
        a += w * row * row.transpose();
        b += w * error * row;
        ++count;
      }
      if (count < kLeastViews) return;
      information = a.topLeftCorner<2, 2>() - a.topRightCorner<2, 1>() *
                                                  a.bottomLeftCorner<1, 2>() /
                                                  std::max(a(2, 2), 1e-12);
      a(0, 0) += 1 / (ShadingTuning::kPrior * ShadingTuning::kPrior);
      a(1, 1) += 1 / (ShadingTuning::kPrior * ShadingTuning::kPrior);
      b.head<2>() -= turn / (ShadingTuning::kPrior * ShadingTuning::kPrior);
      const Vector3d change = a.ldlt().solve(b);
      if (!change.allFinite()) return;
      turn += change.head<2>();
      if (turn.norm() > 2 * ShadingTuning::kPrior) turn *= 2 * ShadingTuning::kPrior / turn.norm();
      own = std::max(own + change.z(), 1e-6);
    }
    *normal = (start + turn.x() * first + turn.y() * second).normalized();
    *after = Error(v, *normal, own);
    const double least =
        Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(information).eigenvalues().x();
    *weight = static_cast<float>(
        std::max(0.0, least) /
        (std::max(0.0, least) + 20 / (ShadingTuning::kPrior * ShadingTuning::kPrior)));
  }

 private:
  // Robust mean over the views of a vertex's albedo, about the median.
  double Own(std::int64_t v, const Vector3d& normal) const {
    std::vector<double> values;
    for (std::size_t i = 0; i < light_.size(); ++i) {
      const double light = light_[i].dot(Harmonics(normal));
      if (brightness_[i][v] > 0 && light > 0.15 * light_[i][0])
        values.push_back(brightness_[i][v] / light);
    }
    if (values.empty()) return 0;
    const double median = UpperMedianInPlace(values);
    double sum = 0, weights = 0;
    for (const double value : values) {
      const double w = Robust((value / median - 1) / 0.1);
      sum += w * value;
      weights += w;
    }
    return sum / weights;
  }

  void FitLight(int view, bool known) {
    for (int round = 0; round < (known ? 2 : 4); ++round) {
      Eigen::Matrix<double, 9, 9> a = Eigen::Matrix<double, 9, 9>::Identity() * 1e-3;
      Basis b = Basis::Zero();
      for (std::size_t v = 0; v < own_.size(); ++v) {
        const double seen = brightness_[view][v];
        if (seen <= 0 || own_[v] <= 0) continue;
        const Basis h = own_[v] * Harmonics(normals_.row(v));
        const double w =
            known || round > 0
                ? Robust((seen - light_[view].dot(h)) /
                         ((known ? 0.1 : 0.3) * own_[v] * std::max(light_[view][0], 1e-3)))
                : 1;
        const double size = w / (own_[v] * own_[v]);  // errors are relative
        a += size * h * h.transpose();
        b += size * seen * h;
      }
      light_[view] = a.ldlt().solve(b);
    }
  }

  // Median of the relative errors.
  float Error(std::int64_t v, const Vector3d& normal, double own) const {
    std::vector<float> errors;
    for (std::size_t i = 0; i < light_.size(); ++i)
      if (brightness_[i][v] > 0)
        errors.push_back(static_cast<float>(
            std::abs(brightness_[i][v] - own * light_[i].dot(Harmonics(normal))) /
            brightness_[i][v]));
    if (errors.empty()) return -1;
    return UpperMedian(std::move(errors));
  }

  const PointsX3& normals_;
  // for each view, for each vertex; 0 where it is not seen
  std::vector<std::vector<float>> brightness_;
  std::vector<Basis> light_;
  std::vector<float> own_;
};

double MedianOfKnown(std::vector<float> values) {
  std::erase_if(values, [](float v) { return v < 0; });
  return UpperMedian(std::move(values));
}

}  // namespace

ShadingNormals NormalsFromShading(const Mesh& mesh, const PointsX3& normals,
                                  const Neighbors& neighbors,
                                  const std::vector<PreparedView>& views,
                                  const std::vector<std::vector<float>>& sights, int smooth) {
  const Shading shading(mesh, normals, views, sights);
  const int count = mesh.vertex_count();
  ShadingNormals out{normals, std::vector<float>(count, 0.0f), 0, 0};
  std::vector<float> before(count), after(count), turns(3 * static_cast<std::size_t>(count));
  ParallelFor(
      count,
      [&](std::int64_t v) {
        Vector3d normal;
        shading.Solve(v, &normal, &out.weight[v], &before[v], &after[v]);
        for (int c = 0; c < 3; ++c)
          turns[3 * v + c] = static_cast<float>(normal[c] - normals(v, c));
      },
      kShadingGrain);
  out.residual_before = MedianOfKnown(std::move(before));
  out.residual_after = MedianOfKnown(std::move(after));
  std::vector<char> known(count);
  for (int v = 0; v < count; ++v) known[v] = out.weight[v] > 0;
  std::vector<float> slow = turns;
  Diffuse(neighbors, 3, smooth, known, &slow);
  for (int v = 0; v < count; ++v) {
    for (int c = 0; c < 3; ++c) out.normals(v, c) += turns[3 * v + c] - slow[3 * v + c];
    out.normals.row(v).normalize();
  }
  return out;
}

}  // namespace keypose::reconstruct
