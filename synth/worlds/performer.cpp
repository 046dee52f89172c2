#include "synth/worlds/performer.h"

#include <algorithm>
#include <cmath>

#include "core/pictures/srgb.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/worlds/flesh.h"
#include "synth/worlds/free_arms.h"
#include "synth/worlds/noise.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

// Lengths of the average person that the clip's own unit is scaled to.
constexpr double kLegLength = 0.80;  // [m] hip to ankle

int RequiredJoint(const MotionClip& clip, const std::string& name) {
  const int joint = clip.Find(name);
  if (joint < 0)
    throw InputError("synth: the motion has no joint named '" + name +
                     "'; clips of the CMU motion capture database have it");
  return joint;
}

void ScaleClip(MotionClip* clip, double factor) {
  for (ClipJoint& joint : clip->joints) joint.offset *= factor;
  int column = 0;
  for (const ClipJoint& joint : clip->joints)
    for (const BvhChannel channel : joint.channels) {
      if (channel < BvhChannel::kXrotation) clip->values.col(column) *= factor;
      ++column;
    }
}

// Arms stretched sideways and down a little, so that they are apart from the trunk.
MotionClip BindClip(const MotionClip& clip) {
  MotionClip bind = clip;
  bind.values = Eigen::MatrixXd::Zero(1, clip.channel_count());
  int column = 0;
  for (const ClipJoint& joint : clip.joints)
    for (const BvhChannel channel : joint.channels) {
      if (channel == BvhChannel::kZrotation && joint.name == "LeftShoulder")
        bind.values(0, column) = 65;
      if (channel == BvhChannel::kZrotation && joint.name == "RightShoulder")
        bind.values(0, column) = -65;
      ++column;
    }
  return bind;
}

/// Lays lumps of flesh and cloth along the bones of the bind pose.
class Dresser {
 public:
  Dresser(const MotionClip& clip, const std::vector<Rigid3>& bind, Random* random)
      : clip_(clip),
        bind_(bind),
        girth_(random->Uniform(0.92, 1.12)),
        loose_(random->Uniform(1.05, 1.25)) {
    for (Vector3d* color : {&shirt_, &trousers_, &shoes_})
      *color = Vector3d(random->Uniform(0.08, 0.6), random->Uniform(0.08, 0.6),
                        random->Uniform(0.08, 0.6));
  }

  std::vector<Flesh> Dress() {
    Trunk();
    for (const std::string side : {"Left", "Right"}) {
      Arm(side);
      Leg(side);
    }
    return lumps_;
  }

 private:
  int Joint(const std::string& name) const { return RequiredJoint(clip_, name); }
  Vector3d At(const std::string& name) const { return bind_[Joint(name)].translation; }
  void Put(const std::string& joint, const Vector3d& a, const Vector3d& b, double ra, double rb,
           bool cloth, const Vector3d& color) {
    lumps_.push_back({Joint(joint), a, b, girth_ * ra, girth_ * rb, cloth, color});
  }

  void Trunk() {
    const Vector3d hips = (At("LeftHip") + At("RightHip")) / 2, chest = At("Chest"),
                   top = At("Neck");
    const Vector3d across = (At("LeftShoulder") - At("RightShoulder")) / 2;
    const Vector3d x = across.normalized(),
                   shoulders = (At("LeftShoulder") + At("RightShoulder")) / 2;
    const Vector3d breast = chest + 0.62 * (top - chest), waist = hips + 0.55 * (chest - hips);
    for (const double side : {-1.0, 1.0}) {
      Put("Hips", hips + side * 0.062 * x - Vector3d(0, 0, 0.02), waist + side * 0.055 * x,
          0.112 * loose_, 0.10, true, trousers_);
      Put("Chest", waist + side * 0.055 * x, breast + side * 0.07 * x, 0.098 * loose_, 0.108, true,
          shirt_);
      Put("Chest2", breast + side * 0.07 * x,
          shoulders + side * 0.72 * across - Vector3d(0, 0, 0.01), 0.106, 0.062, true, shirt_);
    }
    const Vector3d head = At("Head"), up = (head - top).normalized();
    Put("Neck", top - 0.03 * up, head, 0.062, 0.054, false, skin_);
    const Vector3d forward = -Vector3d::UnitY();
    Put("Head", head + 0.05 * up + 0.022 * forward, head + 0.115 * up + 0.018 * forward, 0.070,
        0.082, false, skin_);
    Put("Head", head + 0.10 * up - 0.025 * forward, head + 0.15 * up - 0.01 * forward, 0.082, 0.072,
        false, hair_);
  }

