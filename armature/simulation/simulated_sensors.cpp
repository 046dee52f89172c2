#include "armature/simulation/simulated_sensors.h"

#include <cmath>

#include "core/values/angles.h"

namespace keypose::armature {

SimulatedSensors::SimulatedSensors(const Armature& armature, std::vector<double> gears)
    : armature_(armature), gears_(std::move(gears)) {
  gears_.resize(armature.joints.size(), 1);
  shafts_.resize(static_cast<std::size_t>(armature.sensor_count()));
}

void SimulatedSensors::SetValues(const std::vector<double>& values) {
  for (std::size_t j = 0; j < armature_.joints.size(); ++j) {
    const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[j])];
    const double turns =
        values[j] * node.scale * gears_[j] / (node.kind == NodeKind::kSlide ? 1 : 2 * kPi);
    Shaft& shaft = shafts_[static_cast<std::size_t>(node.sensor)];
    const std::int64_t before = shaft.turned;
    shaft.turned = std::llround(turns * armature_.counts_per_revolution);
    if (!shaft.stuck) shaft.counter += shaft.turned - before;
  }
}

void SimulatedSensors::LosePower() {
  for (int sensor = 0; sensor < sensor_count(); ++sensor) LosePower(sensor);
}

void SimulatedSensors::LosePower(int sensor) {
  Shaft& shaft = shafts_[static_cast<std::size_t>(sensor)];
  shaft.counter = 0;
  shaft.lost = true;
}

void SimulatedSensors::SetStuck(int sensor, bool stuck) {
  shafts_[static_cast<std::size_t>(sensor)].stuck = stuck;
}

void SimulatedSensors::SetGlitch(int sensor, std::int32_t changed_bits) {
  shafts_[static_cast<std::size_t>(sensor)].glitch = changed_bits;
}

void SimulatedSensors::GoNearTheEnds() {
  // By turns the end of the unsigned and of the signed range, from below and from above.
  static constexpr std::int64_t kPlaces[] = {0xFFFFF0, 0x7FFFF0, 0x10, 0x800010};
  for (std::size_t s = 0; s < shafts_.size(); ++s) shafts_[s].counter = kPlaces[s % 4];
}

std::int32_t SimulatedSensors::Count(std::uint16_t sensor) {
  const Shaft& shaft = shafts_[sensor];
  return (static_cast<std::int32_t>(shaft.counter & 0xFFFFFF) ^ shaft.glitch) & 0xFFFFFF;
}

void SimulatedSensors::SetCount(std::uint16_t sensor, std::int32_t count) {
  shafts_[sensor].counter = count;
  shafts_[sensor].lost = false;
}

std::uint8_t SimulatedSensors::Flags(std::uint16_t sensor) {
  return shafts_[sensor].lost ? keypose_box::kLostCount : 0;
}

}  // namespace keypose::armature
