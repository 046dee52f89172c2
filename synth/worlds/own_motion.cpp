// A motion of our own, for machines without recorded clips.
#include <cmath>

#include "core/values/angles.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/performer.h"

namespace keypose::synth {
namespace {

ClipJoint JointAt(const std::string& name, int parent, const Eigen::Vector3d& offset) {
  ClipJoint joint;
  joint.name = name;
  joint.parent = parent;
  joint.offset = offset;
  if (!name.empty())
    joint.channels = {BvhChannel::kZrotation, BvhChannel::kYrotation, BvhChannel::kXrotation};
  return joint;
}

MotionClip OwnSkeleton() {
  MotionClip clip;
  const auto add = [&](const std::string& name, const std::string& parent, double x, double y,
                       double z) {
    clip.joints.push_back(JointAt(name, parent.empty() ? -1 : clip.Find(parent), {x, y, z}));
  };
  add("Hips", "", 0, 0, 0);
  clip.joints[0].channels.insert(
      clip.joints[0].channels.begin(),
      {BvhChannel::kXposition, BvhChannel::kYposition, BvhChannel::kZposition});
  for (const std::string side : {"Left", "Right"}) {
    const double s = side == "Left" ? 1 : -1;
    add(side + "Hip", "Hips", 0.09 * s, -0.04, 0);
    add(side + "Knee", side + "Hip", 0.03 * s, -0.41, 0);
    add(side + "Ankle", side + "Knee", 0.02 * s, -0.40, 0);
    add(side + "Toe", side + "Ankle", 0, -0.04, 0.14);
    add("", side + "Toe", 0, 0, 0.06);
  }
  add("Chest", "Hips", 0, 0.12, 0);
  add("Chest2", "Chest", 0, 0.15, 0);
  add("Neck", "Chest2", 0, 0.20, 0);
  add("Head", "Neck", 0, 0.09, 0.01);
  add("", "Head", 0, 0.18, 0);
  for (const std::string side : {"Left", "Right"}) {
    const double s = side == "Left" ? 1 : -1;
    add(side + "Shoulder", "Chest2", 0.175 * s, 0.155, 0);
    add(side + "Elbow", side + "Shoulder", 0, -0.28, 0);
    add(side + "Wrist", side + "Elbow", 0, -0.25, 0);
    const std::string fingers = side == "Left" ? "LFingers" : "RFingers";
    add(fingers, side + "Wrist", 0, -0.08, 0);
    add("", fingers, 0, -0.09, 0);
  }
  return clip;
}

/// Sets one rotation channel [deg] of a joint by name.
class ChannelWriter {
 public:
  ChannelWriter(MotionClip* clip, int frame) : clip_(clip), frame_(frame) {}
  void Set(const std::string& name, BvhChannel channel, double value) {
    int column = 0;
    for (const ClipJoint& joint : clip_->joints)
      for (const BvhChannel c : joint.channels) {
        if (joint.name == name && c == channel) clip_->values(frame_, column) = value;
        ++column;
      }
  }
  void Turn(const std::string& name, double z, double y, double x) {
    Set(name, BvhChannel::kZrotation, z);
    Set(name, BvhChannel::kYrotation, y);
    Set(name, BvhChannel::kXrotation, x);
  }

 private:
  MotionClip* clip_;
  int frame_;
};

// A ramp from 0 to 1 and back, smooth, that begins at the first frame at 0.
double Swell(double t, double period) { return (1 - std::cos(2 * kPi * t / period)) / 2; }

void PoseLegs(ChannelWriter& writer, double step) {
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "Left" : "Right";
    const double phase = step + (side > 0 ? 0 : kPi);
    writer.Turn(name + "Hip", 2 * side, 0, -22 * std::sin(phase));
    writer.Turn(name + "Knee", 0, 0, 12 + 28 * std::max(0.0, std::cos(phase)));
    writer.Turn(name + "Ankle", 0, 0, -4 + 10 * std::sin(phase));
  }
}

void PoseArms(ChannelWriter& writer, double t, double step, double pace) {
  for (const double side : {1.0, -1.0}) {
    const std::string name = side > 0 ? "Left" : "Right";
    const double raise = 70 - 50 * Swell(t + 0.8 * (1 - side), 2.6 * pace) +
                         60 * Swell(t, 4.4 * pace) * (side > 0 ? 1 : 0.4);
    const double swing = 30 * std::sin(step + (side > 0 ? kPi : 0));
    writer.Turn(name + "Shoulder", side * raise, side * 12 * std::sin(1.1 * t), swing);
    writer.Turn(name + "Elbow", 0, 0, -10 - 85 * Swell(t + 0.5 * side, 1.9 * pace));
    writer.Turn(name + "Wrist", 12 * std::sin(2.3 * t), 0, 10 * std::sin(1.7 * t));
  }
}

}  // namespace

MotionClip MakeOwnMotion(int frames, double frames_per_second, std::uint64_t seed) {
  MotionClip clip = OwnSkeleton();
  clip.frame_time_s = 1 / frames_per_second;
  clip.values = Eigen::MatrixXd::Zero(frames, clip.channel_count());
  Random random(seed * 7 + 3);
  const double pace = random.Uniform(0.9, 1.2), circle = random.Uniform(0.35, 0.55);
  for (int f = 0; f < frames; ++f) {
    const double t = f * clip.frame_time_s, step = 2 * kPi * t / (1.1 * pace),
                 turn = 2 * kPi * t / (9 * pace);
    ChannelWriter writer(&clip, f);
    writer.Set("Hips", BvhChannel::kXposition, circle * (1 - std::cos(turn)));
    writer.Set("Hips", BvhChannel::kYposition, 0.86 + 0.015 * std::sin(2 * step));
    writer.Set("Hips", BvhChannel::kZposition, circle * std::sin(turn));
    writer.Turn("Hips", 2 * std::sin(step), turn / kDegree, 2);
    PoseLegs(writer, step);
    const double bow = Swell(t, 5.2 * pace);
    writer.Turn("Chest", 4 * std::sin(step), 10 * std::sin(0.9 * t), 5 + 18 * bow);
    writer.Turn("Chest2", 0, 8 * std::sin(0.9 * t), 14 * bow);
    writer.Turn("Neck", 0, 12 * std::sin(0.7 * t), -8 * bow);
    writer.Turn("Head", 0, 10 * std::sin(0.7 * t), 3);
    PoseArms(writer, t, step, pace);
  }
  return clip;
}

}  // namespace keypose::synth
