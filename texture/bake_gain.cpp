#include "texture/bake_gain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/geometry.h"
#include "core/parallel.h"

namespace keypose::texture {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

struct Observation {
  int view;
  double weight;
  Vector3d log_color;
};
using Observations = std::vector<std::vector<Observation>>;  // one list a surface point

Observations Observe(const Mesh& mesh, const std::vector<BakeView>& views, int samples) {
  const SurfaceSamples surface = SampleSurface(mesh.points, mesh.faces, samples, 20);
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  Observations lists(samples);
  ParallelFor(
      samples,
      [&](std::int64_t i) {
        const Vector3d x = surface.points.row(i), n = normals.row(surface.faces[i]);
        for (int v = 0; v < static_cast<int>(views.size()); ++v) {
          const double cosine = n.dot((views[v].center() - x).normalized());
          if (cosine < 0.3) continue;
          const Sighting sighting = views[v].See(x);
          if (sighting.trust <= 0) continue;
          const Eigen::Vector3f color = views[v].ColorAt(sighting.pixel, 1.5).color;
          // Near black the logarithm is noise, near white the sensor has clipped.
          if (color.minCoeff() < 0.004f || color.maxCoeff() > 0.93f) continue;
          lists[i].push_back({v, sighting.trust * cosine, color.cast<double>().array().log().matrix()});
        }
      },
      64);
  return lists;
}

/// One round of weighted least squares for the log gains of a channel. `gain` enters only through the outlier weights.
VectorXd SolveRound(const Observations& lists, int channel, const VectorXd& gain, double scale) {
  const int n = static_cast<int>(gain.size());
  MatrixXd matrix = MatrixXd::Zero(n, n);
  VectorXd right = VectorXd::Zero(n);
  std::vector<double> weights;
  for (const auto& list : lists) {
    if (list.size() < 2) continue;
    double total = 0, mean = 0;
    for (const Observation& o : list) {
      total += o.weight;
      mean += o.weight * (o.log_color[channel] + gain[o.view]);
    }
    mean /= total;
    weights.clear();
    double sum = 0, sum_log = 0;
    for (const Observation& o : list) {
      const double r = (o.log_color[channel] + gain[o.view] - mean) / scale;
      weights.push_back(o.weight / ((1 + r * r) * (1 + r * r)));
      sum += weights.back();
      sum_log += weights.back() * o.log_color[channel];
    }
    for (std::size_t a = 0; a < list.size(); ++a) {
      right[list[a].view] -= weights[a] * (list[a].log_color[channel] - sum_log / sum);
      matrix(list[a].view, list[a].view) += weights[a];
      for (std::size_t b = 0; b < list.size(); ++b) matrix(list[a].view, list[b].view) -= weights[a] * weights[b] / sum;
    }
  }
  // Only differences of log gains are known; this holds their mean, and views without neighbours, at zero.
  const double anchor = 1e-5 * std::max(matrix.trace() / n, 1e-9);
  matrix.diagonal().array() += anchor;
  return matrix.ldlt().solve(right);
}

}  // namespace

std::vector<Eigen::Vector3f> HarmonizeGains(const Mesh& mesh, const std::vector<BakeView>& views, int samples) {
  const Observations lists = Observe(mesh, views, samples);
  const int n = static_cast<int>(views.size());
  std::vector<Eigen::Vector3f> gains(n, Eigen::Vector3f::Ones());
  for (int channel = 0; channel < 3; ++channel) {
    VectorXd gain = VectorXd::Zero(n);
    // Graduated: nearly plain least squares first, then only what lies within a few per cent counts fully.
    for (const double scale : {2.0, 0.6, 0.3, 0.15, 0.15, 0.15, 0.15}) gain = SolveRound(lists, channel, gain, scale);
    gain.array() -= gain.mean();
    for (int v = 0; v < n; ++v) gains[v][channel] = static_cast<float>(std::clamp(std::exp(gain[v]), 0.5, 2.0));
  }
  return gains;
}

}  // namespace keypose::texture
