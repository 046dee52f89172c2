#include "texture/packing/elastic_packing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/tuned.h"
#include "texture/charts/parametrise.h"
#include "texture/packing/contact.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;

// Tuned on the charts of the armadillo, the plush dog and the skull by their utilisation
// (docs/algorithms/unwrap.md); the limits of distortion leave room to those that are wanted
// (1.15, 10 %).
struct ElasticPackingTuning {
  KEYPOSE_TUNED(double, kDepth, 0.012);   // of the square's side: largest overlap that is resolved
  KEYPOSE_TUNED(double, kHold, 2);        // weight of boundary targets, in cotangents of about 1
  KEYPOSE_TUNED(double, kPressure, 0.4);  // share of a displacement that is kept as pressure
  KEYPOSE_TUNED(double, kRelease, 0.9);   // factor of the pressure after a round without contact
  KEYPOSE_TUNED(double, kGrowth, 0.001);  // of the scale in a round
  // share of a boundary's small teeth that a round straightens
  KEYPOSE_TUNED(double, kStraightening, 0.1);
  // growth ends when the mean of s1 / s2 over all faces exceeds the first, or when the mean
  // relative deviation of areas exceeds the second
  KEYPOSE_TUNED(double, kMostConformal, 1.13);
  KEYPOSE_TUNED(double, kMostDeviation, 0.088);
};

// times the gap: displacements converge slowly, so their target is somewhat larger
constexpr double kAim = 1.05;
constexpr double kFarthestAim = 1.6;
constexpr int kRigidRounds = 40;  // at one scale
constexpr double kRigidShrink = 0.998;
constexpr int kMeasureEvery = 8;
constexpr int kSettlingRounds = 60;
constexpr double kEase = 0.98;
// least area of a triangle, relative to its area without stress
constexpr double kLeastStressedArea = 0.1;

double ReachOf(double gap) { return kFarthestAim * gap + ElasticPackingTuning::kDepth; }

// The rigid motion that fits the displacements best; vertices without contact are ignored.
void Follow(const UvsX2& rim, const UvsX2& push, Placement& place) {
  const Vector2d center = rim.colwise().mean().transpose();
  Vector2d shift = Vector2d::Zero();
  double torque = 0, inertia = 0, count = 0;
  for (Eigen::Index v = 0; v < rim.rows(); ++v) {
    const Vector2d p = push.row(v).transpose(), r = rim.row(v).transpose() - center;
    if (p.isZero(0)) continue;
    shift += p;
    torque += r.x() * p.y() - r.y() * p.x();
    inertia += r.squaredNorm();
    count += 1;
  }
  if (!(count > 0)) return;
  const double turn = 0.5 * torque / std::max(inertia, 1e-300);
  const Eigen::Rotation2D<double> rotation(turn);
  place.offset = center + rotation * (place.offset - center) + 0.8 * shift / count;
  place.angle += turn;
}

std::vector<UvsX2> RimsOf(const std::vector<const Chart*>& charts, const std::vector<UvsX2>& uvs) {
  std::vector<UvsX2> rims(charts.size());
  for (std::size_t c = 0; c < charts.size(); ++c) {
    rims[c].resize(std::ssize(charts[c]->rim), 2);
    for (std::size_t i = 0; i < charts[c]->rim.size(); ++i)
      rims[c].row(i) = uvs[c].row(charts[c]->rim[i]);
  }
  return rims;
}

UvsX2 Blurred(const UvsX2& rim, int rounds) {
  const Eigen::Index n = rim.rows();
  UvsX2 now = rim, next(n, 2);
  for (int round = 0; round < rounds; ++round) {
    for (Eigen::Index i = 0; i < n; ++i)
      next.row(i) = (now.row((i + n - 1) % n) + 2 * now.row(i) + now.row((i + 1) % n)) / 4;
    std::swap(now, next);
  }
  return now;
}

// A blur without shrinking: small teeth are removed, bays stay.
UvsX2 Straightened(const UvsX2& rim) {
  const UvsX2 once = Blurred(rim, 6);
  return 2 * once - Blurred(once, 6);
}

double Covered(const std::vector<const Chart*>& charts, const std::vector<UvsX2>& uvs) {
  double area = 0;
  for (std::size_t c = 0; c < charts.size(); ++c)
    for (int i = 0; i < std::ssize(charts[c]->faces); ++i)
      area += SignedArea(uvs[c], *charts[c], i);
  return area;
}

class ElasticPacking {
  using Tuning = ElasticPackingTuning;

 public:
  ElasticPacking(const Surface& surface, const std::vector<const Chart*>& charts,
                 const Layout& layout, const ElasticPackingOptions& options)
      : surface_(surface),
        charts_(charts),
        options_(options),
        now_(layout),
        best_(layout),
        ease_(charts.size(), 1.0) {
    sheets_.resize(charts.size());
    ParallelFor(std::ssize(charts),
                [&](std::int64_t c) { sheets_[c].emplace(surface, *charts[c], Tuning::kHold); });
    best_area_ = Covered(charts, layout.uvs);
    for (const Chart* chart : charts) pressure_.push_back(UvsX2::Zero(std::ssize(chart->rim), 2));
  }

  Layout Run() {
    for (int round = 0; round < options_.rounds; ++round) {
      Step();
      if (round % kMeasureEvery == 0 && TooDistorted()) break;
      if (gap_ > -options_.gap) now_.scale *= 1 + Tuning::kGrowth;
    }
    for (int round = 0; round < kSettlingRounds; ++round) {
      Step();
      // The last part of the pressure converges slowly, so the target distance is larger than
      // needed.
      aim_ =
          gap_ < options_.gap ? std::min(kFarthestAim, aim_ + 0.02) : std::max(kAim, aim_ - 0.005);
      Keep();
    }
    return best_;
  }

