// Cameras turned against their calibration, against the turns that were made.
#include "motion/tracking/camera_turns.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/rotations.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"

namespace keypose::motion::camera_turns_test {

constexpr int kSide = 320;

View CameraAt(double azimuth, double height) {
  View view;
  view.camera = {kSide, kSide, 1.45 * kSide, 1.45 * kSide, kSide / 2.0, kSide / 2.0, 0, 0, 0, 0};
  view.camera_from_world =
      LookAt({4 * std::cos(azimuth), 4 * std::sin(azimuth), height}, {0, 0, 0.9});
  return view;
}

/// Masks of the template as the true cameras see it, with the places of others.
std::vector<Silhouette> Filmed(const std::vector<View>& truth, const std::vector<View>& told,
                               const BodyShape& shape, const BodyPose& pose) {
  const Mesh mesh{BodyPoints(SurfaceOf(shape), Posed(pose, shape)), BodyFaces(), {}, {}, {}, {}};
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Silhouette> silhouettes;
  for (int v = 0; v < static_cast<int>(truth.size()); ++v) {
    const Raster raster = Rasterize(mesh, scene, truth[v]);
    Image8 mask(kSide, kSide, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i)
      mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    const SilhouetteCamera camera(told[v], 1);
    silhouettes.push_back(MakeSilhouette(camera, v, camera.Reduced(mask), 220));
  }
  return silhouettes;
}

BodyPose Walking(int frame) {
  BodyPose pose;
  pose.q.head<3>() =
      Eigen::Vector3d(0.3 * std::sin(0.9 * frame), 0.2 * std::cos(0.7 * frame), 0.93);
  for (const int shoulder : {kShoulderL, kShoulderR})
    pose.q[Joints()[shoulder].first_dof + 1] =
        (shoulder == kShoulderL ? 1 : -1) * (0.6 + 0.3 * std::sin(1.3 * frame));
  for (const int elbow : {kElbowL, kElbowR}) pose.q[Joints()[elbow].first_dof] = 0.5;
  for (const int hip : {kHipL, kHipR})
    pose.q[Joints()[hip].first_dof] = (hip == kHipL ? 0.25 : -0.25) * std::cos(frame);
  return pose;
}

std::vector<TurnFrame> Frames(const std::vector<View>& truth, const std::vector<View>& told,
                              const BodyShape& shape) {
  std::vector<TurnFrame> frames;
  for (int f = 0; f < 8; ++f)
    frames.push_back({Filmed(truth, told, shape, Walking(f)), Walking(f)});
  return frames;
}

std::vector<View> Four() {
  std::vector<View> views;
  for (int i = 0; i < 4; ++i) views.push_back(CameraAt(kPi / 2 * i + 0.2, 0.8 + 0.6 * (i % 3)));
  return views;
}

TEST(FindCameraTurns, ACameraThatWasTouchedIsFoundAndTurnedBack) {
  const BodyShape shape = AverageShape(1.75);
  const std::vector<View> told = Four();
  std::vector<View> truth = told;
  const Eigen::Vector3d turn(0.004, -0.003, 0.015);  // 0.9 degrees: 7 pixels
  truth[1].camera_from_world = TurnedBy(told[1].camera_from_world, turn);
  const CameraTurns found = FindCameraTurns(Frames(truth, told, shape), shape);
  // In four views a part of a turn can be a move of the body as well.
  EXPECT_LT((found.turns[1] - turn).norm(), 0.5 * turn.norm());
  EXPECT_NEAR(found.shift_px[1], 7, 2);
  for (const int other : {0, 2, 3}) EXPECT_LT(found.shift_px[other], 2) << other;
  EXPECT_LT(found.after, 0.5 * found.before);
}

TEST(FindCameraTurns, CamerasThatStoodStillStay) {
  const BodyShape shape = AverageShape(1.75);
  const CameraTurns found = FindCameraTurns(Frames(Four(), Four(), shape), shape);
  for (const double shift : found.shift_px) EXPECT_LT(shift, 0.5);
}

TEST(TurnedBy, TheCentreStaysAndTheAxisTurns) {
  const Rigid3 camera = CameraAt(0.7, 1.2).camera_from_world;
  const Eigen::Vector3d turn(0, 0, 0.2);
  const Rigid3 turned = TurnedBy(camera, turn);
  EXPECT_LT((turned.Inverse().translation - camera.Inverse().translation).norm(), 1e-12);
  const Eigen::Vector3d axis = camera.rotation.conjugate() * Eigen::Vector3d::UnitZ(),
                        now = turned.rotation.conjugate() * Eigen::Vector3d::UnitZ();
  EXPECT_LT((QuaternionOf(turn) * axis - now).norm(), 1e-12);
}

}  // namespace keypose::motion::camera_turns_test
