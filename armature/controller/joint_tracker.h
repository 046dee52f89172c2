// From counters that wrap, jump and forget to the joints' values.
//
// A counter has 24 bits: with 1,024 counts a revolution it wraps after 16,384 revolutions of its
// encoder. Its change between two readings is taken modulo 2^24, so that a wrap in either direction
// is nothing special while the change is less than half of that.
// Source: Knep et al., CHI 1995, "Controller box". The filter for jumps is our own.
#pragma once

#include <cstdint>
#include <vector>

#include "armature/controller/box_link.h"
#include "armature/description/armature.h"
#include "core/values/tuned.h"

namespace keypose::armature {

/// What must be kept of a sensor while nobody reads it.
struct SensorState {
  std::int64_t counts = 0;  ///< of its encoder from the joint's zero position, all turns
  std::int32_t raw = 0;     ///< of its counter at the same moment, low 24 bits
  double gear = 1;          ///< the true gear ratio over the description's, near 1
};

/// Chosen for encoders of 1,024 counts; no hand turns a shaft as fast.
struct TrackerTuning {
  KEYPOSE_TUNED(double, kFastest_rev_s, 20);  ///< of an encoder's shaft; faster is a fault
  KEYPOSE_TUNED(double, kSlack_counts, 8);    ///< that a shaft may jump at any time
  KEYPOSE_TUNED(double, kAnalogueStep, 96);   ///< of 65,536: a smaller change is noise
};

/// An analogue input's readings, quiet while nothing moves.
class AnalogueFilter {
 public:
  AnalogueFilter() = default;
  /// @param kept  the reading at which the joint was left
  explicit AnalogueFilter(std::int32_t kept) : kept_(kept) {}
  /// @return the last reading that was more than noise
  std::int32_t Take(std::int32_t reading);

 private:
  std::vector<std::int32_t> last_;  ///< five readings, of which the median counts
  std::size_t next_ = 0;
  std::int32_t kept_ = 0;
};

/// For each of an armature's joints its sensor's count and its value.
class JointTracker {
 public:
  /// @param states  one for each joint; empty: all in the zero position
  explicit JointTracker(const Armature& armature, std::vector<SensorState> states = {});

  /// A controller is read from now on.
  /// @param same_boot  its counters have run on since the states' `raw`; else they began at 0, and
  ///                   the armature is taken to stand as it did
  /// @throws InputError  a joint's sensor is beyond the box's
  void Begin(const BoxInfo& box, bool same_boot);
  /// @param counts  of all sensors of the box, low 24 bits
  /// @param asked_s, answered_s  moments between which they were read; they never run backwards.
  ///                Both, since this program may have been stopped for a while between them.
  void Take(const std::vector<std::int32_t>& counts, double asked_s, double answered_s);

  /// From the zero position, in the order of `armature.joints`: [rad], slides [m].
  const std::vector<double>& values() const { return values_; }
  const std::vector<SensorState>& states() const { return states_; }
  /// Joints whose counter jumped farther than a shaft can turn: they are held until it is back, or
  /// until the jump could have been a turn.
  const std::vector<int>& held() const { return held_; }
  /// Declares that the joint stands at this value now.
  void SetValue(std::size_t joint, double value);
  void SetGear(std::size_t joint, double gear);
  /// Its counter lost its power and began at 0; the joint is taken to stand as it did.
  void CountsFromZero(std::size_t joint) { states_[joint].raw = 0; }
  /// What one count means: [rad] of the joint, or [m] of a slide.
  double StepOf(std::size_t joint) const;

 private:
  struct Sensor {
    bool analogue = false, unbounded = true;
    double last_good_s = 0;
    AnalogueFilter filter;
  };
  bool Accept(std::size_t joint, std::int32_t raw, double asked_s, double answered_s);
  void Revalue(std::size_t joint);

  const Armature& armature_;
  std::vector<SensorState> states_;
  std::vector<Sensor> sensors_;
  std::vector<double> values_;
  std::vector<int> held_;
};

}  // namespace keypose::armature
