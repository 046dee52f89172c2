// A turntable of one's own, by the line protocol `steps:` of docs/shoot.md.
#pragma once

#include <filesystem>
#include <map>
#include <memory>

#include "capture/shoot/devices/turntable_device.h"

namespace keypose::capture::shoot {

/// How long the host waits, and how often it tries. Tests shorten them.
struct StepsTimes {
  double reply_s = 0.5;  ///< for a reply, before the line is repeated
  int repeats = 8;       ///< of a line
  double ask_s = 0.25;   ///< between two questions while the table turns
  double stall_s = 3;    ///< without a step while the table says that it turns
  int stalls = 3;        ///< starts of one turn
  double wake_up_s = 2;  ///< for a microcontroller that opening the port resets
};

std::unique_ptr<TurntableDevice> MakeStepsTurntable(const std::filesystem::path& device,
                                                    const StepsTimes& times = {});

}  // namespace keypose::capture::shoot
