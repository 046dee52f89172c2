#include "interpolate/volume/tet_paths.h"

#include <Eigen/LU>
#include <cmath>
#include <optional>

#include "core/values/tuned.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/volume/tet_maps.h"

namespace keypose::interpolation {

namespace {

// Chosen on the twisted bars (docs/results/interpolation.md); sensitivity:
// docs/results/sensitivity.md.
struct TetPathsTuning {
  // rad: near half a turn the logarithm may take the other direction than the neighbours'
  KEYPOSE_TUNED(double, kFarFromRegion, 2.5);
};

constexpr double kFlatGrowth = 1e-9;  // of the mean edge growth cubed

}  // namespace

TetPath::TetPath(const Eigen::Matrix3d& map, const Eigen::Vector3d& turn, double growth)
    : turn_(turn) {
  const Eigen::Matrix3d f = ExpOf(turn).transpose() * map, rotation = ClosestRotation(f);
  remainder_ = LogOf(rotation);
  const double size = f.norm();
  std::optional<Eigen::Matrix3d> log;
  if (f.determinant() > kFlatGrowth * size * size * size &&
      remainder_.norm() < TetPathsTuning::kFarFromRegion)
    log = LogOfMatrix(f);
  has_power_ = log.has_value();
  if (!has_power_) {
    stretch_ = rotation.transpose() * f;
    return;
  }
  growth_ = growth;
  volume_log_ = log->trace() - 3 * growth;
  volume_gain_ = std::expm1(volume_log_);
  power_ = MatrixExponential(*log - growth * Eigen::Matrix3d::Identity());
}

TetPath TetPath::Straight(const Eigen::Matrix3d& start, const Eigen::Matrix3d& end,
                          const Eigen::Vector3d& body_turn) {
  TetPath path;
  path.turn_ = -body_turn;
  path.remainder_.setZero();
  path.start_ = start;
  path.stretch_ = end;
  return path;
}

Eigen::Matrix3d TetPath::At(double t) const {
  const Eigen::Matrix3d turn = ExpOf(t * turn_);
  if (!has_power_) return turn * ExpOf(t * remainder_) * ((1 - t) * start_ + t * stretch_);
  // tau: the value at which exp(tau volume_log) is 1 - t + t exp(volume_log).
  const double tau = std::abs(volume_log_) < 1e-9 ? t : std::log1p(t * volume_gain_) / volume_log_;
  return std::exp(t * growth_) * (turn * power_.At(tau));
}

}  // namespace keypose::interpolation
