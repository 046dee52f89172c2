#include "motion/tracking/limb_retracking.h"

#include <algorithm>
#include <array>
#include <optional>

#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose::motion {
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

/// A limb followed on from a jump, or from where a search found it.
struct Course {
  int begin = 0;                     // its first frame: just beyond the jump, or the one searched
  int step = 1;                      // -1: backwards in time
  bool found = false;                // by a search: it has no past
  std::vector<TrackedFrame> frames;  // of it, in the order in which it is followed
  double gain = 0;                   // of cost against the known course, summed up
  double first_gain = 0;             // of the frame that was searched
  double best_gain = 0;              // the largest that the sum was,
  int best = 0;                      // after so many frames
};

/// Follows one limb through a take.
class LimbFollower {
 public:
  using Reader = std::function<const std::vector<Silhouette>&(int)>;
  LimbFollower(const BodyShape& shape, const LocalSurface& surface, const Reader& read, Limb limb,
               std::vector<TrackedFrame>* frames)
      : shape_(shape),
        surface_(surface),
        read_(read),
        limb_(limb),
        parts_(PartsOf(limb)),
        frames_(*frames) {}

  /// From all jumps, in one direction.
  void FollowJumps(int step) {
    const int count = SizeOf(frames_);
    if (count < 3) return;
    const double jump = LeastJump();
    std::optional<Course> open;
    for (int i = 2; i < count; ++i) {
      const int f = step > 0 ? i : count - 1 - i;
      if (!open && Bend(f - step) < jump) continue;
      if (!open) {
        open.emplace().begin = f;
        open->step = step;
      }
      if (Extend(f, &*open)) continue;
      Take(*open, 0);
      open.reset();
    }
    if (open) Take(*open, 0);
  }

  /// From where a search of one frame finds it, in both directions.
  void Search(int f) {
    if (f <= searched_to_ || OwnCells(f) >= usual_cells_) return;
    std::optional<Course> found = Found(f);
    if (!found) return;
    Course back = *found, on = *std::move(found);
    back.step = -1;
    Extend(&back);
    Extend(&on);
    searched_to_ = f + SizeOf(on.frames) - 1;
    const double gain = back.best_gain + on.best_gain - back.first_gain;
    if (gain < RetrackingTuning::kSure * frames_[f].evidence.cost) return;
    Take(back, 0);
    Take(on, 1);
  }

  const Retracking& retracking() const { return retracking_; }

 private:
  /// One more frame of the course.
  /// @return whether to go on
  bool Extend(int f, Course* course) { return Append(f, Solved(f, *course), course); }

  /// As many frames of the course as there are.
  void Extend(Course* course) {
    int f = course->begin + course->step;
    while (f >= 0 && f < SizeOf(frames_) && Extend(f, course)) f += course->step;
  }

  bool Append(int f, TrackedFrame frame, Course* course) const {
    const TrackedFrame& known = frames_[f];
    course->gain += RetrackingTuning::kBetter * known.evidence.cost - frame.evidence.cost;
    course->frames.push_back(std::move(frame));
    if (course->gain > course->best_gain) {
      course->best_gain = course->gain;
      course->best = SizeOf(course->frames);
    }
    const bool merged = Apart(course->frames.back().pose, known.pose) < RetrackingTuning::kMerged;
    const bool hopeless =
        course->gain < course->best_gain - RetrackingTuning::kHopeless * known.evidence.cost;
    return !merged && !hopeless && SizeOf(course->frames) < RetrackingTuning::kLongest;
  }

  /// The best other place of the limb, when it costs less than the known one.
  std::optional<Course> Found(int f) {
    std::optional<Course> best;
    for (const BodyPose& start : SearchLimb(read_(f), shape_, surface_, frames_[f].pose, limb_,
                                            RetrackingTuning::kCandidates)) {
      if (start.q == frames_[f].pose.q) continue;
      Course course;
      course.begin = f;
      course.found = true;
      const bool apart = Append(f, Solved(f, start, {RestPrior()}), &course);
      course.first_gain = course.gain;
      if (apart && course.gain > (best ? best->gain : 0)) best = std::move(course);
    }
    return best;
  }

