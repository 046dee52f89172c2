#include "motion/root/root_path.h"

#include <cmath>
#include <limits>

#include "core/numbers/kd_tree.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

constexpr double kUpright = 30 * kDegree;
constexpr double kSameHeading = 20 * kDegree;
/// Heights' ratio beyond which it says more about the poses than about the legs.
constexpr double kMostUnlike = 3;

}  // namespace

Eigen::Matrix3d DirectionsOf(const Alignment& alignment) {
  if (!alignment.certain) return Eigen::Matrix3d::Identity();
  if (alignment.tilt > kUpright) return alignment.target_from_template;
  if (std::abs(alignment.heading) < kSameHeading) return Eigen::Matrix3d::Identity();
  return Eigen::AngleAxisd(alignment.heading, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

RootPath::RootPath(const PointsX3& on_template, const PointsX3& on_target, double template_ground,
                   double target_ground, std::vector<int> root, double overall_scale,
                   const Eigen::Matrix3d& target_from_template, const RootPathOptions& options)
    : root_(std::move(root)),
      turn_(target_from_template),
      template_root_(RootOf(on_template)),
      target_root_(RootOf(on_target)) {
  const double from = template_root_[2] - template_ground, to = target_root_[2] - target_ground;
  const double legs = from > 0 ? to / from : 0;
  const bool tells = legs > overall_scale / kMostUnlike && legs < overall_scale * kMostUnlike;
  scale_ = tells ? legs : overall_scale;
  if (options.scale > 0) scale_ = options.scale;
}

Eigen::RowVector3d RootPath::RootOf(const PointsX3& marks) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int k : root_) sum += marks.row(k);
  return sum / static_cast<double>(root_.size());
}

Eigen::RowVector3d RootPath::At(const PointsX3& on_template) const {
  return target_root_ + scale_ * (RootOf(on_template) - template_root_) * turn_.transpose();
}

JoinedParts::JoinedParts(const PoissonSystem& system, const PointsX3& rest, int main_vertex)
    : parts_(system.parts()) {
  const int main = parts_[main_vertex];
  if (system.part_count() < 2) return;
  std::vector<int> in_main, sizes(system.part_count(), 0);
  PointsX3 centres = PointsX3::Zero(system.part_count(), 3);
  for (int i = 0; i < SizeOf(parts_); ++i) {
    if (parts_[i] == main) in_main.push_back(i);
    centres.row(parts_[i]) += rest.row(i);
    ++sizes[parts_[i]];
  }
  PointsX3 places(std::ssize(in_main), 3);
  for (int k = 0; k < SizeOf(in_main); ++k) places.row(k) = rest.row(in_main[k]);
  const KdTree tree(places);
  std::vector<double> nearest(system.part_count(), std::numeric_limits<double>::infinity());
  std::vector<int> carrier(system.part_count(), main_vertex);
  for (int i = 0; i < SizeOf(parts_); ++i) {
    if (parts_[i] == main) continue;
    const auto found = tree.Nearest(rest.row(i).transpose());
    if (found.squared_distance >= nearest[parts_[i]]) continue;
    nearest[parts_[i]] = found.squared_distance;
    carrier[parts_[i]] = in_main[found.index];
  }
  for (int part = 0; part < system.part_count(); ++part)
    if (part != main)
      riders_.push_back({part, carrier[part],
                         (centres.row(part) / sizes[part] - rest.row(carrier[part])).transpose()});
}

void JoinedParts::Join(const FrameSolver& solver, const FrameFields& frame, PointsX3& pose) const {
  if (riders_.empty()) return;
  PointsX3 shift = PointsX3::Zero(std::ssize(riders_) + 1, 3);
  for (const Rider& rider : riders_)
    shift.row(rider.part) =
        pose.row(rider.carrier) +
        (solver.RotationAt(rider.carrier, frame) * rider.from_carrier).transpose();
  for (int i = 0; i < SizeOf(parts_); ++i) pose.row(i) += shift.row(parts_[i]);
}

}  // namespace keypose::motion
