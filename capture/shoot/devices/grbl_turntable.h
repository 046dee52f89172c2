// A turntable that is an axis of a GRBL 1.1 controller.
// Source: the GRBL wiki, "Grbl v1.1 Interface" and "Grbl v1.1 Commands".
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "capture/shoot/devices/turntable_device.h"

namespace keypose::capture::shoot {

struct GrblOptions {
  char axis = 'X';              ///< one of X, Y, Z
  double degrees_per_unit = 1;  ///< > 0; the table's turn for one unit (GRBL: a millimetre)
  double speed_deg_s = 30;      ///< > 0
};

/// How long the host waits. Tests shorten them.
struct GrblTimes {
  double wake_up_s = 2;  ///< for the greeting, when opening the port resets the controller
  double reply_s = 2;    ///< for `ok`, before the line is sent again
  int repeats = 8;       ///< of a line
  double ask_s = 0.2;    ///< between two `?` while the table turns
  double stall_s = 3;    ///< without motion while the controller says that it runs
  int stalls = 3;        ///< starts of one turn
};

/// What `?` tells: "<Run|MPos:12.000,0.000,0.000|FS:500,0|WCO:1.000,0.000,0.000>".
struct GrblStatus {
  std::string state;            ///< Idle, Run, Hold, Alarm, ...
  double machine_position = 0;  ///< of the axis [units]
  bool has_machine_position = false;
  double work_position = 0;  ///< only with `$10=0`
  bool has_work_position = false;
  double offset = 0;  ///< only in some reports: machine minus work position
  bool has_offset = false;
};

/// @return whether the line is a status report with a state
bool ParseGrblStatus(const std::string& line, char axis, GrblStatus* status);

std::unique_ptr<TurntableDevice> MakeGrblTurntable(const std::filesystem::path& device,
                                                   const GrblOptions& options,
                                                   const GrblTimes& times = {});

}  // namespace keypose::capture::shoot
