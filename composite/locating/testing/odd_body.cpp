#include "composite/locating/testing/odd_body.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/numbers/rotations.h"
#include "core/pictures/fit_view.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite {
namespace {
constexpr double kDeg = std::numbers::pi / 180;

}  // namespace

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh mesh = a;
  const auto vertices = a.points.rows(), faces = a.faces.rows();
  mesh.points.conservativeResize(vertices + b.points.rows(), 3);
  mesh.points.bottomRows(b.points.rows()) = b.points;
  mesh.faces.conservativeResize(faces + b.faces.rows(), 3);
  mesh.faces.bottomRows(b.faces.rows()) = b.faces.array() + static_cast<int>(vertices);
  return mesh;
}

Mesh BallAt(double x, double y, double z, double radius) {
  Mesh ball = MakeIcosphere(3);
  ball.points = (radius * ball.points).rowwise() + Eigen::RowVector3d(x, y, z);
  return ball;
}

Mesh OddBody() {
  Mesh body = BallAt(0, 0, 0.1, 0.07);
  body = Joined(body, BallAt(0.09, 0.01, 0.13, 0.035));
  body = Joined(body, BallAt(0.02, -0.08, 0.05, 0.03));
  return Joined(body, BallAt(-0.03, 0.03, 0.19, 0.028));
}

Camera TestCamera() {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 900, camera.cx = 320, camera.cy = 240;
  return camera;
}

Placement LookingFrom(double azimuth_deg, double elevation_deg, double distance) {
  const double a = azimuth_deg * kDeg, e = elevation_deg * kDeg;
  const Eigen::Vector3d eye(distance * std::cos(e) * std::cos(a),
                            distance * std::cos(e) * std::sin(a), 0.1 + distance * std::sin(e));
  return {TestCamera(), LookAt(eye, {0.01, 0, 0.11})};
}

Placement Disturbed(const Placement& at, double degrees, double shift) {
  Placement moved = at;
  const Eigen::Quaterniond turn = QuaternionOf(Eigen::Vector3d(0.5, -0.7, 0.5) * degrees * kDeg);
  moved.camera_from_mesh.rotation = (turn * at.camera_from_mesh.rotation).normalized();
  moved.camera_from_mesh.translation += Eigen::Vector3d(shift, -shift, 2 * shift);
  return moved;
}

double TurnBetween(const Placement& a, const Placement& b) {
  return AngleOfDifference(
             RotationDifference(a.camera_from_mesh.rotation, b.camera_from_mesh.rotation)) /
         kDeg;
}

double ShiftBetween(const Placement& a, const Placement& b, const PointsX3& points) {
  double most = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    most = std::max(most, (a.Project(points.row(v)) - b.Project(points.row(v))).norm());
  return most;
}

Image8 GreyPicture(const Image8& matte) {
  Image8 picture(matte.width, matte.height, 3, 90);
  for (std::size_t i = 0; i < matte.data.size(); ++i)
    if (matte.data[i] > 127)
      for (int c = 0; c < 3; ++c) picture.data[3 * i + c] = 160;
  return picture;
}

}  // namespace keypose::composite
