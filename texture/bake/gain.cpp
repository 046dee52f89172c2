#include "texture/bake/gain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Tuned on held-out photographs of the skull, whose exposures differ threefold, the plush dog,
/// whose do not, and the synthetic character (docs/algorithms/bake.md).
struct GainTuning {
  /// factor: a larger gain between two photographs of one pose is an error of this estimate
  KEYPOSE_TUNED(double, kMostGain, 3);
  /// weight of the prior "no gain", of the views' mean weight of observations
  KEYPOSE_TUNED(double, kBelief, 0.05);
  /// the same for light, over the squared number of photographs and in addition: with two
  /// photographs a lamp and an exposure are ambiguous, with thirty they are not
  KEYPOSE_TUNED(double, kLightBelief, 3);
  /// logarithm of linear light: larger differences are outliers in the last rounds
  KEYPOSE_TUNED(double, kOutlier, 0.15);
};
double LightBelief(int photographs) {
  return GainTuning::kBelief + GainTuning::kLightBelief / (photographs * photographs);
}

/// Dependence of the surface's light on its normal in the camera's frame: a flash on the camera
/// (the logarithm of the cosine), and a fixed lamp beside it (the normal's component to the right).
/// Light from above is not estimated: it is indistinguishable from the exposure of a ring of views.
constexpr int kLights = 2;
using Lights = Eigen::Matrix<double, kLights, 1>;

struct GainObservation {
  int view;
  double weight;
  Lights lights;
  Vector3d log_color;
};
using GainObservations = std::vector<std::vector<GainObservation>>;  // one list per surface point

GainObservations Observe(const Mesh& mesh, const std::vector<BakeView>& views,
                         const std::vector<char>& used, int samples) {
  const SurfaceSamples surface = SampleSurface(mesh.points, mesh.faces, samples, 20);
  const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
  GainObservations lists(samples);
  ParallelFor(
      samples,
      [&](std::int64_t i) {
        const Vector3d x = surface.points.row(i), n = normals.row(surface.faces[i]);
        for (int v = 0; v < std::ssize(views); ++v) {
          if (!used[v]) continue;
          const double cosine = n.dot((views[v].center() - x).normalized());
          if (cosine < 0.3) continue;
          const Sighting sighting = views[v].See(x);
          if (sighting.trust <= 0) continue;
          const Eigen::Vector3f color = views[v].ColorAt(sighting.pixel.cast<float>(), 1.5f).color;
          // Near black the logarithm is dominated by noise, near white the sensor clips.
          if (color.minCoeff() < 0.004f || color.maxCoeff() > 0.93f) continue;
          const Lights lights(-std::log(cosine),
                              (views[v].view().camera_from_world.rotation * n).x());
          lists[i].push_back(
              {v, sighting.trust * cosine, lights, color.cast<double>().array().log().matrix()});
        }
      },
      64);
  return lists;
}

/// The unknowns of a channel: a log gain for each view, and the dependence of brightness on the
/// surface's normal in the camera's frame. Without the latter, a turntable's fixed lamps would
/// appear as exposures: the lit side as overexposed.
struct Unknowns {
  VectorXd log_gain;
  Lights light = Lights::Zero();
  double Corrected(const GainObservation& o, int channel) const {
    return o.log_color[channel] + log_gain[o.view] + light.dot(o.lights);
  }
};

/// Robust weights of one point's observations under the current estimate.
void Weigh(const std::vector<GainObservation>& list, int channel, const Unknowns& unknowns,
           double scale, std::vector<double>& weights) {
  double total = 0, mean = 0;
  for (const GainObservation& o : list) {
    total += o.weight;
    mean += o.weight * unknowns.Corrected(o, channel);
  }
  mean /= total;
  weights.clear();
  for (const GainObservation& o : list) {
    const double r = (unknowns.Corrected(o, channel) - mean) / scale;
    weights.push_back(o.weight / ((1 + r * r) * (1 + r * r)));
  }
}

