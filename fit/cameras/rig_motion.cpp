#include "fit/cameras/rig_motion.h"

#include <algorithm>

#include "core/numbers/rotations.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct RigTuning {
  // Largest error of an inlier, of the picture's longer side.
  KEYPOSE_TUNED(double, kWithin, 0.012);
};

}  // namespace

int Sightings::Inliers(const Rigid3& camera_from_template, std::vector<int>* indices) const {
  int count = 0;
  const Eigen::Matrix3d turn = camera_from_template.rotation.toRotationMatrix();
  for (int i = 0; i < SizeOf(pixels); ++i) {
    const Eigen::Vector3d x = turn * places.row(i).transpose() + camera_from_template.translation;
    if (x.z() <= 0 || (camera.Project(x) - pixels[i]).squaredNorm() > within * within) continue;
    ++count;
    if (indices) indices->push_back(i);
  }
  return count;
}

std::vector<Sightings> SightingsOf(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                                   const std::vector<PreparedView>& views) {
  std::vector<Sightings> sightings(views.size());
  for (int v = 0; v < SizeOf(views); ++v) {
    Sightings& s = sightings[v];
    s.camera = views[v].camera();
    s.within = RigTuning::kWithin * std::max(s.camera.width, s.camera.height);
    const std::vector<FeatureMatch> matches = AllMatches(cameras[v]);
    s.places.resize(SizeOf(matches), 3);
    for (int i = 0; i < SizeOf(matches); ++i) {
      s.places.row(i) = PositionOf(matches[i].point, mesh.points);
      s.pixels.push_back(matches[i].pixel);
    }
  }
  return sightings;
}

int Assign(const std::vector<Sightings>& sightings, const std::vector<View>& rig,
           RigMotion& motion) {
  motion.rig_view.assign(sightings.size(), -1);
  motion.inliers.assign(sightings.size(), 0);
  int sum = 0;
  motion.agreeing = 0;
  for (int i = 0; i < SizeOf(sightings); ++i) {
    for (int j = 0; j < SizeOf(rig); ++j) {
      const int inliers =
          sightings[i].Inliers(Compose(rig[j].camera_from_world, motion.rig_from_template));
      if (inliers > motion.inliers[i]) {
        motion.inliers[i] = inliers;
        motion.rig_view[i] = j;
      }
    }
    if (motion.inliers[i] < kLeastOnRig) motion.rig_view[i] = -1;
    motion.agreeing += motion.rig_view[i] >= 0;
    sum += motion.inliers[i];
  }
  return sum;
}

Rigid3 Improved(const std::vector<Sightings>& sightings, const std::vector<View>& rig,
                const RigMotion& motion) {
  Rigid3 improved = motion.rig_from_template;
  for (int round = 0; round < 10; ++round) {
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < SizeOf(sightings); ++i) {
      if (motion.rig_view[i] < 0) continue;
      const Sightings& s = sightings[i];
      const Rigid3& camera = rig[motion.rig_view[i]].camera_from_world;
      std::vector<int> inliers;
      s.Inliers(Compose(camera, improved), &inliers);
      const Eigen::Matrix3d turn = camera.rotation.toRotationMatrix();
      for (const int k : inliers) {
        const Eigen::Vector3d y = improved * s.places.row(k).transpose(), x = camera * y;
        Eigen::Matrix<double, 2, 3> d;
        d << s.camera.fx / x.z(), 0, -s.camera.fx * x.x() / (x.z() * x.z()), 0, s.camera.fy / x.z(),
            -s.camera.fy * x.y() / (x.z() * x.z());
        Eigen::Matrix<double, 3, 6> move;
        move << 0, y.z(), -y.y(), 1, 0, 0, -y.z(), 0, y.x(), 0, 1, 0, y.y(), -y.x(), 0, 0, 0, 1;
        const Eigen::Matrix<double, 2, 6> j = d * turn * move;
        h += j.transpose() * j;
        g += j.transpose() * (s.camera.Project(x) - s.pixels[k]);
      }
    }
    h.diagonal().array() += 1e-9 * h.trace() + 1e-300;
    const Eigen::Matrix<double, 6, 1> step = -h.ldlt().solve(g);
    const Eigen::Quaterniond rotation = QuaternionOf(step.head<3>());
    improved = {(rotation * improved.rotation).normalized(),
                rotation * improved.translation + step.tail<3>()};
  }
  return improved;
}

}  // namespace keypose::fit
