#include "motion/body/body_clip.h"

#include "core/values/angles.h"

namespace keypose::motion {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const std::vector<BvhChannel> kTurns{BvhChannel::kZrotation, BvhChannel::kYrotation,
                                     BvhChannel::kXrotation};

// The clip's rest pose is y up; the template's frames are z up. Both are turned by `m`.
void AddJoint(MotionClip* clip, const std::vector<int>& place, int j, const BodyShape& shape,
              const Matrix3d& m) {
  const JointModel& model = Joints()[j];
  ClipJoint joint;
  joint.name = model.name;
  joint.parent = model.parent < 0 ? -1 : place[model.parent];
  for (const auto& [length, direction] : model.offset)
    joint.offset += shape.lengths[length] * (m * direction);
  if (model.parent < 0)
    joint.channels = {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition};
  joint.channels.insert(joint.channels.end(), kTurns.begin(), kTurns.end());
  clip->joints.push_back(joint);
}

bool IsLeaf(int j) {
  return j == kNeck || j == kWristL || j == kWristR || j == kAnkleL || j == kAnkleR;
}

void AddEnd(MotionClip* clip, int parent, int j, const BodyShape& shape, const Matrix3d& m) {
  const SegmentModel& segment = Segments()[SegmentOn(j)];
  ClipJoint end;
  end.parent = parent;
  end.offset = m * (segment.origin + shape.lengths[segment.length] * segment.axis);
  clip->joints.push_back(end);
}

}  // namespace

MotionClip ClipOf(const std::vector<BodyPose>& poses, const BodyShape& shape, double frame_time_s,
                  const Eigen::Quaterniond& clip_from_world) {
  MotionClip clip;
  clip.frame_time_s = frame_time_s;
  // z up and facing -y becomes y up and facing z, as most clips are.
  Matrix3d m;
  m << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  std::vector<int> place(kJoints);
  for (int j = 0; j < kJoints; ++j) {
    place[j] = static_cast<int>(clip.joints.size());
    AddJoint(&clip, place, j, shape, m);
    if (IsLeaf(j)) AddEnd(&clip, place[j], j, shape, m);
  }
  clip.values.resize(static_cast<Eigen::Index>(poses.size()), clip.channel_count());
  for (std::size_t f = 0; f < poses.size(); ++f) {
    const PosedBody body = Posed(poses[f], shape);
    auto row = clip.values.row(static_cast<Eigen::Index>(f));
    int column = 0;
    for (int j = 0; j < kJoints; ++j) {
      const int parent = Joints()[j].parent;
      if (parent < 0) {
        row.segment<3>(0) = (clip_from_world * body.position[j]).transpose();
        column = 3;
      }
      const Matrix3d local =
          parent < 0
              ? Matrix3d(clip_from_world.toRotationMatrix() * body.rotation[j] * m.transpose())
              : Matrix3d(m * body.rotation[parent].transpose() * body.rotation[j] * m.transpose());
      row.segment<3>(column) = EulerZyx(local).transpose() / kDegree;
      column += 3;
    }
  }
  return clip;
}

}  // namespace keypose::motion