/// One round of weighted least squares, with each point's own colour eliminated.
Unknowns SolveRound(const GainObservations& lists, int channel, const Unknowns& before,
                    double scale) {
  const int n = SizeOf(before.log_gain);
  MatrixXd matrix = MatrixXd::Zero(n + kLights, n + kLights);
  VectorXd right = VectorXd::Zero(n + kLights);
  std::vector<double> weights;
  for (const auto& list : lists) {
    if (list.size() < 2) continue;
    Weigh(list, channel, before, scale, weights);
    double sum = 0, sum_log = 0;
    Lights sum_lights = Lights::Zero();
    for (std::size_t a = 0; a < list.size(); ++a) {
      sum += weights[a];
      sum_log += weights[a] * list[a].log_color[channel];
      sum_lights += weights[a] * list[a].lights;
    }
    for (std::size_t a = 0; a < list.size(); ++a) {
      const int v = list[a].view;
      const double w = weights[a], log_color = list[a].log_color[channel] - sum_log / sum;
      const Lights lights = list[a].lights - sum_lights / sum;
      right[v] -= w * log_color;
      right.tail<kLights>() -= w * log_color * lights;
      matrix(v, v) += w;
      for (std::size_t b = 0; b < list.size(); ++b) matrix(v, list[b].view) -= w * weights[b] / sum;
      matrix.block<1, kLights>(v, n) += w * lights.transpose();
      matrix.block<kLights, 1>(n, v) += w * lights;
      matrix.block<kLights, kLights>(n, n) += w * lights * lights.transpose();
    }
  }
  // Only differences of log gains are determined; this prior keeps their mean, and views without
  // neighbours, at zero. Shading outside of the model slightly biases whole rings of views, so the
  // prior also limits gains with weak evidence.
  const double view = std::max(matrix.diagonal().head(n).mean(), 1e-9);
  matrix.diagonal().head(n).array() += GainTuning::kBelief * view;
  matrix.diagonal().tail(kLights).array() += LightBelief(n) * view;
  const VectorXd solved = matrix.ldlt().solve(right);
  return {solved.head(n), solved.tail<kLights>()};
}

}  // namespace

std::vector<Eigen::Vector3f> HarmonizeGains(const Mesh& mesh, const std::vector<BakeView>& views,
                                            const std::vector<char>& used, int samples) {
  using Tuning = GainTuning;
  const GainObservations lists = Observe(mesh, views, used, samples);
  const int n = SizeOf(views);
  MatrixXd log_gains(n, 3);
  for (int channel = 0; channel < 3; ++channel) {
    Unknowns unknowns{VectorXd::Zero(n), Lights::Zero()};
    // Graduated scale: first nearly plain least squares, then only differences within a few per
    // cent have full weight.
    for (const double scale :
         {2.0, 0.6, 0.3, Tuning::kOutlier, Tuning::kOutlier, Tuning::kOutlier, Tuning::kOutlier})
      unknowns = SolveRound(lists, channel, unknowns, scale);
    log_gains.col(channel) = unknowns.log_gain;
  }
  // The mean exposure is the closest to all photographs, and so to further ones.
  VectorXd shown = VectorXd::Constant(n, 1e-9);
  for (const auto& list : lists)
    for (const GainObservation& o : list) shown[o.view] += o.weight;
  const Eigen::RowVector3d reference = shown.transpose() * log_gains / shown.sum();
  std::vector<Eigen::Vector3f> gains(n, Eigen::Vector3f::Ones());
  for (int v = 0; v < n; ++v)
    if (used[v])
      gains[v] = (log_gains.row(v) - reference)
                     .array()
                     .exp()
                     .max(1.0 / Tuning::kMostGain)
                     .min(Tuning::kMostGain)
                     .cast<float>()
                     .matrix()
                     .transpose();
  return gains;
}

}  // namespace keypose::texture
