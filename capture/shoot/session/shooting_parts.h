// What a session works with, and how.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "capture/shoot/devices/camera_device.h"
#include "capture/shoot/devices/turntable_device.h"
#include "capture/shoot/record/shot_plan.h"
#include "capture/shoot/record/side_file.h"
#include "capture/shoot/session/conversation.h"
#include "capture/shoot/session/wall_clock.h"

namespace keypose::capture::shoot {

struct ShootingOptions {
  std::filesystem::path project;  ///< absolute; made if it is not there
  std::string pose;
  ShotPlan plan;
  bool plan_given = false;     ///< by flags; else the pose's own plan goes on
  bool rings_given = false;    ///< of it; else few angles of a pose after the first are one ring
  std::string turntable_name;  ///< for the side file: none, grbl, steps, simulated
  double settle_s = 1;         ///< rest after a turn
  double retry_s = 2;          ///< between two attempts at a device that fails
  std::filesystem::path live_file;    ///< where frames of the live view go; empty: nowhere
  bool live = false;                  ///< live view is on from the start
  std::optional<CarriedWhite> white;  ///< from --white-balance
  bool forget_white = false;
  std::string again;            ///< a photograph or an angle to be shot again first
  bool begins_at_once = true;   ///< false: waits for the first `shoot`
  bool answers_itself = false;  ///< what is asked for is done at once (a simulated person)
  bool waits_for_devices =
      true;  ///< false: a device that cannot be opened at the start is an error
  bool stays_when_complete = false;  ///< waits for further commands
};

/// What a session works with. All must outlive it.
struct ShootingParts {
  CameraDevice& camera;
  TurntableDevice* turntable = nullptr;  ///< null: turned by hand
  Conversation& talk;
  const WallClock& clock;
  /// the person has done what `ask` asked for; for simulated worlds
  std::function<void(const std::string& ask, const Shot& shot, double angle_deg)> done_by_hand;
  /// a pose begins; for simulated worlds
  std::function<void(const std::string& pose, const ShotPlan& plan)> pose_begins;
};

}  // namespace keypose::capture::shoot
