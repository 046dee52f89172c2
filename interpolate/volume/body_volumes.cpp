#include "interpolate/volume/body_volumes.h"

#include <Eigen/Geometry>
#include <cmath>

#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

namespace {

constexpr double kVolumeTolerance = 1e-10;
constexpr int kVolumeRounds = 30;

}  // namespace

BodyPaths::BodyPaths(const PointsX3& v, const PointsX3& u, const Solid& solid,
                     const Eigen::Vector3d& turn)
    : body_(solid.body_of_point), points_(v.rows()), bodies_(solid.bodies) {
  start_ = Means(v);
  end_ = Means(u);
  whole_start_ = v.colwise().mean().transpose();
  whole_end_ = u.colwise().mean().transpose();
  turn_ = turn;
  rotation_ = ExpOf(turn_);
}

void BodyPaths::Apply(double t, PointsX3& points) const {
  PointsX3 shift = Means(points);
  const Eigen::Matrix3d turn = ExpOf(t * turn_);
  for (Eigen::Index b = 0; b < shift.rows(); ++b) {
    const Eigen::Vector3d d0 = start_.row(b).transpose() - whole_start_,
                          d1 = end_.row(b).transpose() - whole_end_;
    const Eigen::Vector3d goal = (1 - t) * whole_start_ + t * whole_end_ +
                                 turn * ((1 - t) * d0 + t * (rotation_.transpose() * d1));
    shift.row(b) = goal.transpose() - shift.row(b);
  }
  for (Eigen::Index i = 0; i < points_; ++i)
    if (body_[i] >= 0) points.row(i) += shift.row(body_[i]);
}

PointsX3 BodyPaths::Means(const PointsX3& points) const {
  PointsX3 sum = PointsX3::Zero(bodies_, 3);
  Eigen::VectorXd count = Eigen::VectorXd::Zero(sum.rows());
  for (Eigen::Index i = 0; i < points_; ++i)
    if (body_[i] >= 0) {
      sum.row(body_[i]) += points.row(i);
      count[body_[i]] += 1;
    }
  return count.cwiseInverse().asDiagonal() * sum;
}

Eigen::VectorXd BodyVolumes(const PointsX3& p, const FacesX3& faces, const Solid& solid) {
  Eigen::VectorXd volumes = Eigen::VectorXd::Zero(solid.bodies);
  std::vector<int> about(solid.bodies, -1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    int& origin = about[solid.body_of_face[f]];
    if (origin < 0) origin = faces(f, 0);
    const Eigen::Vector3d a = p.row(faces(f, 0)) - p.row(origin),
                          b = p.row(faces(f, 1)) - p.row(origin),
                          c = p.row(faces(f, 2)) - p.row(origin);
    volumes[solid.body_of_face[f]] += a.dot(b.cross(c)) / 6;
  }
  return volumes;
}

double Cubic::Reach(double goal) const {
  double x = 0;
  for (int round = 0; round < kVolumeRounds; ++round) {
    const double slope = c[1] + x * (2 * c[2] + x * 3 * c[3]), gap = goal - At(x);
    if (!(slope > 0)) return 0;
    x += gap / slope;
    if (std::abs(gap) <= 1e-15 * goal) break;
  }
  return std::abs(goal - At(x)) <= kVolumeTolerance * goal ? x : 0;
}

std::vector<Cubic> VolumesAlong(const PointsX3& p, const PointsX3& z, const FacesX3& faces,
                                const Solid& solid) {
  std::vector<Cubic> volumes(solid.bodies);
  std::vector<int> about(solid.bodies, -1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    int& origin = about[solid.body_of_face[f]];
    if (origin < 0) origin = faces(f, 0);
    std::array<Eigen::Vector3d, 3> a, d;
    for (int k = 0; k < 3; ++k) {
      a[k] = p.row(faces(f, k)) - p.row(origin);
      d[k] = z.row(faces(f, k)) - z.row(origin);
    }
    const Eigen::Vector3d aa = a[1].cross(a[2]), ad = a[1].cross(d[2]) + d[1].cross(a[2]),
                          dd = d[1].cross(d[2]);
    std::array<double, 4>& c = volumes[solid.body_of_face[f]].c;
    c[0] += a[0].dot(aa) / 6;
    c[1] += (d[0].dot(aa) + a[0].dot(ad)) / 6;
    c[2] += (d[0].dot(ad) + a[0].dot(dd)) / 6;
    c[3] += d[0].dot(dd) / 6;
  }
  return volumes;
}

}  // namespace keypose::interpolation
