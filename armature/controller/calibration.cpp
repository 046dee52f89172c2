#include "armature/controller/calibration.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

using nlohmann::json;

const ArmatureNode& NodeOf(const Armature& armature, std::size_t joint) {
  return armature.nodes[static_cast<std::size_t>(armature.joints[joint])];
}

SensorState StateOf(const json& entry) {
  SensorState state;
  state.counts = entry.at("counts").get<std::int64_t>();
  state.raw = entry.at("raw").get<std::int32_t>() & 0xFFFFFF;
  state.gear = entry.value("gear", 1.0);
  if (!(std::abs(state.gear - 1) < 0.5))
    throw InputError(
        fmt::format("a gear of {} cannot be; it is the true ratio over the "
                    "description's, near 1",
                    state.gear));
  return state;
}

}  // namespace

std::string CalibrationText(const Armature& armature, const Calibration& calibration) {
  json sensors = json::object();
  for (std::size_t j = 0; j < armature.joints.size(); ++j) {
    const SensorState& state = calibration.sensors[j];
    sensors[NodeOf(armature, j).name] = {{"sensor", NodeOf(armature, j).sensor},
                                         {"counts", state.counts},
                                         {"raw", state.raw},
                                         {"gear", state.gear}};
  }
  const json whole = {{"schema", 1}, {"boot", calibration.boot}, {"joints", sensors}};
  return whole.dump(1) + "\n";
}

Calibration FittingCalibration(const std::string& text, const std::string& file,
                               const Armature& armature, std::vector<std::string>* fresh) {
  RequireShallowJson(text, file);
  Calibration calibration;
  try {
    const json whole = json::parse(text);
    calibration.boot = whole.at("boot").get<int>();
    const json& joints = whole.at("joints");
    for (std::size_t j = 0; j < armature.joints.size(); ++j) {
      const ArmatureNode& node = NodeOf(armature, j);
      const bool fits = joints.contains(node.name) && joints[node.name].at("sensor") == node.sensor;
      calibration.sensors.push_back(fits ? StateOf(joints[node.name]) : SensorState{});
      if (!fits) fresh->push_back(node.name);
    }
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: it is not a calibration of `keypose armature calibrate`: {}",
                                 file, JsonFault(error)));
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", file, error.what()));
  }
  return calibration;
}

Calibration ParseCalibration(const std::string& text, const std::string& file,
                             const Armature& armature) {
  std::vector<std::string> fresh;
  const Calibration calibration = FittingCalibration(text, file, armature, &fresh);
  if (fresh.empty()) return calibration;
  const ArmatureNode& node = armature.nodes[static_cast<std::size_t>(armature.Find(fresh[0]))];
  throw InputError(
      fmt::format("{}: it has no joint '{}' with sensor {}; it was made for another description: "
                  "calibrate again",
                  file, node.name, node.sensor));
}

}  // namespace keypose::armature
