#include "reconstruct/testing/known_scenes.h"

#include <Eigen/Geometry>
#include <cmath>

namespace keypose::reconstruct::testing {
namespace {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846;

}  // namespace

Scene RingScene(const std::vector<std::pair<double, int>>& rings, double arc, double roll,
                double noise, std::mt19937& random) {
  Scene scene;
  std::normal_distribution<double> gauss(0, 1);
  Camera camera;
  camera.width = 640, camera.height = 480, camera.fx = camera.fy = 900, camera.cx = 320,
  camera.cy = 240;
  for (const auto& [elevation, count] : rings)
    for (int i = 0; i < count; ++i) {
      const double azimuth = arc * i / count - kPi / 2;
      const Vector3d target(0, 0, 0.5);
      Vector3d center =
          target + 4 * Vector3d(std::cos(azimuth) * std::cos(elevation),
                                std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
      center += noise * Vector3d(gauss(random), gauss(random), gauss(random));
      const Vector3d forward = (target - center).normalized(),
                     right = forward.cross(Vector3d::UnitZ()).normalized();
      Eigen::Matrix3d rotation;
      rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
      rotation = Eigen::AngleAxisd(roll, Vector3d::UnitZ()).toRotationMatrix() * rotation;
      View view;
      view.name = "v" + std::to_string(1000 + scene.views.size());
      view.camera = camera;
      view.camera_from_world.rotation = Eigen::Quaterniond(rotation);
      view.camera_from_world.translation = -(rotation * center);
      scene.views.push_back(view);
    }
  for (int p = 0; p < 400; ++p) {
    SparsePoint point;
    Vector3d direction(gauss(random), gauss(random), gauss(random));
    point.position =
        Vector3d(0, 0, 0.5) + direction.normalized().cwiseProduct(Vector3d(0.4, 0.3, 0.5));
    point.color << 200, 100, 50;
    scene.points.push_back(point);
  }
  return scene;
}

View BallCamera(int k, int count, double height) {
  const double a = 2 * kPi * k / count;
  const Vector3d center(6 * std::cos(a), 6 * std::sin(a), height),
      z = -center.normalized(), x = z.cross(Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d r;
  r << x.transpose(), z.cross(x).transpose(), z.transpose();
  View view;
  view.name = std::to_string(100 + k);
  view.camera = {320, 240, 700, 700, 160, 120};
  view.camera_from_world = {Eigen::Quaterniond(r), -(r * center)};
  return view;
}

Scene PointsOnBall(const std::vector<View>& views, int count, double noise) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal(0, noise);
  Scene scene;
  scene.views = views;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - 2 * (i + 0.5) / count, a = 2.399963 * i, r = std::sqrt(1 - z * z);
    const Vector3d on(r * std::cos(a), r * std::sin(a), z);
    SparsePoint point;
    point.position = on + Vector3d(normal(random), normal(random), normal(random));
    point.color.setConstant(0);
    for (std::size_t v = 0; v < scene.views.size(); ++v)
      if (on.dot((scene.views[v].Center() - on).normalized()) > 0.6)
        point.views.push_back(static_cast<int>(v));
    if (point.views.size() >= 2) scene.points.push_back(point);
  }
  return scene;
}

View LookFrom(const Vector3d& eye, const Camera& camera, const std::string& name) {
  const Vector3d z = -eye.normalized(), x = z.cross(Vector3d::UnitZ()).normalized(), y = z.cross(x);
  Eigen::Matrix3d rotation;
  rotation << x.transpose(), y.transpose(), z.transpose();
  View view;
  view.name = name;
  view.camera = camera;
  view.camera_from_world.rotation = rotation;
  view.camera_from_world.translation = -(view.camera_from_world.rotation * eye);
  return view;
}

SparsePoint PointAt(const Vector3d& x) {
  SparsePoint point;
  point.position = x;
  point.color.setZero();
  return point;
}

}  // namespace keypose::reconstruct::testing
