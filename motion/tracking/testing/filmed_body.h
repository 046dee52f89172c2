// A body as cameras around it film it.
#pragma once

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/angles.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "motion/body/body_pose.h"
#include "motion/body/body_surface.h"
#include "motion/body/body_template.h"
#include "motion/tracking/mask_silhouette.h"

namespace keypose::motion {

constexpr int kSide = 320;

inline View CameraAt(double azimuth, double height, int index) {
  View view;
  view.name = "cam" + std::to_string(index);
  view.camera = {kSide, kSide, 1.45 * kSide, 1.45 * kSide, kSide / 2.0, kSide / 2.0, -0.02, 0.01,
                 0,     0};
  view.camera_from_world =
      LookAt({4 * std::cos(azimuth), 4 * std::sin(azimuth), height}, {0, 0, 0.9});
  return view;
}

inline std::vector<View> Ring(int cameras) {
  std::vector<View> views;
  for (int i = 0; i < cameras; ++i)
    views.push_back(CameraAt(2 * kPi * i / cameras + 0.1, 0.8 + 0.7 * (i % 3), i));
  return views;
}

// Masks of the template itself, by ray casting: another way to draw it than the tracker's own.
inline std::vector<Silhouette> Filmed(const std::vector<View>& views, const BodyShape& shape,
                                      const BodyPose& pose) {
  const Mesh mesh{BodyPoints(SurfaceOf(shape), Posed(pose, shape)), BodyFaces(), {}, {}, {}, {}};
  const RayScene scene(mesh.points, mesh.faces);
  std::vector<Silhouette> silhouettes;
  for (int v = 0; v < static_cast<int>(views.size()); ++v) {
    const Raster raster = Rasterize(mesh, scene, views[v]);
    Image8 mask(kSide, kSide, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i)
      mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
    const SilhouetteCamera camera(views[v], 1);
    silhouettes.push_back(MakeSilhouette(camera, v, camera.Reduced(mask), 220));
  }
  return silhouettes;
}

inline BodyPose Standing() {
  BodyPose pose;
  pose.q.head<3>() = Eigen::Vector3d(0.05, -0.03, 0.93);
  for (const int shoulder : {kShoulderL, kShoulderR})
    pose.q[Joints()[shoulder].first_dof + 1] = shoulder == kShoulderL ? 0.6 : -0.6;
  for (const int elbow : {kElbowL, kElbowR}) pose.q[Joints()[elbow].first_dof] = 0.5;
  for (const int hip : {kHipL, kHipR})
    pose.q[Joints()[hip].first_dof + 1] = hip == kHipL ? -0.2 : 0.2;
  for (const int knee : {kKneeL, kKneeR}) pose.q[Joints()[knee].first_dof] = 0.2;
  return pose;
}

inline double WorstJoint(const BodyPose& a, const BodyPose& b, const BodyShape& shape) {
  const PosedBody x = Posed(a, shape), y = Posed(b, shape);
  double worst = 0;
  for (int j = 0; j < kJoints; ++j) worst = std::max(worst, (x.position[j] - y.position[j]).norm());
  return worst;
}

}  // namespace keypose::motion
