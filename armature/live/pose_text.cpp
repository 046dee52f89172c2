#include "armature/live/pose_text.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::armature {

using Eigen::Quaterniond;
using Eigen::Vector3d;

namespace {

std::string JsonString(const std::string& name) {
  return nlohmann::json(name).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

void AppendJoint(const std::string& name, const Vector3d& x, const Quaterniond& q,
                 std::string& text) {
  fmt::format_to(std::back_inserter(text), "{}:[{:.6g},{:.6g},{:.6g},{:.7g},{:.7g},{:.7g},{:.7g}]",
                 JsonString(name), x.x(), x.y(), x.z(), q.w(), q.x(), q.y(), q.z());
}

/// The clip's joints, and for each the bone whose turn it has.
struct ClipPlan {
  MotionClip clip;
  std::vector<int> bone;        ///< -1: an end, which does not turn
  std::vector<int> clip_joint;  ///< of each of the skeleton's joints
};

class ClipPlanner {
 public:
  explicit ClipPlanner(const Skeleton& skeleton)
      : skeleton_(skeleton), leading_(LeadingBones(skeleton)) {}

  ClipPlan Make() {
    for (int j = 0; j < skeleton_.size(); ++j) {
      const int parent = skeleton_.joints[j].parent;
      int below = parent < 0 ? -1 : plan_.clip_joint[parent];
      Vector3d offset = skeleton_.joints[j].rest;
      if (parent >= 0) {
        offset -= skeleton_.joints[parent].rest;
        if (leading_[parent] != j)
          below = Add(skeleton_.joints[j].name + "_turn", below, Vector3d::Zero(), j);
      }
      const bool end = leading_[j] == j;
      plan_.clip_joint.push_back(
          Add(skeleton_.joints[j].name, below, offset, end && parent >= 0 ? -1 : leading_[j]));
    }
    return plan_;
  }

 private:
  int Add(const std::string& name, int parent, const Vector3d& offset, int bone) {
    ClipJoint joint{name, parent, offset, {}};
    if (parent < 0)
      joint.channels = {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition};
    joint.channels.insert(joint.channels.end(),
                          {BvhChannel::kZrotation, BvhChannel::kYrotation, BvhChannel::kXrotation});
    plan_.clip.joints.push_back(joint);
    plan_.bone.push_back(bone);
    return SizeOf(plan_.clip.joints) - 1;
  }

  const Skeleton& skeleton_;
  std::vector<int> leading_;
  ClipPlan plan_;
};

/// Of the angles z, y, x of a rotation, and those of its other way, the ones nearer to the last,
/// with whole turns added.
Vector3d AnglesAfter(const Vector3d& before_deg, const Eigen::Matrix3d& rotation) {
  const Vector3d zyx = EulerZyx(rotation) / kDegree;
  const Vector3d other(zyx[0] + 180, 180 - zyx[1], zyx[2] + 180);
  const auto near = [&](Vector3d angles) -> Vector3d {
    for (int k = 0; k < 3; ++k) angles[k] += 360 * std::round((before_deg[k] - angles[k]) / 360);
    return angles;
  };
  const Vector3d a = near(zyx), b = near(other);
  return (a - before_deg).norm() <= (b - before_deg).norm() ? a : b;
}

}  // namespace

std::string PoseJson(const Skeleton& skeleton, const PuppetMatcher& matcher, const PoseLine& line) {
  std::string text = fmt::format(
      R"({{"pose":{},"time":{:.4f},"fresh":{},"latency_ms":{:.3f},"matched":{},"joints":{{)",
      line.number, line.time_s, line.fresh, 1e3 * line.latency_s, matcher.matched());
  const SkeletonPose& pose = matcher.pose();
  const std::vector<int> leading = LeadingBones(skeleton);
  for (int j = 0; j < skeleton.size(); ++j) {
    if (j) text += ',';
    AppendJoint(skeleton.joints[j].name, pose.joints.row(j), pose.bones[leading[j]].rotation, text);
  }
  text += "},\"gaps\":{";
  bool first = true;
  for (const ChainState& chain : matcher.chains()) {
    const double limit = 1e-9 * chain.chain_length;
    if (chain.match.near_gap <= limit && chain.match.far_gap <= limit) continue;
    fmt::format_to(std::back_inserter(text), "{}{}:[{:.4g},{:.4g}]", first ? "" : ",",
                   JsonString(chain.name), chain.match.near_gap, chain.match.far_gap);
    first = false;
  }
  return text + "}}";
}

MotionClip SkeletonClip(const Skeleton& skeleton, const std::vector<SkeletonPose>& poses,
                        double fps) {
  const ClipPlan plan = ClipPlanner(skeleton).Make();
  MotionClip clip = plan.clip;
  clip.frame_time_s = 1 / fps;
  clip.values.resize(SizeOf(poses), clip.channel_count());
  std::vector<Vector3d> last(clip.joints.size(), Vector3d::Zero());
  std::vector<Quaterniond> world(clip.joints.size());
  for (int f = 0; f < SizeOf(poses); ++f) {
    int column = 0;
    for (int j = 0; j < SizeOf(clip.joints); ++j) {
      const int parent = clip.joints[j].parent, bone = plan.bone[j];
      const Quaterniond above = parent < 0 ? Quaterniond::Identity() : world[parent];
      world[j] = bone < 0 ? above : poses[f].bones[bone].rotation;
      if (parent < 0) {
        const Vector3d place = poses[f].joints.row(skeleton.Find(clip.joints[j].name));
        clip.values.row(f).segment<3>(column) = place.transpose();
        column += 3;
      }
      last[j] = AnglesAfter(last[j], (above.conjugate() * world[j]).toRotationMatrix());
      clip.values.row(f).segment<3>(column) = last[j].transpose();
      column += 3;
    }
  }
  return clip;
}

}  // namespace keypose::armature
