#include "armature/controller/joint_tracker.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

constexpr std::int32_t kRange = 1 << 24;
/// What an analogue input reads from one end to the other.
constexpr double kAnalogueCounts = 65536;

/// The change of a counter of 24 bits, in [-2^23, 2^23).
std::int32_t WrappedChange(std::int32_t from, std::int32_t to) {
  const std::int32_t change = (to - from) & (kRange - 1);
  return change >= kRange / 2 ? change - kRange : change;
}

}  // namespace

std::int32_t AnalogueFilter::Take(std::int32_t reading) {
  if (last_.size() < 5) {
    last_.push_back(reading);
  } else {
    last_[next_] = reading;
    next_ = (next_ + 1) % last_.size();
  }
  const std::int32_t middle = UpperMedian(last_);
  if (std::abs(middle - kept_) > TrackerTuning::kAnalogueStep) kept_ = middle;
  return kept_;
}

JointTracker::JointTracker(const Armature& armature, std::vector<SensorState> states)
    : armature_(armature), states_(std::move(states)) {
  states_.resize(armature.joints.size());
  sensors_.resize(armature.joints.size());
  values_.resize(armature.joints.size());
  for (std::size_t j = 0; j < states_.size(); ++j) Revalue(j);
}

void JointTracker::Begin(const BoxInfo& box, bool same_boot) {
  const std::vector<CardKind> kinds = box.KindOfSensors();
  for (std::size_t j = 0; j < sensors_.size(); ++j) {
    const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[j])];
    if (node.sensor >= box.sensors)
      throw InputError(fmt::format(
          "sensor {} of '{}' (line {} of the description) is beyond the controller's {} sensors; "
          "is a card missing?",
          node.sensor, node.name, node.line, box.sensors));
    sensors_[j] = {};
    sensors_[j].analogue = kinds[static_cast<std::size_t>(node.sensor)] == CardKind::kAnalogue;
    // Noise around the place where it was left is no move.
    if (sensors_[j].analogue) sensors_[j].filter = AnalogueFilter(states_[j].raw);
    // An analogue input knows where it is after a power-up, a counter begins at 0.
    if (!same_boot && !sensors_[j].analogue) states_[j].raw = 0;
    Revalue(j);
  }
  held_.clear();
}

bool JointTracker::Accept(std::size_t joint, std::int32_t raw, double asked_s, double answered_s) {
  Sensor& sensor = sensors_[joint];
  SensorState& state = states_[joint];
  if (sensor.analogue) raw = sensor.filter.Take(raw);
  const std::int32_t change = sensor.analogue ? raw - state.raw : WrappedChange(state.raw, raw);
  const double passed_s = std::max(0.0, answered_s - sensor.last_good_s);
  const double most = TrackerTuning::kSlack_counts +
                      TrackerTuning::kFastest_rev_s * armature_.counts_per_revolution * passed_s;
  const bool possible = sensor.unbounded || sensor.analogue || std::abs(change) <= most;
  if (!possible) return false;
  sensor.unbounded = false;
  sensor.last_good_s = asked_s;
  state.raw = raw;
  state.counts += change;
  if (change != 0) Revalue(joint);
  return true;
}

void JointTracker::Take(const std::vector<std::int32_t>& counts, double asked_s,
                        double answered_s) {
  held_.clear();
  for (std::size_t j = 0; j < states_.size(); ++j) {
    const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[j])];
    if (!Accept(j, counts[static_cast<std::size_t>(node.sensor)], asked_s, answered_s))
      held_.push_back(static_cast<int>(j));
  }
}

double JointTracker::StepOf(std::size_t joint) const {
  const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[joint])];
  const double a_turn =
      sensors_[joint].analogue ? kAnalogueCounts : armature_.counts_per_revolution;
  const double turns = 1 / (a_turn * node.scale * states_[joint].gear);
  return node.kind == NodeKind::kSlide ? turns : 2 * kPi * turns;
}

void JointTracker::Revalue(std::size_t joint) {
  values_[joint] = static_cast<double>(states_[joint].counts) * StepOf(joint);
}

void JointTracker::SetValue(std::size_t joint, double value) {
  states_[joint].counts = std::llround(value / StepOf(joint));
  Revalue(joint);
}

void JointTracker::SetGear(std::size_t joint, double gear) {
  states_[joint].gear = gear;
  Revalue(joint);
}

}  // namespace keypose::armature
