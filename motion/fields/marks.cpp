#include "motion/fields/marks.h"

#include <Eigen/SVD>
#include <algorithm>
#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

constexpr double kNoArea = 1e-6;    // doubled area over the longest edge squared
constexpr double kOneLine = 4e-4;   // of the largest moment: the second one of marks in one line
constexpr double kOnePlane = 1e-4;  // the third one of marks in one plane

/// Columns: the edges from corner 0, and the unit normal.
Eigen::Matrix3d FrameOf(const PointsX3& p, const FacesX3& faces, int f) {
  Eigen::Matrix3d frame;
  frame.col(0) = p.row(faces(f, 1)) - p.row(faces(f, 0));
  frame.col(1) = p.row(faces(f, 2)) - p.row(faces(f, 0));
  frame.col(2) = frame.col(0).cross(frame.col(1)).normalized();
  return frame;
}

/// Root mean square of target - scale * rotation * template, over the target's spread.
double ResidualOf(const PointsX3& from, const PointsX3& to, const Eigen::Matrix3d& rotation,
                  double scale) {
  const double spread = to.squaredNorm();
  return spread > 0 ? std::sqrt((to - scale * from * rotation.transpose()).squaredNorm() / spread)
                    : 0.0;
}

}  // namespace

Eigen::RowVector3d PositionOf(const MarkPlace& place, const PointsX3& points,
                              const FacesX3& faces) {
  Eigen::RowVector3d position = Eigen::RowVector3d::Zero();
  for (int k = 0; k < 3; ++k) position += place.barycentric[k] * points.row(faces(place.face, k));
  return position;
}

bool HasNoArea(const PointsX3& p, const FacesX3& faces, int f) {
  const Eigen::RowVector3d a = p.row(faces(f, 1)) - p.row(faces(f, 0)),
                           b = p.row(faces(f, 2)) - p.row(faces(f, 0));
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
  return !(a.cross(b).norm() > kNoArea * longest);
}

void RequireMarks(const std::vector<Mark>& marks, const PointsX3& reference,
                  const FacesX3& template_faces, const Mesh& target) {
  if (marks.empty())
    throw InputError(
        "transfer: there are no marks; pick 20 to 80 pairs, or let keypose landmarks suggest do "
        "it");
  const auto require = [](const Mark& mark, const MarkPlace& place, const PointsX3& points,
                          const FacesX3& faces, const std::string& mesh) {
    const std::string what = "transfer: mark '" + mark.name + "' is on triangle " +
                             std::to_string(place.face) + " of the " + mesh;
    if (place.face < 0 || place.face >= faces.rows())
      throw InputError(what + ", which has " + std::to_string(faces.rows()) +
                       "; it was picked on another mesh: pick it again");
    if (HasNoArea(points, faces, place.face))
      throw InputError(what +
                       ", which has no area, so that its turn is not defined; pick the mark "
                       "on a triangle beside it, or repair the mesh with keypose cleanup");
  };
  for (const Mark& mark : marks) {
    require(mark, mark.on_template, reference, template_faces, "template");
    require(mark, mark.on_target, target.points, target.faces, "target");
  }
}

TriangleMap MapOfTriangle(const PointsX3& from, const PointsX3& to, const FacesX3& faces,
                          int face) {
  const Eigen::Matrix3d map = FrameOf(to, faces, face) * FrameOf(from, faces, face).inverse();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(map, Eigen::ComputeFullU | Eigen::ComputeFullV);
  TriangleMap result;
  // The map keeps the orientation of its normal, so its polar factor is a rotation.
  result.rotation =
      Eigen::Quaterniond(Eigen::Matrix3d(svd.matrixU() * svd.matrixV().transpose())).normalized();
  if (result.rotation.w() < 0) result.rotation.coeffs() = -result.rotation.coeffs();
  const Eigen::Vector3d logs = svd.singularValues().array().log();
  result.log_stretch = svd.matrixV() * logs.asDiagonal() * svd.matrixV().transpose();
  return result;
}

MarkPose MarkMeter::Measure(const PointsX3& frame, const std::string& name) const {
  MarkPose pose;
  pose.positions.resize(std::ssize(marks_), 3);
  for (int k = 0; k < SizeOf(marks_); ++k) {
    const MarkPlace& place = marks_[k].on_template;
    if (HasNoArea(frame, faces_, place.face))
      throw InputError("transfer: the triangle of mark '" + marks_[k].name + "' has no area in " +
                       name + " of the template, so that its turn is not defined; pick the mark " +
                       "on another triangle");
    pose.positions.row(k) = PositionOf(place, frame, faces_);
    pose.maps.push_back(MapOfTriangle(reference_, frame, faces_, place.face));
  }
  return pose;
}

Alignment AlignMarks(const PointsX3& on_template, const PointsX3& on_target) {
  Alignment alignment;
  if (on_template.rows() < 3) return alignment;
  const PointsX3 from = on_template.rowwise() - on_template.colwise().mean(),
                 to = on_target.rowwise() - on_target.colwise().mean();
  const Eigen::Matrix3d moments = to.transpose() * from;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(moments, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d spread = svd.singularValues();
  if (!(spread[1] > kOneLine * spread[0]) || from.squaredNorm() == 0) return alignment;
  alignment.certain = true;
  const double side = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  const auto fit = [&](double sign, double& residual, double& scale) {
    const Eigen::Vector3d signs(1, 1, sign);
    const Eigen::Matrix3d rotation = svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose();
    scale = spread.dot(signs) / from.squaredNorm();
    residual = ResidualOf(from, to, rotation, scale);
    return rotation;
  };
  double mirrored_scale = 1;
  alignment.target_from_template = fit(side, alignment.residual, alignment.scale);
  fit(-side, alignment.mirrored, mirrored_scale);
  if (spread[2] < kOnePlane * spread[0]) alignment.mirrored = 1;  // as good as its mirror image
  const Eigen::Vector3d up = alignment.target_from_template.col(2);
  alignment.tilt = std::atan2(up.head<2>().norm(), up[2]);
  const Eigen::Matrix3d& r = alignment.target_from_template;
  alignment.heading = std::atan2(r(1, 0) - r(0, 1), r(0, 0) + r(1, 1));
  return alignment;
}

}  // namespace keypose::motion
