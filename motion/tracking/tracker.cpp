#include "motion/tracking/tracker.h"

#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose::motion {
namespace {

constexpr int kSearchPause = 3;              // frames between searches for the same limb
constexpr int kVainPause = 12;               // the same where nothing changes
constexpr double kFall = 0.3, kRise = 0.02;  // of the usual difference, a frame
constexpr int kCandidates = 2;               // that are solved of a search

double RelativeDifference(const Coverage& c) { return c.Difference() / std::max(1.0, c.both); }

}  // namespace

PoseSystem FrameEvidence(const PoseFit& fit, const BodyShape& shape) {
  PoseSystem system = fit.data;
  AddQuadratic(RestPrior(), fit.pose.q, &system);
  AddLimits(fit.pose.q, &system);
  AddOverlaps(Posed(fit.pose, shape), shape, &system);
  // The root's numbers turn the chart; after it is moved, they turn the root itself.
  DofMatrix old_from_new = DofMatrix::Identity();
  old_from_new.block<3, 3>(3, 3) = LeftJacobian(fit.pose.q.segment<3>(3)).inverse();
  system.matrix = old_from_new.transpose() * system.matrix * old_from_new;
  system.gradient = old_from_new.transpose() * system.gradient;
  return system;
}

TrackedFrame FrameOf(const PoseFit& fit, const BodyShape& shape) {
  TrackedFrame frame;
  frame.pose = fit.pose.Recharted();
  frame.deviations = StandardDeviations(fit);
  frame.evidence = FrameEvidence(fit, shape);
  frame.unexplained = fit.unexplained;
  return frame;
}

Tracker::Tracker(const BodyShape& shape, const BodyPose& start)
    : shape_(shape), surface_(SurfaceOf(shape)), start_(start.Recharted()) {}

BodyPose Tracker::Predicted() const {
  if (before_.empty()) return start_;
  BodyPose pose = before_.back();
  if (before_.size() < 2) return pose;
  pose.q += TrackerTuning::kSpeed * (pose.q - InChart(before_.front(), pose.root_chart));
  return pose;
}

std::vector<QuadraticPrior> Tracker::Priors(const Eigen::Quaterniond& chart) const {
  std::vector<QuadraticPrior> priors{RestPrior()};
  if (before_.size() < 2) return priors;
  for (const QuadraticPrior& calm :
       CalmPriors(InChart(before_.back(), chart), InChart(before_.front(), chart)))
    priors.push_back(calm);
  return priors;
}

bool Tracker::WorthSearching(Limb limb, double difference) const {
  const auto l = static_cast<std::size_t>(limb);
  const int since = frame_ - searched_[l];
  // An arm that lies on the body looks lost for as long as it lies there.
  const bool changed = std::abs(difference - in_vain_[l]) > TrackerTuning::kChanged * usual_;
  return since >= (changed ? kSearchPause : kVainPause);
}

std::vector<Limb> Tracker::Suspects(const Coverage& coverage) const {
  const double difference = RelativeDifference(coverage);
  const bool worse = usual_ > 0 && difference > TrackerTuning::kLostChange * usual_;
  std::vector<Limb> suspects;
  for (std::size_t l = 0; l < kLimbs.size(); ++l) {
    const double outside = coverage.limb_outside[l] / std::max(1.0, coverage.limb[l]);
    if ((worse || outside > TrackerTuning::kLostOutside) && WorthSearching(kLimbs[l], difference))
      suspects.push_back(kLimbs[l]);
  }
  return suspects;
}

void Tracker::FindLost(const std::vector<Silhouette>& silhouettes, const PoseOptions& options,
                       PoseFit* fit, TrackedFrame* frame) {
  for (const Limb limb : Suspects(frame->coverage)) {
    const auto l = static_cast<std::size_t>(limb);
    searched_[l] = frame_;
    in_vain_[l] = RelativeDifference(frame->coverage);
    // What was, is no guide to a limb that was lost.
    PoseOptions free = options;
    free.priors = {RestPrior()};
    free.first_reach = 2 * OutlineTuning::kReach;
    for (const BodyPose& candidate :
         SearchLimb(silhouettes, shape_, surface_, fit->pose, limb, kCandidates)) {
      const PoseFit solved = SolvePose(silhouettes, shape_, surface_, candidate, free);
      const Coverage coverage = CoverageOf(silhouettes, surface_, Posed(solved.pose, shape_));
      if (coverage.Difference() > TrackerTuning::kFound * frame->coverage.Difference()) continue;
      *fit = solved;
      frame->coverage = coverage;
      in_vain_[l] = 0;
      if (frame->found.empty() || frame->found.back() != limb) frame->found.push_back(limb);
    }
  }
}

/// Limbs that are bent the way that they cannot, turned around.
void Tracker::TurnBentBackwards(const std::vector<Silhouette>& silhouettes,
                                const PoseOptions& options, PoseFit* fit, TrackedFrame* frame) {
  for (const Limb limb : kLimbs) {
    const double bent = BentBackwards(fit->pose, limb);
    if (bent < TrackerTuning::kBackwards) continue;
    PoseOptions free = options;
    free.priors = {RestPrior()};
    const PoseFit solved =
        SolvePose(silhouettes, shape_, surface_, TurnedAround(fit->pose, limb), free);
    const Coverage coverage = CoverageOf(silhouettes, surface_, Posed(solved.pose, shape_));
    if (coverage.Difference() > TrackerTuning::kAsGood * frame->coverage.Difference() ||
        BentBackwards(solved.pose, limb) > 0.5 * bent)
      continue;
    *fit = solved;
    frame->coverage = coverage;
    frame->found.push_back(limb);
  }
}

TrackedFrame Tracker::Next(const std::vector<Silhouette>& silhouettes) {
  const BodyPose predicted = Predicted();
  PoseOptions options;
  options.rounds = TrackerTuning::kRounds;
  options.first_reach = 2 * OutlineTuning::kReach;
  options.priors = Priors(predicted.root_chart);
  PoseFit fit = SolvePose(silhouettes, shape_, surface_, predicted, options);
  TrackedFrame frame;
  frame.coverage = CoverageOf(silhouettes, surface_, Posed(fit.pose, shape_));
  FindLost(silhouettes, options, &fit, &frame);
  TurnBentBackwards(silhouettes, options, &fit, &frame);
  const double difference = RelativeDifference(frame.coverage);
  const double follow = difference < usual_ ? kFall : kRise;
  usual_ = usual_ == 0 ? difference : usual_ + follow * (std::min(difference, 2 * usual_) - usual_);
  TrackedFrame fitted = FrameOf(fit, shape_);
  fitted.coverage = frame.coverage;
  fitted.found = frame.found;
  frame = std::move(fitted);
  // A limb that jumped has no speed: the jump must not go on.
  if (frame.found.empty())
    before_.push_back(frame.pose);
  else
    before_ = {frame.pose};
  if (before_.size() > 2) before_.erase(before_.begin());
  ++frame_;
  return frame;
}

}  // namespace keypose::motion
