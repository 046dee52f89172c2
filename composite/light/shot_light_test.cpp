#include "composite/light/shot_light.h"

#include <gtest/gtest.h>

#include "core/pictures/fit_view.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::shot_light_test {

double LampLight(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d lamp = Eigen::Vector3d(-0.6, -0.6, 0.5).normalized();
  return 0.4 + 0.8 * std::max(0.0, normal.dot(lamp));
}

/// A ball, filmed from the front in a lamp's light; its texture is 0.3.
struct LitBall {
  Mesh mesh = MakeIcosphere(4);
  RayScene scene{mesh.points, mesh.faces};
  View view{"", {160, 120, 150, 150, 80, 60}, LookAt({0, -4, 1}, {0, 0, 0})};
  ImageF filmed{160, 120, 3, 0.1f}, layer{160, 120, 4};

  LitBall() {
    const Rigid3 world_from_camera = view.camera_from_world.Inverse();
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const Eigen::Vector3d ray =
            world_from_camera.rotation * view.camera.Unproject({x + 0.5, y + 0.5});
        const RayScene::Hit hit = scene.Cast(world_from_camera.translation, ray);
        if (hit.face < 0) continue;
        const Eigen::Vector3d normal =
            (world_from_camera.translation + hit.distance * ray).normalized();
        for (int c = 0; c < 3; ++c) {
          layer.at(x, y)[c] = 0.3f;
          filmed.at(x, y)[c] = static_cast<float>(0.3 * LampLight(normal) * (c == 2 ? 0.9 : 1));
        }
        layer.at(x, y)[3] = 1;
      }
  }
};

TEST(Shading, GainsOfAFilmedFrameComeBack) {
  const LitBall ball;
  const ObservedGains observed = ObserveGains(ball.filmed, ball.layer, {}, ball.mesh.points,
                                              ball.mesh.faces, ball.scene, ball.view, 0.8);
  const ShotLight light = FitShotLight({observed}, ball.mesh.faces);
  const PointsX3 normals = VertexNormals(ball.mesh.points, ball.mesh.faces);
  const PointsX3 gains = GainsBetween(light, 0, 0, 0, normals);
  int seen = 0;
  for (Eigen::Index v = 0; v < gains.rows(); ++v) {
    if (observed.weights[v] < 0.4) continue;
    EXPECT_NEAR(gains(v, 0), LampLight(normals.row(v)), 0.06);
    EXPECT_NEAR(gains(v, 2), 0.9 * LampLight(normals.row(v)), 0.06);
    ++seen;
  }
  EXPECT_GT(seen, 400);
  EXPECT_GT(gains.minCoeff(), 0);
}

TEST(Shading, WithoutObservationsTheTextureStaysAsItIs) {
  const ShotLight light = FitShotLight({}, MakeIcosphere(1).faces);
  const PointsX3 normals = PointsX3::Random(5, 3);
  EXPECT_LT((GainsBetween(light, -1, -1, 0, normals) - PointsX3::Ones(5, 3)).norm(), 1e-12);
}

}  // namespace keypose::composite::shot_light_test
