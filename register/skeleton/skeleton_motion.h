// Moves the limbs of one body onto the matched limbs of another.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "register/parts/parts.h"
#include "register/skeleton/curve_skeleton.h"
#include "register/skeleton/skeleton_tree.h"
#include "register/skeleton/tree_matching.h"

namespace keypose::registration {

using MarkPair = std::pair<Eigen::Vector3d, Eigen::Vector3d>;  ///< a landmark's place on the source
                                                               ///< and on the target

/// One mesh without its loose parts, with its skeleton.
struct LimbedBody {
  LooseParts loose;
  Mesh mesh;
  RayScene scene;
  CurveSkeleton skeleton;
  std::optional<KdTree> surface_tree;  // of skeleton.surface
  std::optional<SkeletonTree> tree;

  LimbedBody(const Mesh& whole, int proxy_faces, Progress* progress)
      : loose(FindLooseParts(whole)),
        mesh(HostOf(whole, loose)),
        scene(mesh.points, mesh.faces),
        skeleton(ExtractCurveSkeleton(mesh.points, mesh.faces, proxy_faces, progress)) {
    if (!skeleton.fault.empty()) return;
    surface_tree.emplace(skeleton.surface);
    tree.emplace(skeleton, scene);
  }
  int NodeOf(const Eigen::Vector3d& p) const {
    return skeleton.node_of[surface_tree->Nearest(p).index];
  }
};

/// The axis of a limb as equally spaced samples, starting at the joint nearer to the root.
struct LimbAxis {
  static constexpr int kSamples = 48;

  PointsX3 points;  // kSamples + 1
  double length = 0;

  Eigen::Vector3d At(double share) const {
    const double x = std::clamp(share, 0.0, 1.0) * kSamples;
    const int k = std::min(static_cast<int>(x), kSamples - 1);
    return points.row(k) + (x - k) * (points.row(k + 1) - points.row(k));
  }
  Eigen::Vector3d Tangent(double share) const {
    return (At(share + 0.03) - At(share - 0.03)).normalized();
  }
  /// Share of the length at the point of the axis nearest to p, searched between two shares.
  double Project(const Eigen::Vector3d& p, double low = 0, double high = 1) const {
    double best = std::numeric_limits<double>::infinity(), share = low;
    for (int k = 0; k < kSamples; ++k) {
      if ((k + 1.0) / kSamples < low || static_cast<double>(k) / kSamples > high) continue;
      const Eigen::Vector3d a = points.row(k), d = points.row(k + 1) - points.row(k);
      const double x = std::clamp((p - a).dot(d) / std::max(d.squaredNorm(), 1e-300), 0.0, 1.0);
      const double distance = (a + x * d - p).squaredNorm();
      if (distance >= best) continue;
      best = distance;
      share = (k + x) / kSamples;
    }
    return std::clamp(share, low, high);
  }
};

/// A landmark on a limb.
struct LimbMark {
  double source_share = 0, target_share = 0;
  Eigen::Vector3d source, target;
};

/// A limb of the source and its counterpart on the target.
struct LimbPair {
  int source_limb = -1;
  bool backwards = false;  // whether the source limb's node order runs towards the root
  int from = -1, to = -1;  // source joints; `from` is nearer to the root
  LimbAxis source, target;
  // corresponding shares of the source's and the target's length, ascending in both
  std::vector<std::pair<double, double>> knots;
  std::vector<LimbMark> marks;
  std::vector<Eigen::Matrix3d> turns;  // kSamples + 1: target from source
  double quiet = 0;                    // share of the length inside the joint's ball, at most 0.4

  double TargetShare(double share) const {
    std::size_t k = 1;
    while (k + 1 < knots.size() && knots[k].first < share) ++k;
    const auto& [s0, t0] = knots[k - 1];
    const auto& [s1, t1] = knots[k];
    return t0 + (t1 - t0) * std::clamp((share - s0) / std::max(s1 - s0, 1e-12), 0.0, 1.0);
  }
};

/// The motion of a joint.
struct JointMotion {
  Eigen::Vector3d source = Eigen::Vector3d::Zero(), target = Eigen::Vector3d::Zero();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  double radius = 0;
  bool known = false;
};

/// The motion of the source, computed joint by joint from the root.
class SkeletonMotion {
 public:
  SkeletonMotion(const LimbedBody& source, const LimbedBody& target, const TipMatch& match,
                 const std::vector<MarkPair>& landmarks, const Similarity3& coarse, double scale);

  /// Moves points on the source's surface.
  PointsX3 Apply(const PointsX3& points) const;
  int limb_count() const { return SizeOf(pairs_); }

 private:
  void PairJoints(const TipMatch& match);
  void Walk(int root);
  void AddLimbs(int joint, int came_by);
  void PlaceMarks(LimbPair& pair);
  void TurnJoint(int joint, int came_by, const Eigen::Matrix3d& prior, double prior_weight);
  void TurnLimb(LimbPair& pair);
  void Twist(LimbPair& pair, const std::vector<Eigen::Vector3d>& tangents);
  Eigen::Vector3d Moved(const LimbPair& pair, double share, const Eigen::Vector3d& x) const;

  const LimbedBody& source_;
  const LimbedBody& target_;
  const Similarity3& coarse_;
  double scale_;
  std::vector<JointMotion> joints_;  // by source joint
  std::vector<int> target_joint_;    // by source joint
  // source limb -> target limb, and 1 when the target limb runs the other way
  std::vector<std::array<int, 2>> limb_match_;
  std::vector<LimbPair> pairs_;
  std::vector<int> pair_of_limb_;
  const std::vector<MarkPair>& marks_;
};

}  // namespace keypose::registration
