#include "synth/worlds/posed_clay.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"

namespace keypose::synth {
namespace {

const Eigen::Vector3d kClayLamp(1.02, 1.0, 0.95), kClayRoom(0.97, 1.0, 1.05);
constexpr double kClayGlossPower = 22;

Mesh SurfaceAt(const PointsX3& points, const FacesX3& faces) {
  Mesh surface;
  surface.points = points;
  surface.faces = faces;
  return surface;
}

}  // namespace

PosedClay::PosedClay(const World& the_world, const Pose& pose)
    : PosedClay(the_world, pose(the_world.rest.points),
                pose(the_world.smooth.rows() ? the_world.smooth : the_world.rest.points)) {}

PosedClay::PosedClay(const World& the_world, const PointsX3& points, const PointsX3& smooth)
    : world(the_world),
      surface(SurfaceAt(points, world.rest.faces)),
      scene(surface.points, surface.faces),
      normals(VertexNormals(smooth, surface.faces)),  // the prints' tilt is added at each point
      lumps(surface.points.rows()) {
  ParallelFor(
      world.rest.points.rows(),
      [&](std::int64_t i) { lumps[i] = world.clay.LumpAt(world.rest.points.row(i)); }, 512);
}

Eigen::Vector3d PosedClay::Shade(const RayScene::Hit& hit, const Eigen::Vector3d& direction,
                                 const ClayLight& light) const {
  const int a = surface.faces(hit.face, 0), b = surface.faces(hit.face, 1),
            c = surface.faces(hit.face, 2);
  const double w = 1 - hit.u - hit.v;
  const auto mix = [&](const PointsX3& rows) -> Eigen::Vector3d {
    return (w * rows.row(a) + hit.u * rows.row(b) + hit.v * rows.row(c)).transpose();
  };
  const auto mix_light = [&](const std::vector<float>& values) {
    return w * values[a] + hit.u * values[b] + hit.v * values[c];
  };
  const Eigen::Vector3d rest = mix(world.rest.points);
  const int lump =
      lumps[a] == lumps[b] && lumps[b] == lumps[c] ? lumps[a] : world.clay.LumpAt(rest);
  const Eigen::Vector3d normal =
      (mix(normals).normalized() - PosedSlope(world.clay.RidgeSlope(rest, lump), a, b, c))
          .normalized();
  const double lamp = light.lamp_light * mix_light(*light.lamp),
               facing = std::max(0.0, normal.dot(light.to_lamp));
  const double room = light.room_light * (light.room ? mix_light(*light.room) : 1);
  const Eigen::Vector3d arrives = lamp * facing * kClayLamp + room * kClayRoom;
  const Eigen::Vector3d halfway = (light.to_lamp - direction).normalized();
  const double shine = world.clay.lumps[lump].crisp ? 6 : 1;
  const double gloss = light.gloss * shine * mix_light(*light.lamp) *
                       std::pow(std::max(0.0, normal.dot(halfway)), kClayGlossPower * shine);
  return world.clay.Paint(rest, lump).cwiseProduct(arrives) + gloss * kClayLamp;
}

/// Transfers a slope from the rest triangle to the posed one: the rise along corresponding edges
/// is equal.
Eigen::Vector3d PosedClay::PosedSlope(const Eigen::Vector3d& slope, int a, int b, int c) const {
  if (slope.isZero(0)) return slope;
  const auto edges = [&](const PointsX3& p) {
    Eigen::Matrix<double, 3, 2> e;
    e.col(0) = (p.row(b) - p.row(a)).transpose();
    e.col(1) = (p.row(c) - p.row(a)).transpose();
    return e;
  };
  const Eigen::Matrix<double, 3, 2> rest = edges(world.rest.points), posed = edges(surface.points);
  const Eigen::Matrix2d metric = posed.transpose() * posed;
  return posed * metric.inverse() * (rest.transpose() * slope);
}

}  // namespace keypose::synth