  /// The pose so many frames back along the course, or before it.
  const BodyPose& Back(const Course& course, int f, int back) const {
    const int own = SizeOf(course.frames);
    return own >= back ? course.frames[own - back].pose : frames_[f - back * course.step].pose;
  }

  /// The frame's known pose, but the limb goes on as it went.
  BodyPose GoingOn(const Course& course, int f, bool still) const {
    BodyPose pose = frames_[f].pose;
    const auto last = Back(course, f, 1).q.segment(parts_.first_dof, parts_.dofs);
    pose.q.segment(parts_.first_dof, parts_.dofs) = last;
    if (still) return pose;
    const auto before = Back(course, f, 2).q.segment(parts_.first_dof, parts_.dofs);
    pose.q.segment(parts_.first_dof, parts_.dofs) += TrackerTuning::kSpeed * (last - before);
    return pose;
  }

  TrackedFrame Solved(int f, const Course& course) {
    // The first frame that was searched tells no speed.
    const bool still = course.found && SizeOf(course.frames) == 1;
    const BodyPose start = GoingOn(course, f, still);
    std::vector<QuadraticPrior> priors{RestPrior()};
    if (!still)
      for (const QuadraticPrior& calm : CalmPriors(InChart(Back(course, f, 1), start.root_chart),
                                                   InChart(Back(course, f, 2), start.root_chart)))
        priors.push_back(calm);
    return Solved(f, start, std::move(priors));
  }

  TrackedFrame Solved(int f, const BodyPose& start, std::vector<QuadraticPrior> priors) {
    PoseOptions options;
    options.rounds = TrackerTuning::kRounds;
    options.first_reach = 2 * OutlineTuning::kReach;
    options.priors = std::move(priors);
    const std::vector<Silhouette>& silhouettes = read_(f);
    ++retracking_.solved;
    TrackedFrame frame = FrameOf(SolvePose(silhouettes, shape_, surface_, start, options), shape_);
    frame.coverage = CoverageOf(silhouettes, surface_, Posed(frame.pose, shape_));
    return frame;
  }

  /// @param from  of the course's frames
  void Take(const Course& course, int from) {
    for (int i = from; i < course.best; ++i) {
      TrackedFrame& frame = frames_[course.begin + i * course.step];
      std::vector<Limb> found = std::move(frame.found);
      frame = course.frames[i];
      frame.found = std::move(found);
      ++retracking_.changed;
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
    return std::max(RetrackingTuning::kJump, RetrackingTuning::kUnusual * UpperMedian(bends));
  }

  /// In all views, that the limb covers and no other part of the body.
  double OwnCells(int f) const { return frames_[f].coverage.limb[static_cast<std::size_t>(limb_)]; }
  double UsualCells() const {
    std::vector<double> cells;
    for (int f = 0; f < SizeOf(frames_); ++f) cells.push_back(OwnCells(f));
    return UpperMedian(cells);
  }

  const BodyShape& shape_;
  const LocalSurface& surface_;
  const Reader& read_;
  const Limb limb_;
  const LimbParts parts_;
  std::vector<TrackedFrame>& frames_;
  const double usual_cells_ = UsualCells();
  int searched_to_ = -1;  // the last frame of the last search's course
  Retracking retracking_;
};

}  // namespace

Retracking RetrackLimbs(const BodyShape& shape,
                        const std::function<const std::vector<Silhouette>&(int)>& read,
                        std::vector<TrackedFrame>* frames) {
  const LocalSurface surface = SurfaceOf(shape);
  Retracking sum;
  const auto add = [&](const Retracking& retracking) {
    sum.solved += retracking.solved;
    sum.changed += retracking.changed;
  };
  for (const int step : {-1, 1})
    for (const Limb limb : kLimbs) {
      LimbFollower follower(shape, surface, read, limb, frames);
      follower.FollowJumps(step);
      add(follower.retracking());
    }
  std::vector<LimbFollower> arms;
  for (const Limb arm : {Limb::kLeftArm, Limb::kRightArm})
    arms.emplace_back(shape, surface, read, arm, frames);
  for (int f = RetrackingTuning::kEvery / 2; f < SizeOf(*frames); f += RetrackingTuning::kEvery)
    for (LimbFollower& arm : arms) arm.Search(f);
  for (const LimbFollower& arm : arms) add(arm.retracking());
  return sum;
}

}  // namespace keypose::motion
