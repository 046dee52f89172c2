#include "composite/light/shot_light.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "composite/layer/linear_light.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

constexpr double kLeastFacing = 0.25;  // cosine: flatter places say little
constexpr float kBurnt = 0.97f;        // linear light
constexpr double kLeastGain = 0.05, kMostGain = 8;
constexpr double kInside = 0.98;  // coverage of the neighbourhood: away from the outline
constexpr int kRounds = 12;       // of reweighting
constexpr double kRidge = 2e-3;   // keeps directions that no frame shows near the mean
constexpr int kSweeps = 80;       // spread what is seen to what is not
constexpr double kPull = 0.02;    // towards 1, where nothing is seen
constexpr double kSpread = 0.35;  // weight of a neighbour against an observation
constexpr double kUnseen = 0.1;   // trust in what was spread

/// Colour over coverage of a premultiplied neighbourhood.
struct Compared {
  ImageF filmed, layer;  // RGBA, blurred; alpha is the weight
};

Compared Compare(const ImageF& filmed, const ImageF& layer, const Image8& held_out,
                 double blur_px) {
  Compared both{ImageF(layer.width, layer.height, 4), ImageF(layer.width, layer.height, 4)};
  for (int y = 0; y < layer.height; ++y)
    for (int x = 0; x < layer.width; ++x) {
      const float* light = filmed.at(x, y);
      const bool counts = layer.at(x, y)[3] >= 0.999f &&
                          std::max({light[0], light[1], light[2]}) < kBurnt &&
                          (held_out.empty() || *held_out.at(x, y) == 0);
      if (!counts) continue;
      for (int c = 0; c < 3; ++c) {
        both.filmed.at(x, y)[c] = light[c];
        both.layer.at(x, y)[c] = layer.at(x, y)[c];
      }
      both.filmed.at(x, y)[3] = both.layer.at(x, y)[3] = 1;
    }
  both.filmed = Blurred(both.filmed, blur_px);
  both.layer = Blurred(both.layer, blur_px);
  return both;
}

bool SolveChannel(const std::vector<ObservedGains>& frames, int channel,
                  Eigen::Matrix<double, 9, 1>* solution) {
  double scale2 = 1;
  Eigen::Matrix<double, 9, 1> x = Eigen::Matrix<double, 9, 1>::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix<double, 9, 9> normal = Eigen::Matrix<double, 9, 9>::Zero();
    Eigen::Matrix<double, 9, 1> right = Eigen::Matrix<double, 9, 1>::Zero();
    double total = 0, error = 0;
    for (const ObservedGains& frame : frames)
      for (Eigen::Index v = 0; v < frame.weights.size(); ++v) {
        if (frame.weights[v] <= 0) continue;
        const Harmonics h = HarmonicsOf(frame.normals.row(v));
        const double residual = round ? h.dot(x) - frame.gains(v, channel) : 0;
        const double robust = std::pow(scale2 / (scale2 + residual * residual), 2);
        const double w = frame.weights[v] * robust;
        normal.noalias() += w * h * h.transpose();
        right += w * frame.gains(v, channel) * h;
        total += frame.weights[v];
        error += frame.weights[v] * std::min(residual * residual, 1.0);
      }
    if (total <= 0) return false;
    for (int k = 1; k < 9; ++k) normal(k, k) += kRidge * total;
    x = normal.ldlt().solve(right);
    if (round > 0) scale2 = std::max(1e-4, 2 * error / total);
  }
  *solution = x;
  return true;
}

double HarmonicLight(const ShotLight& light, const Harmonics& h, int channel) {
  return std::clamp(h.dot(light.harmonics.col(channel)), kLeastGain, kMostGain);
}

/// The observed rest where it was seen, smoothed, and spread along the surface to where it was not.
PointsX3 SpreadRest(const PointsX3& rest, const Eigen::VectorXd& weights,
                    const std::vector<std::pair<int, int>>& edges) {
  PointsX3 now = PointsX3::Ones(rest.rows(), 3);
  for (Eigen::Index v = 0; v < rest.rows(); ++v)
    if (weights[v] > 0) now.row(v) = rest.row(v);
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    PointsX3 sum = PointsX3::Constant(rest.rows(), 3, kPull);
    Eigen::VectorXd total = Eigen::VectorXd::Constant(rest.rows(), kPull);
    for (const auto& [a, b] : edges) {
      sum.row(a) += kSpread * now.row(b);
      sum.row(b) += kSpread * now.row(a);
      total[a] += kSpread;
      total[b] += kSpread;
    }
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      if (weights[v] > 0) {
        sum.row(v) += weights[v] * rest.row(v);
        total[v] += weights[v];
      }
      now.row(v) = sum.row(v) / total[v];
    }
  }
  return now;
}

}  // namespace

