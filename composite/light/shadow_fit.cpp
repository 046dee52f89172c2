#include "composite/light/shadow_fit.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"

namespace keypose::composite {
namespace {

using Eigen::Vector3d;

constexpr int kFewestSamples = 50;
constexpr int kCoarseRays = 10, kFineRays = 24;
constexpr double kOutlier = 0.15;  // of light lost: what moved, or is no table
constexpr double kMostStrength = 1.5;

struct Rows {
  Eigen::VectorXd sky, lost;
};

/// What one unit of a shadow's strength takes of the light, at all samples.
/// @param hidden  gives the hidden share of a light at a place before a figure
template <class Hidden>
Eigen::VectorXd RowOf(const std::vector<ShadowSamples>& frames, Eigen::Index count,
                      const Hidden& hidden) {
  Eigen::VectorXd row(count);
  Eigen::Index first = 0;
  for (const ShadowSamples& frame : frames) {
    const auto at_figure = hidden(*frame.figure);
    ParallelFor(
        std::ssize(frame.places),
        [&](std::int64_t i) { row[first + i] = at_figure(frame.places[i]); }, 32);
    if (frame.other) {
      const auto at_other = hidden(*frame.other);
      ParallelFor(
          std::ssize(frame.places),
          [&](std::int64_t i) {
            row[first + i] -= (1 - frame.lost[i]) * at_other(frame.places[i]);
          },
          32);
    }
    first += std::ssize(frame.places);
  }
  return row;
}

/// Of a lamp.
Eigen::VectorXd HiddenFrom(const std::vector<ShadowSamples>& frames, const Ground& ground,
                           const SoftLamp& lamp, int rays, Eigen::Index count) {
  const std::vector<Vector3d> directions = RaysTo(lamp, rays);
  return RowOf(frames, count, [&](const RayScene& figure) {
    return [&](const Vector3d& place) {
      const Vector3d from = place - 1e-5 * ground.diagonal * ground.up;
      int blocked = 0;
      for (const Vector3d& to : directions)
        blocked += figure.Occluded(from, to, 0, std::numeric_limits<double>::infinity());
      return static_cast<double>(blocked) / rays;
    };
  });
}

/// Non-negative weights of two columns by robust least squares.
struct TwoWeights {
  double sky = 0, lamp = 0, cost = 0;
};

TwoWeights Solve(const Rows& rows, const Eigen::VectorXd& lamp) {
  TwoWeights best;
  Eigen::VectorXd w = Eigen::VectorXd::Ones(rows.lost.size());
  for (int round = 0; round < 6; ++round) {
    const double ss = (w.array() * rows.sky.array().square()).sum() + 1e-9,
                 ll = (w.array() * lamp.array().square()).sum() + 1e-9,
                 sl = (w.array() * rows.sky.array() * lamp.array()).sum(),
                 sy = (w.array() * rows.sky.array() * rows.lost.array()).sum(),
                 ly = (w.array() * lamp.array() * rows.lost.array()).sum();
    const double determinant = ss * ll - sl * sl;
    best.sky = determinant > 1e-12 * ss * ll ? (sy * ll - ly * sl) / determinant : sy / ss;
    best.lamp = determinant > 1e-12 * ss * ll ? (ly * ss - sy * sl) / determinant : 0;
    if (best.sky < 0) {
      best.sky = 0;
      best.lamp = ly / ll;
    }
    if (best.lamp < 0) {
      best.lamp = 0;
      best.sky = sy / ss;
    }
    best.sky = std::clamp(best.sky, 0.0, kMostStrength);
    best.lamp = std::clamp(best.lamp, 0.0, kMostStrength);
    const Eigen::ArrayXd residual = (best.sky * rows.sky + best.lamp * lamp - rows.lost).array();
    w = (kOutlier * kOutlier / (kOutlier * kOutlier + residual.square())).square().matrix();
    best.cost = (residual.square() / (kOutlier * kOutlier + residual.square())).sum();
  }
  return best;
}

SoftLamp LampAt(const Ground& ground, double azimuth, double elevation, double radius) {
  return {
      std::cos(elevation) * (std::cos(azimuth) * ground.right + std::sin(azimuth) * ground.back) +
          std::sin(elevation) * ground.up,
      radius};
}

struct LampPlace {
  double azimuth = 0, elevation = 0.9, radius = 0.12;
};

class LampSearch {
 public:
  LampSearch(const std::vector<ShadowSamples>& frames, const Ground& ground, const Rows& rows)
      : frames_(frames), ground_(ground), rows_(rows) {}

  void Coarse() {
    constexpr int kAzimuths = 16;
    for (int a = 0; a < kAzimuths; ++a)
      for (const double degrees : {20.0, 35.0, 50.0, 65.0})
        Try({2 * kPi * a / kAzimuths, degrees * kPi / 180, 0.12}, kCoarseRays);
  }
  void Fine() {
    cost_ = std::numeric_limits<double>::infinity();
    Try(LampPlace(place_), kFineRays);
    for (double step = 0.2; step > 0.02; step /= 2) {
      const LampPlace at = place_;
      for (const double side : {-1.0, 1.0}) {
        Try({at.azimuth + side * step, at.elevation, at.radius}, kFineRays);
        Try({at.azimuth, std::clamp(at.elevation + side * step, 0.15, 1.5), at.radius}, kFineRays);
        Try({at.azimuth, at.elevation, std::clamp(at.radius * (1 + 2 * side * step), 0.02, 0.5)},
            kFineRays);
      }
    }
  }
  const TwoWeights& weights() const { return weights_; }
  SoftLamp lamp() const { return LampAt(ground_, place_.azimuth, place_.elevation, place_.radius); }

 private:
  void Try(const LampPlace& place, int rays) {
    const SoftLamp lamp = LampAt(ground_, place.azimuth, place.elevation, place.radius);
    const TwoWeights found =
        Solve(rows_, HiddenFrom(frames_, ground_, lamp, rays, rows_.lost.size()));
    if (found.cost >= cost_) return;
    cost_ = found.cost;
    place_ = place;
    weights_ = found;
  }

  const std::vector<ShadowSamples>& frames_;
  const Ground& ground_;
  const Rows& rows_;
  double cost_ = std::numeric_limits<double>::infinity();
  LampPlace place_;
  TwoWeights weights_;
};

}  // namespace

ShadowFit FitShadow(const std::vector<ShadowSamples>& frames, const Ground& ground) {
  ShadowFit fit;
  for (const ShadowSamples& frame : frames) fit.samples += static_cast<int>(frame.places.size());
  if (fit.samples < kFewestSamples) return fit;
  Rows rows{RowOf(frames, fit.samples,
                  [&](const RayScene& figure) {
                    return [sky = GroundShadow(figure, ground)](const Vector3d& place) {
                      return sky.Hidden(place);
                    };
                  }),
            Eigen::VectorXd(fit.samples)};
  Eigen::Index at = 0;
  for (const ShadowSamples& frame : frames)
    for (const double lost : frame.lost) rows.lost[at++] = lost;
  LampSearch search(frames, ground, rows);
  search.Coarse();
  search.Fine();
  fit.strength = {search.weights().sky, search.weights().lamp, search.lamp()};
  Eigen::VectorXd zero = Eigen::VectorXd::Zero(fit.samples);
  Rows none = rows;
  none.sky.setZero();
  const double before = Solve(none, zero).cost;
  if (before > 0) fit.explained = std::clamp(1 - search.weights().cost / before, 0.0, 1.0);
  return fit;
}

}  // namespace keypose::composite
