#include "interpolate/turning_field.h"

#include "core/parallel.h"
#include "interpolate/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation {

namespace {

KEYPOSE_INLINE Lanes Loaded(const double* at) {
  Lanes x;
  __builtin_memcpy(&x, at, sizeof x);
  return x;
}

KEYPOSE_INLINE Lanes3 Loaded(const double at[3][4]) { return {Loaded(at[0]), Loaded(at[1]), Loaded(at[2])}; }

}  // namespace

TurningField::TurningField(const SegmentMaps& maps, const PointsX3& a, const PointsX3& b)
    : count_(a.rows()), body_turn_(maps.body_turn), blocks_((a.rows() + 3) / 4, Block{}) {
  const Eigen::Matrix3d back = ExpOf(body_turn_).transpose();
  ParallelFor(
      count_,
      [&](std::int64_t i) {
        Block& block = blocks_[i / 4];
        const Eigen::Vector3d turn = maps.vertex_turns.row(i), end = QuaternionOf(-turn) * (back * b.row(i).transpose());
        const double angle = turn.norm();
        block.angle[i % 4] = angle;
        for (int c = 0; c < 3; ++c) {
          block.axis[c][i % 4] = angle > 0 ? turn[c] / angle : 0.0;
          block.start[c][i % 4] = a(i, c);
          block.rise[c][i % 4] = end[c] - a(i, c);
        }
      },
      1024);
}

PointsX3 TurningField::At(double t) const {
  PointsX3 field(count_, 3);
  const Eigen::Matrix3d body = ExpOf(t * body_turn_);
  const Lanes time = Spread(t);
  for (std::size_t k = 0; k < blocks_.size(); ++k) {
    const Block& block = blocks_[k];
    Lanes sine, cosine;
    SinCos(time * Loaded(block.angle), sine, cosine);
    const Lanes3 start = Loaded(block.start), rise = Loaded(block.rise);
    const Lanes3 v = Turned(Loaded(block.axis), sine, cosine, {start.x + time * rise.x, start.y + time * rise.y, start.z + time * rise.z});
    const Eigen::Index first = 4 * static_cast<Eigen::Index>(k);
    for (Eigen::Index i = first; i < std::min(first + 4, count_); ++i) {
      const Eigen::Vector3d local(v.x[i - first], v.y[i - first], v.z[i - first]);
      field.row(i) = body * local;
    }
  }
  return field;
}

}  // namespace keypose::interpolation
