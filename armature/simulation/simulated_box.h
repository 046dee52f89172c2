// A controller box on a pseudo terminal: a thread that answers as the firmware does, and fails.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "armature/description/armature.h"
#include "armature/simulation/box_faults.h"
#include "armature/simulation/simulated_sensors.h"
#include "core/io/text/serial_port.h"

namespace keypose::armature {

struct SimulationOptions {
  std::vector<double> gears;  ///< true gear ratio of each joint over the description's
  std::vector<PlannedFault> faults;
  int boot = 1;  ///< number of the first power-up
  double unplugged_s = 0.5;
  double disturbed_s = 0.3;  ///< how long drops, noise and glitches last
  double speed_rev_s = 10;   ///< of the encoders' shafts in MoveTo
};

/// All functions may be called from any thread.
class SimulatedBox {
 public:
  /// Stands in the zero position at first.
  /// @param armature  must outlive this
  /// @param link      name of the port; an old link is replaced
  /// @throws DiskError  no pseudo terminal
  SimulatedBox(const Armature& armature, const std::filesystem::path& link,
               const SimulationOptions& options = {});
  ~SimulatedBox();
  SimulatedBox(const SimulatedBox&) = delete;
  SimulatedBox& operator=(const SimulatedBox&) = delete;

  /// Puts the joints there at once, as no hand could: for motions that are smooth by themselves.
  void SetValues(const std::vector<double>& values);
  /// Lets them turn there, no shaft faster than the options say.
  void MoveTo(const std::vector<double>& values);
  bool at_rest() const;
  /// Makes the faults that are planned for this frame, once each.
  void BeginFrame(int frame);
  /// Makes a fault now.
  void Make(const PlannedFault& fault);
  /// An encoder that was stuck counts again, from the count that it was stuck at.
  void Mend(int sensor);
  int boot() const { return boot_; }

 private:
  /// Replies, which go out when the request has been taken.
  class Wire final : public keypose_box::Line {
   public:
    void Put(std::uint8_t byte) override { bytes.push_back(static_cast<char>(byte)); }
    std::string bytes;
  };
  using Clock = std::chrono::steady_clock;

  void Run();
  void Turn(double passed_s);
  void Serve(const std::string& received);
  std::string Disturbed(std::string bytes);
  void EndOldFaults(Clock::time_point now);
  void PowerUp();

  mutable std::mutex mutex_;
  const Armature& armature_;
  SimulationOptions options_;
  std::filesystem::path link_;
  SimulatedSensors sensors_;
  std::vector<double> values_, targets_;
  std::vector<keypose_box::Card> cards_;
  Wire wire_;
  std::unique_ptr<keypose_box::Box> box_;
  PseudoTerminal terminal_;
  std::atomic<int> boot_;
  std::mt19937 random_{5};
  Clock::time_point drops_until_{}, noise_until_{}, glitch_until_{}, out_until_{}, last_byte_{};
  int glitched_ = -1;
  std::atomic<bool> ends_{false};
  std::thread thread_;
};

}  // namespace keypose::armature
