// Asks the person for what no device can do, and cares for devices that fail.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "capture/shoot/session/announcer.h"
#include "capture/shoot/session/setup_state.h"
#include "capture/shoot/session/shooting_parts.h"
#include "capture/shoot/session/user_requests.h"

namespace keypose::capture::shoot {

class Helper {
 public:
  /// All must outlive this.
  Helper(const ShootingOptions& options, const ShootingParts& parts, Announcer& announcer,
         UserRequests& requests, const std::filesystem::path& state_file);

  /// The pose at work; before all else.
  void SetBook(ShotBook* book) { book_ = book; }

  /// Asks for something to be done by hand, and waits until it is.
  /// @throws Rethink, EndAsked, Cancelled
  void Ask(const std::string& ask, const std::string& words, const std::string& what_to_do,
           std::optional<double> angle_deg = std::nullopt);
  /// The photograph that came by the camera's own button while the table was to be turned.
  std::optional<Exposure> TakeOwnRelease() { return std::exchange(own_release_, std::nullopt); }

  using Attempt = std::function<void()>;
  /// Opens the devices at the start.
  /// @throws ToolError  one cannot be opened, and nobody waits for it
  void ConnectAll();
  /// Tries until it works: tells a fault once, waits or asks, connects again.
  void WithCamera(const Attempt& attempt);
  void WithTable(const Attempt& attempt);

  /// The table stands there, as the person says.
  void TableIsAt(double angle_deg);
  void SaveSetupState() const { WriteSetupState(state_file_, setup_state); }
  /// A frame of the live view, if it is on and time for one.
  void LiveFrame();

  SetupState setup_state;

 private:
  void ConnectTable();
  void SetTableByHand(double angle_deg);
  void Start(const Attempt& connect, const char* device);
  void Through(const Attempt& attempt, const Attempt& connect, const char* device, bool connected);
  bool OwnRelease();

  const ShootingOptions& options_;
  const ShootingParts& parts_;
  Announcer& announcer_;
  UserRequests& requests_;
  std::filesystem::path state_file_;
  ShotBook* book_ = nullptr;
  std::optional<Exposure> own_release_;
  double last_live_ = -1;
  int live_frames_ = 0;
};

}  // namespace keypose::capture::shoot
