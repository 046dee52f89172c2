#include "fit/tracking/second_look.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/size_of.h"

namespace keypose::fit {
namespace {

/// What a limb consists of.
struct LimbParts {
  int first_dof = 0, dofs = 0;
  std::array<int, 2> joints = {};  // its middle and its end
};

LimbParts PartsOf(Limb limb) {
  switch (limb) {
    case Limb::kLeftArm:
      return {Joints()[kClavicleL].first_dof, 7, {kElbowL, kWristL}};
    case Limb::kRightArm:
      return {Joints()[kClavicleR].first_dof, 7, {kElbowR, kWristR}};
    case Limb::kLeftLeg:
      return {Joints()[kHipL].first_dof, 6, {kKneeL, kAnkleL}};
    default:
      return {Joints()[kHipR].first_dof, 6, {kKneeR, kAnkleR}};
  }
}

/// A limb followed on from a jump.
struct Course {
  int begin = 0;                     // its first frame, just beyond the jump
  std::vector<TrackedFrame> frames;  // of it, in the order in which it is followed
  double gain = 0;                   // of cost against the known course, summed up
  double best_gain = 0;              // the largest that the sum was,
  int best = 0;                      // after so many frames
};

/// Follows one limb through a take, in one direction.
class LimbFollower {
 public:
  using Reader = std::function<const std::vector<Silhouette>&(int)>;
  LimbFollower(const BodyShape& shape, const LocalSurface& surface, const Reader& read, Limb limb,
               int step, std::vector<TrackedFrame>* frames)
      : shape_(shape),
        surface_(surface),
        read_(read),
        parts_(PartsOf(limb)),
        step_(step),
        frames_(*frames) {}

  SecondLooks Follow() {
    const int count = SizeOf(frames_);
    if (count < 3) return looks_;
    const double jump = LeastJump();
    std::optional<Course> open;
    for (int i = 2; i < count; ++i) {
      const int f = step_ > 0 ? i : count - 1 - i;
      if (!open && Bend(f - step_) < jump) continue;
      if (!open) open.emplace().begin = f;
      if (Extend(f, &*open)) continue;
      Take(*open);
      open.reset();
    }
    if (open) Take(*open);
    return looks_;
  }

 private:
  /// One more frame of the course.
  /// @return whether to go on
  bool Extend(int f, Course* course) {
    course->frames.push_back(Solved(f, *course));
    const TrackedFrame& known = frames_[f];
    course->gain +=
        SecondLookTuning::kBetter * known.evidence.cost - course->frames.back().evidence.cost;
    if (course->gain > course->best_gain)
      course->best_gain = course->gain, course->best = SizeOf(course->frames);
    const bool merged = Apart(course->frames.back().pose, known.pose) < SecondLookTuning::kMerged;
    const bool hopeless =
        course->gain < course->best_gain - SecondLookTuning::kHopeless * known.evidence.cost;
    return !merged && !hopeless && SizeOf(course->frames) < SecondLookTuning::kLongest;
  }

  /// The pose so many frames back along the course, or before it.
  const BodyPose& Back(const Course& course, int f, int back) const {
    const int own = SizeOf(course.frames);
    return own >= back ? course.frames[own - back].pose : frames_[f - back * step_].pose;
  }

  /// The frame's known pose, but the limb goes on as it went.
  BodyPose GoingOn(const Course& course, int f) const {
    BodyPose pose = frames_[f].pose;
    const auto last = Back(course, f, 1).q.segment(parts_.first_dof, parts_.dofs);
    const auto before = Back(course, f, 2).q.segment(parts_.first_dof, parts_.dofs);
    pose.q.segment(parts_.first_dof, parts_.dofs) = last + TrackerTuning::kSpeed * (last - before);
    return pose;
  }

  TrackedFrame Solved(int f, const Course& course) {
    const BodyPose start = GoingOn(course, f);
    PoseOptions options;
    options.rounds = TrackerTuning::kRounds;
    options.first_reach = 2 * OutlineTuning::kReach;
    options.priors = {RestPrior()};
    for (const QuadraticPrior& calm : CalmPriors(InChart(Back(course, f, 1), start.root_chart),
                                                 InChart(Back(course, f, 2), start.root_chart)))
      options.priors.push_back(calm);
    const std::vector<Silhouette>& silhouettes = read_(f);
    ++looks_.solved;
    TrackedFrame frame = FrameOf(SolvePose(silhouettes, shape_, surface_, start, options), shape_);
    frame.coverage = CoverageOf(silhouettes, surface_, Posed(frame.pose, shape_));
    return frame;
  }

  void Take(const Course& course) {
    for (int i = 0; i < course.best; ++i) {
      TrackedFrame& frame = frames_[course.begin + i * step_];
      std::vector<Limb> found = std::move(frame.found);
      frame = course.frames[i];
      frame.found = std::move(found);
      ++looks_.changed;
    }
  }

  /// [m] between the limb's joints in two poses, the larger one.
  double Apart(const BodyPose& a, const BodyPose& b) const {
    const PosedBody x = Posed(a, shape_), y = Posed(b, shape_);
    double apart = 0;
    for (const int joint : parts_.joints)
      apart = std::max(apart, (x.position[joint] - y.position[joint]).norm());
    return apart;
  }

  /// Second difference in time of the limb's joints about a frame [m], the larger one's.
  double Bend(int f) const {
    const PosedBody a = Posed(frames_[f - 1].pose, shape_), b = Posed(frames_[f].pose, shape_),
                    c = Posed(frames_[f + 1].pose, shape_);
    double bend = 0;
    for (const int j : parts_.joints)
      bend = std::max(bend, (a.position[j] - 2 * b.position[j] + c.position[j]).norm());
    return bend;
  }

  double LeastJump() const {
    std::vector<double> bends;
    for (int f = 1; f + 1 < SizeOf(frames_); ++f) bends.push_back(Bend(f));
    const auto middle = bends.begin() + SizeOf(bends) / 2;
    std::nth_element(bends.begin(), middle, bends.end());
    return std::max(SecondLookTuning::kJump, SecondLookTuning::kUnusual * *middle);
  }

  const BodyShape& shape_;
  const LocalSurface& surface_;
  const Reader& read_;
  const LimbParts parts_;
  const int step_;  // -1: backwards in time
  std::vector<TrackedFrame>& frames_;
  SecondLooks looks_;
};

}  // namespace

SecondLooks LookAgain(const BodyShape& shape,
                      const std::function<const std::vector<Silhouette>&(int)>& read,
                      std::vector<TrackedFrame>* frames) {
  const LocalSurface surface = SurfaceOf(shape);
  SecondLooks sum;
  for (const int step : {-1, 1})
    for (const Limb limb : kLimbs) {
      const SecondLooks looks = LimbFollower(shape, surface, read, limb, step, frames).Follow();
      sum.solved += looks.solved, sum.changed += looks.changed;
    }
  return sum;
}

}  // namespace keypose::fit