 private:
  // `gap_` is that of the layout before the step.
  void Step() {
    const std::vector<UvsX2> rims = RimsOf(charts_, now_.uvs);
    const Contacts contacts = FindContacts(rims, aim_ * options_.gap, ReachOf(options_.gap));
    gap_ = contacts.least_gap;
    ParallelFor(std::ssize(charts_), [&](std::int64_t c) {
      const UvsX2 push = contacts.push[c].cwiseMax(-Tuning::kDepth).cwiseMin(Tuning::kDepth);
      for (Eigen::Index v = 0; v < push.rows(); ++v) {
        if (push.row(v).isZero(0)) {
          pressure_[c].row(v) *= Tuning::kRelease;
        } else {
          pressure_[c].row(v) += Tuning::kPressure * push.row(v);
        }
      }
      UvsX2 targets = rims[c] + push + pressure_[c];
      targets += Tuning::kStraightening * (Straightened(rims[c]) - rims[c]);
      sheets_[c]->Settle(ease_[c] * now_.scale, targets, now_.uvs[c]);
    });
  }

  bool TooDistorted() const {
    std::vector<double> conformal(charts_.size(), 0), deviation(charts_.size(), 0),
        area(charts_.size(), 0);
    const double flat = Covered(charts_, now_.uvs);
    double whole = 0;
    for (const auto& sheet : sheets_) whole += sheet->rest().area;
    ParallelFor(std::ssize(charts_), [&](std::int64_t c) {
      for (int i = 0; i < std::ssize(charts_[c]->faces); ++i) {
        const double rest = surface_.areas[charts_[c]->faces[i]];
        conformal[c] += rest * ConformalRatio(surface_, *charts_[c], now_.uvs[c], i);
        deviation[c] += std::abs(SignedArea(now_.uvs[c], *charts_[c], i) * whole / flat - rest);
      }
    });
    const double ratio = std::accumulate(conformal.begin(), conformal.end(), 0.0) / whole;
    return ratio > Tuning::kMostConformal ||
           std::accumulate(deviation.begin(), deviation.end(), 0.0) / whole >
               Tuning::kMostDeviation;
  }

  // A sheet that is about to fold is relaxed, so that it does not invalidate the whole layout.
  void Keep() {
    if (gap_ < options_.gap) return;
    std::vector<char> good(charts_.size());
    ParallelFor(std::ssize(charts_), [&](std::int64_t c) {
      good[c] = Upright(surface_, *charts_[c], now_.uvs[c], kLeastStressedArea, now_.scale) &&
                RimIsSimple(*charts_[c], now_.uvs[c]);
      if (!good[c]) ease_[c] *= kEase;
    });
    if (std::count(good.begin(), good.end(), 0) > 0) return;
    const double area = Covered(charts_, now_.uvs);
    if (area <= best_area_) return;
    const std::vector<UvsX2> rims = RimsOf(charts_, now_.uvs);
    if (FindContacts(rims, options_.gap, ReachOf(options_.gap)).least_gap < options_.gap ||
        AnyCross(rims))
      return;
    best_ = now_;
    best_area_ = area;
  }

  const Surface& surface_;
  const std::vector<const Chart*>& charts_;
  ElasticPackingOptions options_;
  Layout now_, best_;
  std::vector<double> ease_;
  std::vector<std::optional<Sheet>> sheets_;
  std::vector<UvsX2> pressure_;  // per boundary vertex: accumulated displacements of its contacts,
                                 // so that they are met under load
  double best_area_ = 0, gap_ = 0, aim_ = kAim;
};

}  // namespace

UvsX2 Placed(const UvsX2& points, double scale, const Placement& place) {
  const double c = scale * std::cos(place.angle), s = scale * std::sin(place.angle);
  UvsX2 out(points.rows(), 2);
  out.col(0) = (c * points.col(0) - s * points.col(1)).array() + place.offset.x();
  out.col(1) = (s * points.col(0) + c * points.col(1)).array() + place.offset.y();
  return out;
}

std::optional<Nesting> SetApart(const std::vector<UvsX2>& outlines, Nesting nesting, double gap) {
  const double least = nesting.scale * 0.67;
  std::vector<UvsX2> rims(outlines.size());
  for (; nesting.scale > least; nesting.scale *= kRigidShrink) {
    for (int round = 0; round < kRigidRounds; ++round) {
      for (std::size_t i = 0; i < outlines.size(); ++i)
        rims[i] = Placed(outlines[i], nesting.scale, nesting.places[i]);
      const Contacts contacts = FindContacts(rims, kAim * gap, ReachOf(gap));
      if (contacts.least_gap >= gap && !AnyCross(rims)) return nesting;
      for (std::size_t i = 0; i < outlines.size(); ++i)
        Follow(rims[i], contacts.push[i], nesting.places[i]);
    }
    // Charts shrink about their own centres, not about the origin of their coordinates.
    for (std::size_t i = 0; i < outlines.size(); ++i) {
      const Vector2d center = rims[i].colwise().mean().transpose();
      nesting.places[i].offset = center + kRigidShrink * (nesting.places[i].offset - center);
    }
  }
  return std::nullopt;
}

Layout PackElastically(const Surface& surface, const std::vector<const Chart*>& charts,
                       const Layout& layout, const ElasticPackingOptions& options) {
  return ElasticPacking(surface, charts, layout, options).Run();
}

}  // namespace keypose::texture