Harmonics HarmonicsOf(const Vector3d& n) {
  Harmonics h;
  h << 1, n.x(), n.y(), n.z(), n.x() * n.y(), n.y() * n.z(), n.x() * n.z(),
      n.x() * n.x() - n.y() * n.y(), 3 * n.z() * n.z() - 1;
  return h;
}

ObservedGains ObserveGains(const ImageF& filmed, const ImageF& layer, const Image8& held_out,
                           const PointsX3& points, const FacesX3& faces, const RayScene& scene,
                           const View& view, double blur_px) {
  const Compared both = Compare(filmed, layer, held_out, blur_px);
  ObservedGains observed{PointsX3::Ones(points.rows(), 3), Eigen::VectorXd::Zero(points.rows()),
                         VertexNormals(points, faces)};
  const Vector3d eye = view.Center();
  const double lift = 1e-4 * BoundingDiagonal(points);
  const auto observe = [&](std::int64_t v) {
    const Vector3d x = points.row(v), normal = observed.normals.row(v);
    const Vector3d to_eye = eye - x;
    const double facing = normal.dot(to_eye.normalized());
    if (facing < kLeastFacing || scene.Occluded(x + lift * normal, to_eye, 0, 1)) return;
    const Eigen::Vector2d pixel = view.Project(x);
    const int px = static_cast<int>(std::floor(pixel.x())),
              py = static_cast<int>(std::floor(pixel.y()));
    if (px < 0 || py < 0 || px >= layer.width || py >= layer.height) return;
    if (layer.at(px, py)[3] < kInside) return;
    const float *f = both.filmed.at(px, py), *l = both.layer.at(px, py);
    if (f[3] < 0.3f) return;  // hardly anything of its neighbourhood can be compared
    for (int c = 0; c < 3; ++c)
      observed.gains(v, c) = std::clamp(f[c] / std::max(l[c], 1e-3f), 0.05f, 8.0f);
    observed.weights[v] = facing;
  };
  ParallelFor(points.rows(), observe, 256);
  return observed;
}

ShotLight FitShotLight(const std::vector<ObservedGains>& frames, const FacesX3& faces) {
  ShotLight light;
  light.harmonics.row(0).setOnes();
  for (int c = 0; c < 3; ++c) {
    Eigen::Matrix<double, 9, 1> solution;
    if (SolveChannel(frames, c, &solution)) light.harmonics.col(c) = solution;
  }
  const auto edges = UndirectedEdges(faces);
  for (const ObservedGains& frame : frames) {
    PointsX3 rest = PointsX3::Ones(frame.gains.rows(), 3);
    for (Eigen::Index v = 0; v < rest.rows(); ++v) {
      if (frame.weights[v] <= 0) continue;
      const Harmonics h = HarmonicsOf(frame.normals.row(v));
      for (int c = 0; c < 3; ++c) rest(v, c) = frame.gains(v, c) / HarmonicLight(light, h, c);
    }
    light.rest.push_back(SpreadRest(rest, frame.weights, edges));
    light.seen.push_back(frame.weights.cwiseMin(1.0));
  }
  return light;
}

PointsX3 GainsBetween(const ShotLight& light, int before, int after, double share,
                      const PointsX3& normals) {
  PointsX3 gains(normals.rows(), 3);
  const bool observed = before >= 0 && before < SizeOf(light.rest) && after < SizeOf(light.rest);
  for (Eigen::Index v = 0; v < gains.rows(); ++v) {
    const Harmonics h = HarmonicsOf(normals.row(v));
    Eigen::RowVector3d rest = Eigen::RowVector3d::Ones();
    if (observed) {
      const double a = (1 - share) * (kUnseen + light.seen[before][v]),
                   b = share * (kUnseen + light.seen[after][v]);
      rest = (a * light.rest[before].row(v) + b * light.rest[after].row(v)) / (a + b);
    }
    for (int c = 0; c < 3; ++c)
      gains(v, c) = std::clamp(HarmonicLight(light, h, c) * rest[c], kLeastGain, kMostGain);
  }
  return gains;
}

}  // namespace keypose::composite
