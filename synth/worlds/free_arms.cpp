#include "synth/worlds/free_arms.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/numbers/parallel.h"
#include "core/numbers/rotations.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kPressed = 0.5;  // of an arm's radius, that may be inside
constexpr double kEnough = 1e-3;  // [m] inside that are left
constexpr int kSmoothPasses = 8;
constexpr double kSmooth = 3;  // standard deviation [frames]

Flesh Moved(Flesh lump, const Rigid3& move) {
  lump.a = move * lump.a;
  lump.b = move * lump.b;
  return lump;
}

/// A place on the arm's axis.
struct ArmPlace {
  Vector3d x;
  double radius = 0;
  bool at_elbow = false;  // it is beside the trunk in many poses: only the rest matters
};

/// One arm and what it may touch in one frame.
struct Posed {
  std::vector<Flesh> rest;  // head and thighs
  std::vector<Flesh> body;  // these and the trunk
  std::vector<ArmPlace> arm;
  Vector3d shoulder;

  const std::vector<Flesh>& Touched(const ArmPlace& place) const {
    return place.at_elbow ? rest : body;
  }
  Vector3d Turned(const ArmPlace& place, const Quaterniond& turn) const {
    return shoulder + turn * (place.x - shoulder);
  }
  /// How far a place of the arm is too deep [m].
  double Depth(const ArmPlace& place, const Quaterniond& turn) const {
    return (1 - kPressed) * place.radius - BodyDistance(Touched(place), Turned(place, turn));
  }
  /// The turn, and more of it until the arm is outside.
  Quaterniond Outside(Quaterniond turn) const;
};

Vector3d Outwards(const std::vector<Flesh>& body, const Vector3d& x) {
  constexpr double kStep = 1e-4;
  Vector3d normal;
  for (int c = 0; c < 3; ++c) {
    const Vector3d step = kStep * Vector3d::Unit(c);
    normal[c] = BodyDistance(body, x + step) - BodyDistance(body, x - step);
  }
  return normal.normalized();
}

Quaterniond Posed::Outside(Quaterniond turn) const {
  constexpr int kMostSteps = 60;
  constexpr double kMostTurn = 0.1;  // [rad] of a step
  for (int step = 0; step < kMostSteps; ++step) {
    double deepest = kEnough;
    const ArmPlace* place = nullptr;
    for (const ArmPlace& candidate : arm)
      if (const double depth = Depth(candidate, turn); depth > deepest) {
        deepest = depth;
        place = &candidate;
      }
    if (!place) break;
    const Vector3d at = Turned(*place, turn);
    const Vector3d axis = (at - shoulder).cross(Outwards(Touched(*place), at));
    // A turn by `axis` times t moves the place outwards by |axis|^2 t.
    const Vector3d wanted = axis * (deepest / std::max(axis.squaredNorm(), 1e-4));
    const double factor = std::min(1.0, kMostTurn / std::max(wanted.norm(), 1e-12));
    turn = (QuaternionOf(factor * wanted) * turn).normalized();
  }
  return turn;
}

/// Columns of the channels that turn a joint, in their order.
std::vector<std::pair<int, int>> TurningChannels(const MotionClip& clip, int joint) {
  int column = 0;
  for (int j = 0; j < joint; ++j) column += SizeOf(clip.joints[j].channels);
  std::vector<std::pair<int, int>> turning;  // column, axis
  for (const BvhChannel channel : clip.joints[joint].channels) {
    if (channel >= BvhChannel::kXrotation)
      turning.emplace_back(column, static_cast<int>(channel) % 3);
    ++column;
  }
  return turning;
}

class Arm {
 public:
  Arm(const std::vector<Flesh>& lumps, const std::vector<Rigid3>& world_from_bind,
      const std::string& side, MotionClip* clip)
      : lumps_(lumps),
        world_from_bind_(world_from_bind),
        clip_(*clip),
        shoulder_(clip->Find(side + "Shoulder")),
        elbow_(clip->Find(side + "Elbow")),
        wrist_(clip->Find(side + "Wrist")),
        channels_(TurningChannels(*clip, shoulder_)) {
    if (SizeOf(channels_) != 3)
      throw InputError("synth: the joint '" + side + "Shoulder' must turn about three axes");
    for (const char* name : {"Hips", "Chest", "Chest2"}) trunk_.push_back(clip->Find(name));
    for (const char* name : {"Neck", "Head", "LeftHip", "RightHip"})
      rest_.push_back(clip->Find(name));
  }