  void Arm(const std::string& side) {
    const std::string fingers = side == "Left" ? "LFingers" : "RFingers";
    const Vector3d shoulder = At(side + "Shoulder"), elbow = At(side + "Elbow"),
                   wrist = At(side + "Wrist");
    Put(side + "Shoulder", shoulder, elbow, 0.060 * loose_, 0.050 * loose_, true, shirt_);
    Put(side + "Elbow", elbow, wrist, 0.043, 0.030, false, skin_);
    const Vector3d along = (wrist - elbow).normalized();
    const Vector3d flat = along.cross(Vector3d::UnitZ()).normalized();
    for (const double finger : {-1.0, 1.0})
      Put(side + "Wrist", wrist + 0.03 * along + finger * 0.014 * flat,
          wrist + 0.135 * along + finger * 0.022 * flat, 0.024, 0.016, false, skin_);
  }

  void Leg(const std::string& side) {
    const Vector3d hip = At(side + "Hip"), knee = At(side + "Knee"), ankle = At(side + "Ankle"),
                   toe = At(side + "Toe");
    Put(side + "Hip", hip, knee, 0.094 * loose_, 0.066 * loose_, true, trousers_);
    Put(side + "Knee", knee, ankle, 0.064 * loose_, 0.055 * loose_, true, trousers_);
    const Vector3d forward =
        (Vector3d(toe.x(), toe.y(), 0) - Vector3d(ankle.x(), ankle.y(), 0)).normalized();
    const double sole = ankle.z() - 0.055;
    const Vector3d heel(ankle.x() - 0.045 * forward.x(), ankle.y() - 0.045 * forward.y(), sole);
    Put(side + "Ankle", heel, heel + 0.2 * forward, 0.040, 0.036, true, shoes_);
    Put(side + "Ankle", ankle, heel + 0.12 * forward, 0.048, 0.040, true, shoes_);
  }

  const MotionClip& clip_;
  const std::vector<Rigid3>& bind_;
  double girth_, loose_;
  Vector3d skin_{0.60, 0.36, 0.25}, hair_{0.05, 0.03, 0.02}, shirt_, trousers_, shoes_;
  std::vector<Flesh> lumps_;
};

// Weave, stripes and creases, so that points of the surface can be told apart.
Vector3d PaintOf(const Flesh& lump, const Vector3d& x, std::uint32_t seed) {
  Vector3d color = lump.color;
  const double fine = FractalNoise(x / 0.03, 3, 0.6, seed),
               coarse = GradientNoise(x / 0.11, seed + 1);
  if (lump.cloth)
    color *= 1 + 0.45 * fine + 0.35 * coarse;
  else
    color *= 1 + 0.12 * fine + 0.15 * coarse;
  if (lump.cloth && std::sin(x.z() / 0.02) > 0.55) color += Vector3d(0.18, 0.17, 0.15);
  return color.cwiseMax(0.01).cwiseMin(0.9);
}

/// Smooth weights of the bones nearest to a point.
std::vector<std::pair<int, double>> BoneWeights(const std::vector<Flesh>& lumps, int joints,
                                                const Vector3d& x) {
  constexpr double kReach = 0.05;  // [m] over which bones share the skin
  std::vector<double> least(static_cast<std::size_t>(joints), 1e9);
  double nearest = 1e9;
  for (const Flesh& lump : lumps) {
    least[lump.joint] = std::min(least[lump.joint], FleshDistance(lump, x));
    nearest = std::min(nearest, least[lump.joint]);
  }
  std::vector<std::pair<int, double>> weights;
  double sum = 0;
  for (int j = 0; j < joints; ++j) {
    const double rest = 1 - (least[j] - nearest) / kReach;
    if (rest <= 0) continue;
    weights.emplace_back(j, rest * rest);
    sum += rest * rest;
  }
  for (auto& weight : weights) weight.second /= sum;
  return weights;
}

}  // namespace

const std::vector<std::string>& Performer::JointNames() {
  static const std::vector<std::string> names{
      "LeftShoulder", "LeftElbow", "LeftWrist", "RightShoulder", "RightElbow", "RightWrist",
      "LeftHip",      "LeftKnee",  "LeftAnkle", "RightHip",      "RightKnee",  "RightAnkle"};
  return names;
}

