#include "motion/video3d/camera_exposure.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

namespace keypose::motion {
namespace {

constexpr float kDarkest = 0.02f, kBrightest = 0.98f;
constexpr double kSameLight = 0.15;  // of logarithms; larger differences are not exposure
constexpr int kRounds = 12;
constexpr double kUnitGain = 1e-6;  // weight of gain 1, in the mean weight of a camera

struct LogPair {
  int a, b;
  double log_ratio;  // of b over a
  double weight;
};

std::vector<LogPair> LogsOf(const std::vector<ColorPair>& pairs, int channel) {
  std::vector<LogPair> logs;
  for (const ColorPair& pair : pairs) {
    const float a = pair.color_a[channel], b = pair.color_b[channel];
    if (std::min(a, b) < kDarkest || std::max(a, b) > kBrightest) continue;
    logs.push_back({pair.a, pair.b, std::log(static_cast<double>(b) / a), pair.weight});
  }
  return logs;
}

/// Logarithms of the gains.
Eigen::VectorXd Solve(const std::vector<LogPair>& logs, const Eigen::VectorXd& old, bool robust) {
  const Eigen::Index n = old.size();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
  double total = 0;
  for (const LogPair& pair : logs) {
    const double off = (old[pair.a] - old[pair.b] - pair.log_ratio) / kSameLight;
    const double w = robust ? pair.weight / (1 + off * off) : pair.weight;
    normal(pair.a, pair.a) += w;
    normal(pair.b, pair.b) += w;
    normal(pair.a, pair.b) -= w;
    normal(pair.b, pair.a) -= w;
    right[pair.a] += w * pair.log_ratio;
    right[pair.b] -= w * pair.log_ratio;
    total += w;
  }
  normal.diagonal().array() += kUnitGain * std::max(total / static_cast<double>(n), 1e-9);
  return normal.ldlt().solve(right);
}

}  // namespace

CameraExposures LevelExposures(const std::vector<ColorPair>& pairs, int cameras) {
  CameraExposures exposure;
  exposure.gains.assign(cameras, Eigen::Vector3f::Ones());
  exposure.compared.assign(cameras, 0);
  for (int c = 0; c < 3; ++c) {
    const std::vector<LogPair> logs = LogsOf(pairs, c);
    if (logs.empty()) continue;
    for (const LogPair& pair : logs) exposure.compared[pair.a] = exposure.compared[pair.b] = 1;
    Eigen::VectorXd gains = Eigen::VectorXd::Zero(cameras);
    for (int round = 0; round < kRounds; ++round) gains = Solve(logs, gains, round > 0);
    for (int v = 0; v < cameras; ++v) exposure.gains[v][c] = static_cast<float>(std::exp(gains[v]));
  }
  return exposure;
}

}  // namespace keypose::motion
