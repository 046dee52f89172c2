#include "interpolate/pair_paths.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "interpolate/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation {

namespace {

using Record = PairPaths::Record;

void SetTurns(const Eigen::Vector3d& turn, std::array<double, 3>& axis, double& angle) {
  angle = turn.norm();
  for (int c = 0; c < 3; ++c) axis[c] = angle > 0 ? turn[c] / angle : 0.0;
}

using Edges = Eigen::Matrix<double, 3, 2>;

/// log(m) = (log_det / 2) I + n, n^2 = discriminant I; false where the logarithm is not real, or nearly so.
bool LogOf2(const Eigen::Matrix2d& m, double& log_det, Eigen::Matrix2d& n, double& discriminant) {
  const double root = std::sqrt(m.determinant());
  log_det = 2 * std::log(root);
  const double mean = 0.5 * m.trace() / root, half = 0.5 * (m(0, 0) - m(1, 1)) / root;
  n << half, m(0, 1) / root, m(1, 0) / root, -half;
  // exp(n s) = cosh(s) I + sinh(s) n for the unit n: the traceless part is sinh, or sine, of what is sought.
  const double q = half * half + n(0, 1) * n(1, 0);
  if (!(mean > -0.9) || (mean <= 0 && q >= 0)) return false;
  double factor = 1 - q / 6;
  if (std::abs(q) > 1e-6) factor = q > 0 ? std::asinh(std::sqrt(q)) / std::sqrt(q) : std::atan2(std::sqrt(-q), mean) / std::sqrt(-q);
  if (mean < 0 && std::abs(q) <= 1e-6) return false;
  n *= factor;
  discriminant = q * factor * factor;
  return true;
}

/// The rotation of the face's plane within itself times its stretch; `tilt` is what remains of the remainder.
Eigen::Matrix2d ShearOf(const FaceMap& map, Eigen::Vector3d& tilt) {
  const Eigen::Vector3d normal = map.frame.col(0).cross(map.frame.col(1));
  const Eigen::Quaterniond q = QuaternionOf(map.remainder);
  double w = q.w(), along = q.vec().dot(normal);
  const double length = std::hypot(w, along);
  if (length < 1e-12) {  // half a turn across: no way to tell
    tilt = map.remainder;
    return map.stretch;
  }
  w /= length, along /= length;
  const Eigen::Vector3d within = along * normal;
  tilt = LogOf(q * Eigen::Quaterniond(w, -within[0], -within[1], -within[2]));
  const double cosine = w * w - along * along, sine = 2 * w * along;
  return (Eigen::Matrix2d() << cosine, -sine, sine, cosine).finished() * map.stretch;
}

Record RecordOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces, Eigen::Index f, const SegmentMaps& maps,
                const Eigen::Matrix3d& body, Stretch stretch) {
  const FaceMap& map = maps.faces[f];
  Record r{};
  Edges plain, second, generated;
  for (int k = 0; k < 2; ++k) {
    plain.col(k) = v.row(faces(f, k + 1)) - v.row(faces(f, 0));
    second.col(k) = u.row(faces(f, k + 1)) - u.row(faces(f, 0));
  }
  const auto applied = [&](const Eigen::Matrix2d& m) { return (map.frame * (m * (map.frame.transpose() * plain))).eval(); };
  if (map.degenerate) {
    // Straight from edge to edge, seen from the body.
    generated = body.transpose() * second - plain;
    r.straight = true;
  } else {
    SetTurns(map.turn, r.turn_axis, r.turn_angle);
    Eigen::Vector3d tilt = map.remainder;
    Eigen::Matrix2d n;
    const bool in_one = stretch == Stretch::kBalanced && !maps.differential && LogOf2(ShearOf(map, tilt), r.log_area, n, r.discriminant);
    if (!in_one) {
      tilt = map.remainder;
      LogOf2(map.stretch, r.log_area, n, r.discriminant);  // symmetric and positive: always real
    }
    SetTurns(tilt, r.tilt_axis, r.tilt_angle);
    r.straight = stretch == Stretch::kLinear;
    generated = applied(r.straight ? map.stretch - Eigen::Matrix2d::Identity() : n);
    r.growth = stretch == Stretch::kBalanced ? map.growth : 0.0;
    r.log_area -= 2 * r.growth;
  }
  std::copy(plain.data(), plain.data() + 6, r.plain.begin());
  std::copy(generated.data(), generated.data() + 6, r.generated.begin());
  return r;
}

KEYPOSE_INLINE Lanes BalancedLanes(Lanes t, double log_area) {
  // As BalancedTime.
  const double x = std::clamp(log_area, -1.0, 1.0);
  const Lanes one = Spread(1.0), u = t * (one - t);
  return t + u * Spread(x) *
                 (Spread(0.5) + Spread(x) * ((one - Spread(2.0) * t) / Spread(6.0) +
                                             Spread(x) * (one - Spread(6.0) * t + Spread(6.0) * t * t) / Spread(24.0)));
}

constexpr int kTerms = 18, kFewTerms = 8;
/// 1 / (2n)! and 1 / (2n+1)!: cosh and sinh(x) / x as series of x^2, which serve cosine and sine where x^2 is negative.
struct EvenSeries {
  constexpr EvenSeries() {
    double factorial = 1;
    for (int n = 0; n < kTerms; ++n) {
      cosh[n] = 1 / factorial;
      factorial *= 2 * n + 1;
      sinh[n] = 1 / factorial;
      factorial *= 2 * n + 2;
    }
  }
  double cosh[kTerms] = {}, sinh[kTerms] = {};
};
constexpr EvenSeries kSeries;