  void Free() {
    const int frames = clip_.frame_count();
    std::vector<Posed> posed(frames);
    std::vector<Quaterniond> turns(frames, Quaterniond::Identity());
    ParallelFor(frames, [&](std::int64_t f) { posed[f] = PosedIn(static_cast<int>(f)); });
    for (int pass = 0; pass < kSmoothPasses; ++pass) {
      std::vector<Vector3d> more(frames);
      ParallelFor(frames, [&](std::int64_t f) {
        more[f] = LogOf(posed[f].Outside(turns[f]) * turns[f].conjugate());
      });
      for (int f = 0; f < frames; ++f)
        turns[f] = (QuaternionOf(Smooth(more, f)) * turns[f]).normalized();
    }
    for (int f = 0; f < frames; ++f) Write(f, posed[f].Outside(turns[f]));
  }

 private:
  Posed PosedIn(int frame) const {
    const std::vector<Rigid3> frames = UprightFrames(clip_, frame);
    Posed posed;
    posed.shoulder = frames[shoulder_].translation;
    for (const Flesh& lump : lumps_) {
      const Rigid3 move = Compose(frames[lump.joint], world_from_bind_[lump.joint].Inverse());
      const Flesh here = Moved(lump, move);
      const bool of_rest = std::count(rest_.begin(), rest_.end(), lump.joint) > 0;
      if (of_rest) posed.rest.push_back(here);
      if (of_rest || std::count(trunk_.begin(), trunk_.end(), lump.joint))
        posed.body.push_back(here);
      AddPlaces(here, &posed.arm);
    }
    return posed;
  }

  void AddPlaces(const Flesh& lump, std::vector<ArmPlace>* places) const {
    const auto add = [&](double t, bool at_elbow) {
      places->push_back({(1 - t) * lump.a + t * lump.b, (1 - t) * lump.ra + t * lump.rb, at_elbow});
    };
    if (lump.joint == shoulder_)
      for (const double t : {0.7, 0.85, 1.0}) add(t, true);
    if (lump.joint == elbow_) {
      for (const double t : {0.0, 0.2}) add(t, true);
      for (const double t : {0.4, 0.6, 0.8, 1.0}) add(t, false);
    }
    if (lump.joint == wrist_)
      for (int k = 0; k <= 3; ++k) add(k / 3.0, false);
  }

  static Vector3d Smooth(const std::vector<Vector3d>& values, int frame) {
    constexpr int kReach = static_cast<int>(3 * kSmooth);
    Vector3d sum = Vector3d::Zero();
    double weights = 0;
    for (int d = -kReach; d <= kReach; ++d) {
      const double weight = std::exp(-0.5 * d * d / (kSmooth * kSmooth));
      sum += weight * values[std::clamp(frame + d, 0, SizeOf(values) - 1)];
      weights += weight;
    }
    return sum / weights;
  }

  /// Turns the shoulder in the world, z up.
  void Write(int frame, const Quaterniond& turn) {
    constexpr double kNothing = 1e-6;
    if (LogOf(turn).norm() < kNothing) return;
    const std::vector<Rigid3> frames = UprightFrames(clip_, frame);
    const int parent = clip_.joints[shoulder_].parent;
    const Quaterniond local =
        frames[parent].rotation.conjugate() * turn * frames[shoulder_].rotation;
    const Vector3d angles = local.toRotationMatrix().eulerAngles(
        channels_[0].second, channels_[1].second, channels_[2].second);
    for (int i = 0; i < 3; ++i) clip_.values(frame, channels_[i].first) = angles[i] / kDegree;
  }

  const std::vector<Flesh>& lumps_;
  const std::vector<Rigid3>& world_from_bind_;
  MotionClip& clip_;
  int shoulder_, elbow_, wrist_;
  std::vector<int> trunk_, rest_;  // joints
  std::vector<std::pair<int, int>> channels_;
};

}  // namespace

void FreeArms(const std::vector<Flesh>& lumps, const std::vector<Rigid3>& world_from_bind,
              MotionClip* clip) {
  for (const char* side : {"Left", "Right"}) Arm(lumps, world_from_bind, side, clip).Free();
}

}  // namespace keypose::synth
