#include "views/placement/picture_pose.h"

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "core/values/size_of.h"

namespace keypose {
namespace {

constexpr int kTrials = 3000;
constexpr double kConfidence = 0.9999;

Eigen::Matrix3d Cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Derivative of the pixel by the point in the camera's frame, 2 x 3.
Eigen::Matrix<double, 2, 3> PixelByPoint(const Pinhole& camera, const Eigen::Vector3d& x) {
  Eigen::Matrix<double, 2, 3> d;
  d << camera.fx / x.z(), 0, -camera.fx * x.x() / (x.z() * x.z()), 0, camera.fy / x.z(),
      -camera.fy * x.y() / (x.z() * x.z());
  return d;
}

Rigid3 Moved(const Rigid3& pose, const Eigen::Matrix<double, 6, 1>& step) {
  const Eigen::Vector3d turn = step.head<3>();
  const double angle = turn.norm();
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  if (angle > 1e-15) rotation = Eigen::AngleAxisd(angle, turn / angle);
  return {(rotation * pose.rotation).normalized(), rotation * pose.translation + step.tail<3>()};
}

}  // namespace

Rigid3 RefinePose(const Pinhole& camera, const Rigid3& start, const PointsX3& positions,
                  const std::vector<Eigen::Vector2d>& pixels, const std::vector<double>& weights,
                  double within_px, int rounds) {
  Rigid3 pose = start;
  const double s2 = within_px * within_px;
  for (int round = 0; round < rounds; ++round) {
    Eigen::Matrix<double, 6, 6> h = Eigen::Matrix<double, 6, 6>::Zero();
    Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
    for (int i = 0; i < SizeOf(pixels); ++i) {
      const Eigen::Vector3d x = pose * positions.row(i).transpose();
      if (x.z() <= 0) continue;
      const Eigen::Vector2d r = camera.Project(x) - pixels[i];
      const double robust = s2 / (s2 + r.squaredNorm());
      Eigen::Matrix<double, 2, 6> j;
      const Eigen::Matrix<double, 2, 3> d = PixelByPoint(camera, x);
      j << -d * Cross(x), d;
      const double w = weights[i] * robust * robust;
      h += w * j.transpose() * j;
      g += w * j.transpose() * r;
    }
    const double damping = 1e-9 * h.trace() + 1e-300;
    h.diagonal().array() += damping;
    const Eigen::Matrix<double, 6, 1> step = -h.ldlt().solve(g);
    if (!step.allFinite()) break;
    pose = Moved(pose, step);
    if (step.norm() < 1e-12) break;
  }
  return pose;
}

PicturePose PlacePicture(const Pinhole& camera, const PointsX3& points,
                         const std::vector<FeatureMatch>& matches, double within_px, int least) {
  PicturePose result;
  if (SizeOf(matches) < std::max(4, least)) return result;
  std::vector<cv::Point3d> objects;
  std::vector<cv::Point2d> rays;
  for (const FeatureMatch& match : matches) {
    const Eigen::Vector3d x = PositionOf(match.point, points);
    const Eigen::Vector3d ray = camera.Ray(match.pixel.x(), match.pixel.y());
    objects.emplace_back(x.x(), x.y(), x.z());
    rays.emplace_back(ray.x(), ray.y());
  }
  cv::Mat turn, shift;
  std::vector<int> inliers;
  cv::theRNG().state = 1;
  const bool found = cv::solvePnPRansac(
      objects, rays, cv::Mat::eye(3, 3, CV_64F), cv::noArray(), turn, shift, false, kTrials,
      static_cast<float>(within_px / camera.fx), kConfidence, inliers, cv::SOLVEPNP_P3P);
  if (!found || SizeOf(inliers) < least) return result;
  cv::Mat matrix;
  cv::Rodrigues(turn, matrix);
  Eigen::Matrix3d rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation(r, c) = matrix.at<double>(r, c);
  Rigid3 pose{Eigen::Quaterniond(rotation),
              {shift.at<double>(0), shift.at<double>(1), shift.at<double>(2)}};
  PointsX3 positions(SizeOf(matches), 3);
  std::vector<Eigen::Vector2d> pixels;
  for (int i = 0; i < SizeOf(matches); ++i) {
    positions.row(i) = PositionOf(matches[i].point, points);
    pixels.push_back(matches[i].pixel);
  }
  const std::vector<double> weights(matches.size(), 1.0);
  pose = RefinePose(camera, pose, positions, pixels, weights, within_px / 2);
  double sum = 0;
  for (int i = 0; i < SizeOf(matches); ++i) {
    const Eigen::Vector3d x = pose * positions.row(i).transpose();
    if (x.z() <= 0) continue;
    const double error = (camera.Project(x) - pixels[i]).norm();
    if (error > within_px) continue;
    result.inliers.push_back(i);
    sum += error * error;
  }
  result.found = SizeOf(result.inliers) >= least;
  result.camera_from_world = pose;
  if (result.found) result.rms_px = std::sqrt(sum / static_cast<double>(result.inliers.size()));
  return result;
}

}  // namespace keypose
