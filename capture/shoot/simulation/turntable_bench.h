// A simulated turntable on the bench, for tests.
#pragma once

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "capture/shoot/devices/turntable.h"
#include "capture/shoot/simulation/firmware.h"

namespace keypose::capture::shoot {

/// A firmware of one protocol, with faults, and where its table really stands.
struct TurntableBench {
  TurntableBench(std::unique_ptr<Protocol> protocol, const std::string& planned)
      : folder(std::filesystem::temp_directory_path() /
               ("keypose_table_" + std::to_string(::getpid()))),
        world(""),
        faults(ParseFaults(planned)) {
    std::filesystem::create_directories(folder);
    firmware = std::make_unique<Firmware>(std::move(protocol), world, faults, folder / "port");
  }
  ~TurntableBench() {
    firmware.reset();
    std::filesystem::remove_all(folder);
  }

  /// How far the table really stands from an angle [deg].
  double Off(double angle_deg) const {
    const double off = WithinTurn(world.table_deg() - angle_deg);
    return std::min(off, 360 - off);
  }

  std::filesystem::path folder;
  SimulatedWorld world;
  FaultPlan faults;
  std::unique_ptr<Firmware> firmware;
  PlainPatience patience;
};

}  // namespace keypose::capture::shoot
