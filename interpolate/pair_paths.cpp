#include "interpolate/pair_paths.h"

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

Record RecordOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces, Eigen::Index f, const FaceMap& map, const Eigen::Matrix3d& body,
                Stretch stretch) {
  Record r{};
  SetTurns(map.turn, r.turn_axis, r.turn_angle);
  SetTurns(map.remainder, r.remainder_axis, r.remainder_angle);
  Eigen::Matrix<double, 3, 2> plain, projected, second;
  for (int k = 0; k < 2; ++k) {
    plain.col(k) = v.row(faces(f, k + 1)) - v.row(faces(f, 0));
    second.col(k) = u.row(faces(f, k + 1)) - u.row(faces(f, 0));
  }
  if (map.degenerate) {
    // Straight from edge to edge, seen from the body.
    r.turn_angle = r.remainder_angle = 0;
    projected = body.transpose() * second - plain;
    r.linear_low = r.linear_ratio = 1;
    r.straight = true;
  } else {
    const Eigen::Matrix2d& s = map.stretch;
    const double mean = 0.5 * (s(0, 0) + s(1, 1)), d = 0.5 * (s(0, 0) - s(1, 1)), radius = std::hypot(d, s(0, 1));
    const double high = mean + radius, low = (s(0, 0) * s(1, 1) - s(0, 1) * s(0, 1)) / high;
    // Projector on the eigenvector of the larger stretch; any will do where both are equal.
    Eigen::Matrix2d p = 0.5 * Eigen::Matrix2d::Identity();
    if (radius > 1e-300) p += 0.5 / radius * (Eigen::Matrix2d() << d, s(0, 1), s(0, 1), -d).finished();
    projected = map.frame * (p * (map.frame.transpose() * plain));
    r.growth = stretch == Stretch::kBalanced ? map.growth : 0.0;
    r.log_high = std::log(high) - r.growth;
    r.log_low = std::log(low) - r.growth;
    r.log_area = r.log_high + r.log_low;
    r.linear_low = low;
    r.linear_ratio = high - low;
    r.straight = stretch == Stretch::kLinear;
  }
  std::copy(plain.data(), plain.data() + 6, r.plain.begin());
  std::copy(projected.data(), projected.data() + 6, r.projected.begin());
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

KEYPOSE_INLINE void EvaluateFace(const Record& r, bool balanced, const double* times, int stride, double* edges) {
  for (int first = 0; first < stride; first += 4) {
    Lanes t;
    __builtin_memcpy(&t, times + first, sizeof t);
    Lanes shrink, ratio;
    if (r.straight) {
      shrink = Spread(1.0) - t + t * Spread(r.linear_low);
      ratio = t * Spread(r.linear_ratio);
    } else {
      const Lanes grown = t * Spread(r.growth), tau = balanced ? BalancedLanes(t, r.log_area) : t;
      shrink = Exp(grown + tau * Spread(r.log_low));
      ratio = Exp(grown + tau * Spread(r.log_high)) - shrink;
    }
    Lanes sine, cosine, sine_left, cosine_left;
    SinCos(t * Spread(r.turn_angle), sine, cosine);
    SinCos(t * Spread(r.remainder_angle), sine_left, cosine_left);
    for (int k = 0; k < 2; ++k) {
      const double *a = r.plain.data() + 3 * k, *b = r.projected.data() + 3 * k;
      Lanes3 e = {shrink * Spread(a[0]) + ratio * Spread(b[0]), shrink * Spread(a[1]) + ratio * Spread(b[1]),
                  shrink * Spread(a[2]) + ratio * Spread(b[2])};
      e = Turned(r.remainder_axis.data(), sine_left, cosine_left, e);
      e = Turned(r.turn_axis.data(), sine, cosine, e);
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
      static_cast<std::int64_t>(records_.size()),
      [&](std::int64_t f) { records_[f] = RecordOf(v, u, faces, f, maps.faces[f], body, stretch); }, 512);
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
        double shrink = 1 - t + t * r.linear_low, ratio = t * r.linear_ratio;
        if (!r.straight) {
          const double tau = balanced_ ? BalancedTime(t, r.log_area) : t;
          shrink = std::exp(t * r.growth + tau * r.log_low);
          ratio = std::exp(t * r.growth + tau * r.log_high) - shrink;
        }
        using Edges = Eigen::Matrix<double, 3, 2>;
        edges.Set(f, frame, rotations[f] * (shrink * Edges::Map(r.plain.data()) + ratio * Edges::Map(r.projected.data())));
      },
      512);
}

}  // namespace keypose::interpolation
