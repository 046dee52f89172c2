// Poses of a tube on a timeline, and all their frames, for the tests of sequences.
#pragma once

#include <Eigen/Geometry>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/camera.h"
#include "core/values/size_of.h"
#include "interpolate/distortion_meter.h"
#include "interpolate/sequence.h"

namespace keypose::interpolation {

constexpr double kPi = std::numbers::pi;
constexpr double kDegree = kPi / 180;

inline double Gap(const PointsX3& a, const PointsX3& b) {
  return (a - b).rowwise().norm().maxCoeff() / BoundingDiagonal(b);
}

/// A tube along z from 0 to `length`, bent through `angle` in the xz plane and squashed across.
inline PointsX3 Bent(const PointsX3& points, double length, double angle, double squash = 1) {
  PointsX3 bent = points;
  const double radius = length / angle;
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const double a = points(i, 2) / radius, r = radius - squash * points(i, 0);
    bent.row(i) << radius - r * std::cos(a), points(i, 1) / squash, r * std::sin(a);
  }
  return bent;
}

/// Three poses of a tube: straight, bent and squashed, bent another way and turned.
struct Poses {
  Mesh mesh = MakeCylinder(0.12, 2, 12, 30);
  PointsX3 a = mesh.points, b = Bent(mesh.points, 2, 100 * kDegree, 1.2),
           c = TurnedAway(Bent(mesh.points, 2, 170 * kDegree, 1.1));
  std::vector<PointsX3> all() const { return {a, b, c}; }

  static PointsX3 TurnedAway(const PointsX3& p) {
    Similarity3 motion;
    motion.rotation =
        Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 0.5).normalized()).toRotationMatrix();
    motion.translation << 0.4, -0.2, 0.3;
    return Transformed(motion, p);
  }
};

struct Shown {
  std::vector<PointsX3> points;
  DistortionReport distortion;
};

inline Shown Play(const std::vector<PointsX3>& keys, const FacesX3& faces, const Schedule& schedule,
                  const Rules& rules, Method method = Method::kArap) {
  const auto source = MakeFrameSource(keys, faces, schedule, method, rules);
  DistortionMeter meter(keys, faces, schedule);
  Shown shown;
  StreamFrames(keys, schedule, *source, [&](const FrameView& frame) {
    shown.points.push_back(frame.points);
    meter.Add(frame);
  });
  shown.distortion = meter.Finish();
  return shown;
}

inline Shown Play(const std::vector<PointsX3>& keys, const FacesX3& faces, const Schedule& schedule,
                  Method method = Method::kArap) {
  return Play(keys, faces, schedule, PlainRules(schedule, true), method);
}

/// Keys at these seconds, smooth unless changed.
inline Timeline At(const std::vector<double>& seconds, double fps = 10) {
  Timeline timeline;
  timeline.fps = fps;
  timeline.keys.resize(seconds.size());
  for (std::size_t k = 0; k < seconds.size(); ++k) timeline.keys[k].time_s = seconds[k];
  return timeline;
}

inline Schedule ScheduleOf(const Timeline& timeline) {
  return MakeSchedule(timeline, SizeOf(timeline.keys), 9, "timeline");
}

inline Rules RulesOf(const Timeline& timeline, const Schedule& schedule, const Mesh& mesh) {
  return RulesFrom(timeline, schedule, mesh.points, mesh.faces, true, "timeline");
}

}  // namespace keypose::interpolation
