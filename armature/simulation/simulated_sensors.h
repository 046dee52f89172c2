// Encoders on a simulated armature and the counters that watch them.
#pragma once

#include <cstdint>
#include <vector>

#include "armature/description/armature.h"
#include "armature/firmware/keypose_box.h"

namespace keypose::armature {

/// Counts all edges exactly, whatever the speed. Not thread-safe.
class SimulatedSensors final : public keypose_box::Sensors {
 public:
  /// @param armature  must outlive this
  /// @param gears     the true gear ratio of each joint over the description's; empty: 1
  explicit SimulatedSensors(const Armature& armature, std::vector<double> gears = {});

  int sensor_count() const { return static_cast<int>(shafts_.size()); }
  /// Turns the joints; encoders that are stuck do not count.
  void SetValues(const std::vector<double>& values);
  /// As after the box's power-up: all counters are 0, and know that they lost their counts.
  void LosePower();
  /// The same of one counter alone.
  void LosePower(int sensor);
  void SetStuck(int sensor, bool stuck);
  /// What is shown in place of the counter; 0 bits change nothing.
  void SetGlitch(int sensor, std::int32_t changed_bits);
  /// Counters 16 counts before an end of their range, as if they had been counting for long.
  void GoNearTheEnds();

  void Latch() override {}
  std::int32_t Count(std::uint16_t sensor) override;
  void SetCount(std::uint16_t sensor, std::int32_t count) override;
  std::uint8_t Flags(std::uint16_t sensor) override;

 private:
  struct Shaft {
    std::int64_t turned = 0;   ///< counts that the shaft truly stands at
    std::int64_t counter = 0;  ///< before it is cut to 24 bits
    bool stuck = false, lost = true;
    std::int32_t glitch = 0;
  };
  const Armature& armature_;
  std::vector<double> gears_;
  std::vector<Shaft> shafts_;
};

}  // namespace keypose::armature
