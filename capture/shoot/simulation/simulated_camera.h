// A camera that hands out photographs of a simulated world: those of the angle at which the table
// really stands, and not of the angle that was asked for.
#pragma once

#include <filesystem>
#include <memory>

#include "capture/shoot/devices/camera_device.h"
#include "capture/shoot/simulation/fault_plan.h"
#include "capture/shoot/simulation/simulated_world.h"

namespace keypose::capture::shoot {

/// The photographs of a pose as `keypose synth photos` draws them: IMG_0001.jpg, ... ring after
/// ring, LYING_0001.jpg, ... on its side.
struct DrawnPose {
  std::filesystem::path folder;
  int angles = 24;  ///< of a ring
};

/// A camera whose drawn poses are told by SetPose.
class SimulatedCamera : public CameraDevice {
 public:
  /// What it photographs from here on.
  virtual void SetPose(const DrawnPose& pose) = 0;
};

/// Each photograph has a fixed time: that of its place in the set.
std::unique_ptr<SimulatedCamera> MakeSimulatedCamera(const SimulatedWorld& world,
                                                     FaultPlan& faults);

}  // namespace keypose::capture::shoot
