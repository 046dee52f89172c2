// Everything of a trial without hardware: the world, its camera, its turntable, and the hands that
// do what a session asks for.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "capture/shoot/devices/turntable_device.h"
#include "capture/shoot/simulation/firmware.h"
#include "capture/shoot/simulation/simulated_camera.h"

namespace keypose::capture::shoot {

/// What a pose's photographs are drawn for.
struct DrawnPlan {
  std::vector<double> rings_deg;
  int angles = 24;
  bool lying = false;
};

class SimulatedSet {
 public:
  /// @param folder  for the world, the port's link, and drawn photographs; made when needed
  /// @param faults  as ParseFaults reads them
  /// @throws UsageError  wrong faults
  SimulatedSet(const std::filesystem::path& folder, const std::string& faults);
  ~SimulatedSet();

  /// @param drawn  a folder that `keypose synth photos` has made with the plan's rings and angles;
  /// "": drawn when a pose begins
  std::unique_ptr<CameraDevice> MakeCamera(const std::string& drawn);
  /// @param protocol  grbl or steps; "" is steps
  std::unique_ptr<TurntableDevice> MakeTurntable(const std::string& protocol);

  /// Nothing happens without a simulated camera.
  /// @throws ToolError  the photographs cannot be drawn
  void PoseBegins(const std::string& pose, const DrawnPlan& plan);
  /// The world as it is after the person has done what was asked for.
  void DoneByHand(const std::string& ask, int ring, int flip, double angle_deg);

 private:
  std::filesystem::path Draw(const std::string& pose, const DrawnPlan& plan) const;

  std::filesystem::path folder_, drawn_;
  FaultPlan faults_;
  std::unique_ptr<SimulatedWorld> world_;  // made with the first simulated device
  SimulatedCamera* camera_ = nullptr;
  std::unique_ptr<Firmware> firmware_;
  SimulatedWorld& World();
};

}  // namespace keypose::capture::shoot