KEYPOSE_INLINE Lanes3 SpreadAxis(const std::array<double, 3>& axis) { return {Spread(axis[0]), Spread(axis[1]), Spread(axis[2])}; }

KEYPOSE_INLINE void EvaluateFace(const Record& r, bool balanced, const double* times, int stride, double* edges) {
  const Lanes3 turn_axis = SpreadAxis(r.turn_axis), tilt_axis = SpreadAxis(r.tilt_axis);
  const int terms = std::abs(r.discriminant) < 0.2 ? kFewTerms : kTerms;  // 0.2^8 / 16! is 1e-19
  for (int first = 0; first < stride; first += 4) {
    Lanes t;
    __builtin_memcpy(&t, times + first, sizeof t);
    Lanes plain = Spread(1.0), generated = t;
    if (!r.straight) {
      const Lanes tau = balanced ? BalancedLanes(t, r.log_area) : t, x = Spread(r.discriminant) * tau * tau;
      Lanes cosh_like = Spread(kSeries.cosh[terms - 1]), sinh_like = Spread(kSeries.sinh[terms - 1]);
      for (int n = terms - 2; n >= 0; --n) {
        cosh_like = cosh_like * x + Spread(kSeries.cosh[n]);
        sinh_like = sinh_like * x + Spread(kSeries.sinh[n]);
      }
      const Lanes scale = Exp(t * Spread(r.growth) + tau * Spread(0.5 * r.log_area));
      plain = scale * cosh_like;
      generated = scale * tau * sinh_like;
    }
    Lanes sine, cosine, tilt_sine, tilt_cosine;
    SinCos(t * Spread(r.turn_angle), sine, cosine);
    SinCos(t * Spread(r.tilt_angle), tilt_sine, tilt_cosine);
    for (int k = 0; k < 2; ++k) {
      const double *a = r.plain.data() + 3 * k, *b = r.generated.data() + 3 * k;
      Lanes3 e = {plain * Spread(a[0]) + generated * Spread(b[0]), plain * Spread(a[1]) + generated * Spread(b[1]),
                  plain * Spread(a[2]) + generated * Spread(b[2])};
      e = Turned(tilt_axis, tilt_sine, tilt_cosine, e);
      e = Turned(turn_axis, sine, cosine, e);
      __builtin_memcpy(edges + (3 * k + 0) * stride + first, &e.x, sizeof e.x);
      __builtin_memcpy(edges + (3 * k + 1) * stride + first, &e.y, sizeof e.y);
      __builtin_memcpy(edges + (3 * k + 2) * stride + first, &e.z, sizeof e.z);
    }
  }
}

void EvaluateBlock(const Record* records, std::int64_t count, bool balanced, const double* times, int stride, double* edges) {
  for (std::int64_t f = 0; f < count; ++f) EvaluateFace(records[f], balanced, times, stride, edges + f * 6 * stride);
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) void EvaluateBlockAvx2(const Record* records, std::int64_t count, bool balanced, const double* times,
                                                       int stride, double* edges) {
  for (std::int64_t f = 0; f < count; ++f) EvaluateFace(records[f], balanced, times, stride, edges + f * 6 * stride);
}
bool HasAvx2() {
  static const bool has = __builtin_cpu_supports("avx2");
  return has;
}
#endif

}  // namespace

PairPaths::PairPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces, const SegmentMaps& maps, Stretch stretch)
    : records_(maps.faces.size()), balanced_(stretch == Stretch::kBalanced) {
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  ParallelFor(
      static_cast<std::int64_t>(records_.size()), [&](std::int64_t f) { records_[f] = RecordOf(v, u, faces, f, maps, body, stretch); },
      512);
}

void PairPaths::Evaluate(const std::vector<double>& times, EdgeBatch& edges) const {
  std::vector<double> padded(edges.stride, 0.0);
  std::copy(times.begin(), times.end(), padded.begin());
  ParallelBlocks(static_cast<std::int64_t>(records_.size()), 256, [&](std::int64_t begin, std::int64_t end) {
#if defined(__x86_64__)
    if (HasAvx2()) return EvaluateBlockAvx2(&records_[begin], end - begin, balanced_, padded.data(), edges.stride, edges.Face(begin));
#endif
    EvaluateBlock(&records_[begin], end - begin, balanced_, padded.data(), edges.stride, edges.Face(begin));
  });
}

void PairPaths::EvaluateWith(const std::vector<Eigen::Matrix3d>& rotations, double t, int frame, EdgeBatch& edges) const {
  ParallelFor(
      static_cast<std::int64_t>(records_.size()),
      [&](std::int64_t f) {
        const Record& r = records_[f];
        double plain = 1, generated = t;
        if (!r.straight) {
          const double tau = balanced_ ? BalancedTime(t, r.log_area) : t, root = std::sqrt(std::max(0.0, r.discriminant)), x = tau * root;
          const double scale = std::exp(t * r.growth + tau * 0.5 * r.log_area);
          plain = scale * std::cosh(x);
          generated = scale * (root > 1e-8 ? std::sinh(x) / root : tau);
        }
        edges.Set(f, frame, rotations[f] * (plain * Edges::Map(r.plain.data()) + generated * Edges::Map(r.generated.data())));
      },
      512);
}

}  // namespace keypose::interpolation
