// What a session tells: the events of docs/shoot.md.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/session/conversation.h"
#include "capture/shoot/session/shot_book.h"

namespace keypose::capture::shoot {

class Announcer {
 public:
  /// @param talk     must outlive this
  /// @param project  paths in events are relative to it
  Announcer(Conversation& talk, const std::filesystem::path& project);

  /// @param onion      the folder of the pose that was shot before; empty if there is none
  /// @param bent_from  the template that is bent into this pose's few photographs, or ""
  void PoseOpened(const ShotBook& book, const std::filesystem::path& onion,
                  const std::string& bent_from);
  /// Told only when something in it has changed.
  void State(const std::string& state, const ShotBook& book, const Shot& target);
  void Asked(const std::string& ask, const std::string& words, const std::string& what_to_do,
             const double* angle_deg);
  void Landed(const ShotBook& book, const Shot& shot, bool again, const std::vector<Shot>& changed);
  void RingChecked(const ShotBook& book, const Shot& first);
  void Fault(const DeviceFault& fault);
  void Recovered(const std::string& fault_code, const std::string& device);
  void Frame(const std::filesystem::path& file, int number, int width, int height);
  /// @param refusal  why not; "" for a command that is carried out
  void Answer(const Command& command, const std::string& refusal);
  void PoseDone(const ShotBook& book);
  void Ended(const ShotBook& book);

 private:
  std::string Shown(const std::filesystem::path& path) const;
  std::string OnionOf(const std::string& name) const;

  Conversation& talk_;
  std::filesystem::path project_, onion_;
  nlohmann::json last_state_;
};

}  // namespace keypose::capture::shoot