Performer::Performer(const MotionClip& clip, const PerformerOptions& options)
    : clip_(clip), options_(options) {
  Random random(options.seed);
  const auto length = [&](const char* name) {
    return clip_.joints[RequiredJoint(clip_, name)].offset.norm();
  };
  ScaleClip(&clip_,
            kLegLength * random.Uniform(0.96, 1.05) / (length("LeftKnee") + length("LeftAnkle")));
  // Proportions of another person: bones are longer or shorter on both sides alike.
  for (const char* bone : {"Knee", "Ankle", "Elbow", "Wrist"}) {
    const double factor = random.Uniform(0.95, 1.06);
    for (const std::string side : {"Left", "Right"})
      clip_.joints[RequiredJoint(clip_, side + bone)].offset *= factor;
  }
  for (const std::string& name : JointNames()) RequiredJoint(clip_, name);
  const MotionClip bind = BindClip(clip_);
  world_from_bind_ = UprightFrames(bind, 0);
  const std::vector<Flesh> lumps = Dresser(clip_, world_from_bind_, &random).Dress();
  FreeArms(lumps, world_from_bind_, &clip_);
  Vector3d low = lumps[0].a, high = lumps[0].a;
  for (const Flesh& lump : lumps)
    for (const auto& [x, r] : {std::pair{lump.a, lump.ra}, {lump.b, lump.rb}}) {
      low = low.cwiseMin((x.array() - r - 0.06).matrix());
      high = high.cwiseMax((x.array() + r + 0.06).matrix());
    }
  bind_ = Polygonize([&](const Vector3d& x) { return BodyDistance(lumps, x); }, low, high,
                     options.spacing_m);
  bind_normals_ = VertexNormals(bind_.points, bind_.faces);
  bind_.colors.resize(bind_.points.rows(), 3);
  cloth_.resize(bind_.points.rows());
  for (Eigen::Index v = 0; v < bind_.points.rows(); ++v) {
    const Vector3d x = bind_.points.row(v);
    const Flesh* nearest = &lumps[0];
    for (const Flesh& lump : lumps)
      if (FleshDistance(lump, x) < FleshDistance(*nearest, x)) nearest = &lump;
    cloth_[v] = nearest->cloth;
    const Vector3d paint = PaintOf(*nearest, x, static_cast<std::uint32_t>(options.seed * 97 + 5));
    for (int c = 0; c < 3; ++c)
      bind_.colors(v, c) = static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(paint[c])));
    weights_.push_back(BoneWeights(lumps, SizeOf(clip_.joints), x));
  }
  Place();
}

void Performer::Place() {
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  for (int f = 0; f < frame_count(); ++f) {
    const PointsX3 points = f % 4 == 0 || f + 1 == frame_count() ? Points(f) : Joints(f);
    low = low.cwiseMin(points.colwise().minCoeff().transpose());
    high = high.cwiseMax(points.colwise().maxCoeff().transpose());
  }
  shift_ = -Vector3d((low.x() + high.x()) / 2, (low.y() + high.y()) / 2, low.z());
}

PointsX3 Performer::Points(int frame) const {
  const std::vector<Rigid3> frames = UprightFrames(clip_, frame);
  std::vector<Eigen::Matrix<double, 3, 4>> moves(frames.size());
  for (std::size_t j = 0; j < frames.size(); ++j) {
    const Rigid3 move = Compose(frames[j], world_from_bind_[j].Inverse());
    moves[j].leftCols<3>() = move.rotation.toRotationMatrix();
    moves[j].col(3) = move.translation;
  }
  const auto seed = static_cast<std::uint32_t>(options_.seed * 131 + 7);
  PointsX3 points(bind_.points.rows(), 3);
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    Vector3d x = bind_.points.row(v);
    if (cloth_[v] > 0) {
      const double still = GradientNoise(x / 0.07, seed);
      const double moving = GradientNoise(x / 0.09 + Vector3d(0, 0, 0.06 * frame), seed + 1);
      x += options_.cloth_m * (0.9 * still + 0.5 * moving) * bind_normals_.row(v).transpose();
    }
    Eigen::Matrix<double, 3, 4> move = Eigen::Matrix<double, 3, 4>::Zero();
    for (const auto& [joint, weight] : weights_[v]) move += weight * moves[joint];
    points.row(v) = (move.leftCols<3>() * x + move.col(3) + shift_).transpose();
  }
  return points;
}

PointsX3 Performer::Joints(int frame) const {
  const std::vector<Rigid3> frames = UprightFrames(clip_, frame);
  PointsX3 joints(SizeOf(JointNames()), 3);
  for (int i = 0; i < SizeOf(JointNames()); ++i)
    joints.row(i) = (frames[clip_.Find(JointNames()[i])].translation + shift_).transpose();
  return joints;
}

}  // namespace keypose::synth
