#include "motion/testing/filmed_ball.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/render.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

/// Broad waves of colour, so that a picture shows where it was taken from.
Vector3d Paint(const Vector3d& x) {
  return {0.5 + 0.35 * std::sin(5 * x.x() + 1), 0.45 + 0.3 * std::sin(6 * x.y() + 2 * x.z()),
          0.4 + 0.3 * std::cos(4 * x.z() - 3 * x.x())};
}

View RingView(double azimuth, double height, int size_px) {
  View view;
  const double distance = 6;
  view.camera_from_world = LookAt(
      {distance * std::cos(azimuth), distance * std::sin(azimuth), height}, Vector3d::Zero());
  Camera& c = view.camera;
  c.width = c.height = size_px;
  c.fx = c.fy = 1.9 * size_px, c.cx = c.cy = 0.5 * size_px;
  c.k1 = -0.02;
  return view;
}

Eigen::Matrix3d TurnOf(int frame) {
  return Eigen::AngleAxisd(0.15 * frame, Vector3d::UnitZ()).toRotationMatrix();
}

PointsX3 Moved(const PointsX3& points, int frame) {
  PointsX3 moved = points * TurnOf(frame).transpose();
  moved.col(0).array() += 0.02 * frame;
  return moved;
}

}  // namespace

void GiveUvs(Mesh* mesh) {
  const int faces = mesh->face_count();
  const int side = static_cast<int>(std::ceil(std::sqrt(faces)));
  mesh->uvs.resize(3 * static_cast<Eigen::Index>(faces), 2);
  mesh->uv_faces.resize(faces, 3);
  for (int f = 0; f < faces; ++f) {
    const double x = f % side, y = f / side, margin = 0.1;
    mesh->uvs.row(3 * f) << x + margin, y + margin;
    mesh->uvs.row(3 * f + 1) << x + 1 - margin, y + margin;
    mesh->uvs.row(3 * f + 2) << x + margin, y + 1 - margin;
    mesh->uv_faces.row(f) << 3 * f, 3 * f + 1, 3 * f + 2;
  }
  mesh->uvs /= side;
}

BallWorld::BallWorld(int cameras, int size_px) : painted(MakeIcosphere(5)), mesh(MakeIcosphere(4)) {
  painted.colors.resize(painted.vertex_count(), 3);
  for (int v = 0; v < painted.vertex_count(); ++v)
    for (int c = 0; c < 3; ++c)
      painted.colors(v, c) = static_cast<std::uint8_t>(
          std::lround(255 * std::clamp(Paint(painted.points.row(v))[c], 0.0, 1.0)));
  GiveUvs(&mesh);
  for (int i = 0; i < cameras; ++i) {
    views.push_back(RingView(2 * kPi * i / cameras, i % 2 ? 1.5 : -0.8, size_px));
    views.back().name = "cam" + std::to_string(i + 1);
  }
  held_out = RingView(2 * kPi * 0.5 / cameras, 0.5, size_px);
}

PointsX3 BallWorld::Points(int frame) const { return Moved(mesh.points, frame); }

Image8 BallWorld::Picture(const View& view, int frame, double gain) const {
  Mesh shown = painted;
  shown.points = Moved(painted.points, frame);
  RenderOptions look;
  look.shading = 0;
  const Image8 cut = RenderCutout(shown, RayScene(shown.points, shown.faces), view, look);
  Image8 picture(cut.width, cut.height, 3);
  for (std::size_t i = 0; i < cut.data.size() / 4; ++i) {
    const double alpha = cut.data[4 * i + 3] / 255.0;
    for (int c = 0; c < 3; ++c) {
      const double mixed = alpha * cut.data[4 * i + c] / 255.0 + (1 - alpha) * background[c];
      picture.data[3 * i + c] = static_cast<std::uint8_t>(
          std::lround(255 * SrgbFromLinear(std::min(1.0, gain * LinearFromSrgb(mixed)))));
    }
  }
  return picture;
}

Image8 BallWorld::Mask(const View& view, int frame) const {
  const PointsX3 points = Moved(painted.points, frame);
  const Mesh shown{points, painted.faces, {}, {}, {}, {}};
  const Raster raster = Rasterize(shown, RayScene(points, painted.faces), view);
  Image8 mask(view.camera.width, view.camera.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
  return mask;
}

}  // namespace keypose::motion
