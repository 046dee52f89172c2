#include "fit/testing/breathing_ball.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::fit {

using Eigen::Vector3d;

BreathingBall::BreathingBall(int cameras) : mesh(MakeIcosphere(3)), fine(MakeIcosphere(5)) {
  fine.colors.resize(fine.vertex_count(), 3);
  for (int v = 0; v < fine.vertex_count(); ++v)
    for (int c = 0; c < 3; ++c)
      fine.colors(v, c) = static_cast<std::uint8_t>(std::lround(
          127 + 100 * std::sin(9 * fine.points(v, c) + 5 * fine.points(v, (c + 1) % 3))));
  for (int i = 0; i < cameras; ++i) {
    const double angle = 2 * kPi * i / cameras;
    View view;
    view.name = "cam" + std::to_string(i + 1);
    view.camera_from_world =
        LookAt({6 * std::cos(angle), 6 * std::sin(angle), i % 2 ? 2.0 : -1.5}, Vector3d::Zero());
    view.camera.width = view.camera.height = kSize;
    view.camera.fx = view.camera.fy = 1.9 * kSize;
    view.camera.cx = view.camera.cy = 0.5 * kSize;
    views.push_back(view);
  }
}

PointsX3 BreathingBall::Truth(const PointsX3& sphere, int frame) const {
  PointsX3 moved = sphere;
  const double bulge = 0.08 * (1 + std::sin(0.4 * frame));
  for (Eigen::Index v = 0; v < moved.rows(); ++v) {
    const Vector3d from = Vector3d(sphere.row(v)) - Vector3d(1, 0, 0);
    moved.row(v) *= 1.06 + bulge * std::exp(-4 * from.squaredNorm());
  }
  return moved;
}

Image8 BreathingBall::Cutout(int view, int frame) const {
  Mesh shown = fine;
  shown.points = Truth(fine.points, frame);
  RenderOptions look;
  look.shading = 0;
  return RenderCutout(shown, RayScene(shown.points, shown.faces), views[view], look);
}

Image8 BreathingBall::Picture(int view, int frame) const {
  const Image8 cut = Cutout(view, frame);
  Image8 picture(kSize, kSize, 3, 30);
  for (std::size_t i = 0; i < cut.data.size() / 4; ++i)
    if (cut.data[4 * i + 3] > 127) std::copy_n(&cut.data[4 * i], 3, &picture.data[3 * i]);
  return picture;
}

Image8 BreathingBall::Mask(int view, int frame) const {
  const Image8 cut = Cutout(view, frame);
  Image8 mask(kSize, kSize, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    mask.data[i] = cut.data[4 * i + 3] > 127 ? 255 : 0;
  return mask;
}

std::vector<PreparedView> BreathingBall::Film(int frame) const {
  std::vector<PreparedView> prepared;
  for (int v = 0; v < SizeOf(views); ++v)
    prepared.push_back(PrepareView(views[v], v, Picture(v, frame), Mask(v, frame), 1, 2));
  return prepared;
}

FollowSource BreathingBall::Source() const {
  return {kFrames, [this](int) { return mesh.points; },
          [this](int first, int count) {
            std::vector<std::vector<PreparedView>> all;
            for (int f = first; f < first + count; ++f) all.push_back(Film(f));
            return all;
          }};
}

double BreathingBall::Error(const PointsX3& points, int frame) const {
  const RayScene truth(Truth(fine.points, frame), fine.faces);
  double sum = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    sum += std::sqrt(truth.ClosestPoint(points.row(v)).squared_distance);
  return sum / static_cast<double>(points.rows());
}

}  // namespace keypose::fit
