#include "armature/example/theropod_body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "armature/example/theropod.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::armature {
namespace {

using Eigen::Vector3d;

/// A point of a limb's middle line, and how wide and high the limb is there [m].
struct Station {
  Vector3d at;
  double wide = 0, high = 0;
};
using Limb = std::vector<Station>;

using Rgb = Eigen::Matrix<std::uint8_t, 1, 3>;

/// Catmull and Rom's curve through four values, between the middle two.
template <class Value>
Value Smooth(const Value& a, const Value& b, const Value& c, const Value& d, double t) {
  const double s = t * t, u = s * t;
  return 0.5 * (2 * b + t * (c - a) + s * (2 * a - 5 * b + 4 * c - d) + u * (3 * (b - c) + d - a));
}

Station StationAt(const Limb& limb, double t) {
  const int last = SizeOf(limb) - 1;
  const int i = std::clamp(static_cast<int>(t), 0, last - 1);
  const auto at = [&](int k) -> const Station& { return limb[std::clamp(k, 0, last)]; };
  const Station &a = at(i - 1), &b = at(i), &c = at(i + 1), &d = at(i + 2);
  const double s = t - i;
  return {Smooth<Vector3d>(a.at, b.at, c.at, d.at, s), Smooth(a.wide, b.wide, c.wide, d.wide, s),
          Smooth(a.high, b.high, c.high, d.high, s)};
}

Rgb Blended(const Rgb& a, const Rgb& b, double t) {
  const Eigen::RowVector3d mixed = (1 - t) * a.cast<double>() + t * b.cast<double>();
  return mixed.cast<std::uint8_t>();
}

/// Back, flank and belly of a hide with stripes.
Rgb HideAt(double upwards, double along) {
  const Rgb back(74, 92, 62), flank(146, 140, 92), belly(214, 200, 160), stripe(52, 58, 44);
  const Rgb plain = upwards > 0 ? Blended(flank, back, upwards) : Blended(flank, belly, -upwards);
  const double wave = std::sin(along);
  return upwards > -0.2 && wave > 0.55 ? Blended(plain, stripe, 0.7) : plain;
}

class BodyBuilder {
 public:
  explicit BodyBuilder(double fineness) : fineness_(fineness) {}

  /// A tube with round ends, whose middle line never runs along x.
  void AddLimb(const Limb& limb, int segments_at_1, int rings_at_1, double stripes) {
    const int segments = Scaled(segments_at_1), rings = Scaled(rings_at_1);
    const int first = SizeOf(points_);
    const double end = SizeOf(limb) - 1.0;
    for (int r = 0; r < rings; ++r) {
      // The ends come closer in steps, as a ball's rings do.
      const double t = end * 0.5 * (1 - std::cos(kPi * (r + 0.5) / rings));
      const Station here = StationAt(limb, t);
      const double slip = 1e-3;
      const Vector3d along = (StationAt(limb, std::min(t + slip, end)).at -
                              StationAt(limb, std::max(t - slip, 0.0)).at)
                                 .normalized();
      const Vector3d up = Vector3d::UnitX().cross(along).normalized();
      const double round = RoundEnd(t, end);
      for (int s = 0; s < segments; ++s) {
        const double angle = 2 * kPi * s / segments;
        const Vector3d out =
            here.wide * std::cos(angle) * Vector3d::UnitX() + here.high * std::sin(angle) * up;
        Add(here.at + round * out, HideAt(std::sin(angle) * (up.z() < -0.3 ? -1 : 1), stripes * t));
      }
    }
    const int begin = Add(limb.front().at, HideAt(0, 0)), tip = Add(limb.back().at, HideAt(0, 0));
    Connect(first, segments, rings, begin, tip);
  }

  void AddEye(const Vector3d& at, double radius) {
    Limb eye = {{at - radius * Vector3d::UnitY(), radius, radius},
                {at, radius, radius},
                {at + radius * Vector3d::UnitY(), radius, radius}};
    const int first = SizeOf(points_);
    AddLimb(eye, 5, 5, 0);
    for (int v = first; v < SizeOf(points_); ++v) colors_[v] = {24, 20, 16};
  }

  Mesh Take() const {
    Mesh mesh;
    mesh.points.resize(SizeOf(points_), 3);
    mesh.colors.resize(SizeOf(points_), 3);
    mesh.faces.resize(SizeOf(faces_), 3);
    for (int v = 0; v < SizeOf(points_); ++v) {
      mesh.points.row(v) = points_[v];
      mesh.colors.row(v) = colors_[v];
    }
    for (int f = 0; f < SizeOf(faces_); ++f) mesh.faces.row(f) = faces_[f];
    return mesh;
  }

 private:
  int Scaled(int count) const {
    return std::max(5, static_cast<int>(std::lround(count * fineness_)));
  }

  /// Share of a limb's width near its ends, where it closes as a ball.
  static double RoundEnd(double t, double end) {
    constexpr double kCap = 0.45;  // of a station
    const double near = std::min(t, end - t) / kCap;
    return near >= 1 ? 1 : std::sqrt(std::max(0.0, near * (2 - near)));
  }

