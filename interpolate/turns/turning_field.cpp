#include "interpolate/turns/turning_field.h"

#include <iterator>

#include "core/numbers/parallel.h"

namespace keypose::interpolation {

TurningField::TurningField(const SegmentMaps& maps, const PointsX3& a, const PointsX3& b)
    : body_turn_(maps.body_turn), vertices_(a.rows()) {
  const Eigen::Matrix3d back = ExpOf(body_turn_).transpose();
  ParallelFor(
      a.rows(),
      [&](std::int64_t i) {
        Vertex& vertex = vertices_[i];
        const Eigen::Vector3d turn = maps.vertex_turns.row(i),
                              end = QuaternionOf(-turn) * (back * b.row(i).transpose());
        vertex.angle = turn.norm();
        for (int c = 0; c < 3; ++c) {
          vertex.axis[c] = vertex.angle > 0 ? turn[c] / vertex.angle : 0.0;
          vertex.start[c] = a(i, c);
          vertex.rise[c] = end[c] - a(i, c);
        }
      },
      1024);
}

PointsX3 TurningField::At(double t) const {
  PointsX3 field(std::ssize(vertices_), 3);
  const Eigen::Matrix3d body = ExpOf(t * body_turn_);
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const Vertex& v = vertices_[i];
    const Eigen::Vector3d local = Eigen::Vector3d::Map(v.start) + t * Eigen::Vector3d::Map(v.rise);
    field.row(i) = body * (QuaternionOf(t * v.angle * Eigen::Vector3d::Map(v.axis)) * local);
  }
  return field;
}

}  // namespace keypose::interpolation