  int Add(const Vector3d& point, const Rgb& color) {
    points_.push_back(point);
    colors_.push_back(color);
    return SizeOf(points_) - 1;
  }

  void Connect(int first, int segments, int rings, int begin, int tip) {
    const auto at = [&](int r, int s) { return first + r * segments + s % segments; };
    for (int s = 0; s < segments; ++s) {
      faces_.emplace_back(begin, at(0, s), at(0, s + 1));
      faces_.emplace_back(tip, at(rings - 1, s + 1), at(rings - 1, s));
      for (int r = 0; r + 1 < rings; ++r) {
        faces_.emplace_back(at(r, s), at(r + 1, s + 1), at(r, s + 1));
        faces_.emplace_back(at(r, s), at(r + 1, s), at(r + 1, s + 1));
      }
    }
  }

  double fineness_;
  std::vector<Vector3d> points_;
  std::vector<Rgb> colors_;
  std::vector<Eigen::RowVector3i> faces_;
};

/// Where the joints are in the zero position.
class Joints {
 public:
  Joints() : clip_(MakeTheropodSkeleton()) {
    for (const ClipJoint& joint : clip_.joints)
      places_.push_back(joint.offset +
                        (joint.parent < 0 ? Vector3d(0, 0, 0) : places_[joint.parent]));
  }
  Vector3d operator[](const std::string& name) const { return places_[clip_.Find(name)]; }

 private:
  MotionClip clip_;
  std::vector<Vector3d> places_;
};

/// Against the tube's own turn: it must begin at the end from which its faces look outwards.
Limb SpineOf(const Joints& joints) {
  const Vector3d down(0, 0, -0.01);
  return {{joints["TailTip"], 0.003, 0.003},
          {joints["Tail6"], 0.010, 0.012},
          {joints["Tail4"], 0.018, 0.022},
          {joints["Tail2"], 0.030, 0.036},
          {joints["Hips"] + 0.3 * down, 0.044, 0.058},
          {joints["Spine1"] + down, 0.050, 0.064},
          {joints["Spine2"] + 0.3 * down, 0.033, 0.050},
          {joints["Neck1"], 0.026, 0.036},
          {joints["Neck2"], 0.024, 0.032},
          {joints["Neck3"], 0.030, 0.034},
          {0.6 * joints["Neck3"] + 0.4 * joints["HeadTip"], 0.032, 0.034},
          {0.25 * joints["Neck3"] + 0.75 * joints["HeadTip"], 0.022, 0.022},
          {joints["HeadTip"], 0.014, 0.014}};
}

Limb LegOf(const Joints& joints, const std::string& side) {
  const Vector3d hip = joints[side + "UpLeg"], knee = joints[side + "Leg"],
                 ankle = joints[side + "Ankle"], foot = joints[side + "Foot"],
                 tip = joints[side + "ToeTip"];
  return {{hip + Vector3d(0, 0, 0.02), 0.026, 0.036},
          {0.55 * hip + 0.45 * knee, 0.027, 0.042},
          {knee, 0.019, 0.022},
          {0.6 * knee + 0.4 * ankle, 0.015, 0.021},
          {ankle, 0.010, 0.012},
          {0.4 * ankle + 0.6 * foot, 0.011, 0.012},
          {foot + Vector3d(0, 0.006, 0), 0.015, 0.012},
          {joints[side + "Toe"], 0.018, 0.010},
          {tip, 0.012, 0.006}};
}

Limb ArmOf(const Joints& joints, const std::string& side) {
  const Vector3d fore = joints[side + "ForeArm"], hand = joints[side + "Hand"];
  return {{joints[side + "Arm"] + Vector3d(0, 0, 0.012), 0.012, 0.014},
          {0.5 * joints[side + "Arm"] + 0.5 * fore, 0.010, 0.012},
          {fore, 0.009, 0.009},
          {0.5 * fore + 0.5 * hand, 0.007, 0.007},
          {hand, 0.007, 0.006},
          {joints[side + "ClawTip"], 0.005, 0.004}};
}

Mesh BodyOf(double fineness) {
  const Joints joints;
  BodyBuilder body(fineness);
  body.AddLimb(SpineOf(joints), 20, 120, 4.2);
  for (const std::string side : {"left", "right"}) {
    body.AddLimb(LegOf(joints, side), 14, 50, 2.6);
    body.AddLimb(ArmOf(joints, side), 9, 26, 2.6);
    const Vector3d head = 0.55 * joints["Neck3"] + 0.45 * joints["HeadTip"];
    body.AddEye(head + Vector3d(side == "left" ? 0.027 : -0.027, 0, 0.016), 0.007);
  }
  return body.Take();
}

}  // namespace

Mesh MakeTheropodBody(int vertices) {
  double fineness = 0.5;
  Mesh body = BodyOf(fineness);
  while (body.vertex_count() < vertices) body = BodyOf(fineness *= 1.02);
  return body;
}

}  // namespace keypose::armature
