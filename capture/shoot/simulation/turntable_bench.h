// A simulated turntable on the bench, for tests.
#pragma once

#include <cmath>
#include <string>

#include "capture/shoot/devices/turntable_device.h"
#include "capture/shoot/simulation/firmware.h"
#include "core/testing/folder.h"

namespace keypose::capture::shoot {

/// A firmware of one protocol, with faults, and where its table really stands.
struct TurntableBench {
  TurntableBench(std::unique_ptr<Protocol> protocol, const std::string& planned)
      : world(""), faults(ParseFaults(planned)) {
    firmware = std::make_unique<Firmware>(std::move(protocol), world, faults, folder / "port");
  }

  /// How far the table really stands from an angle [deg].
  double Off(double angle_deg) const {
    const double off = WithinTurn(world.table_deg() - angle_deg);
    return std::min(off, 360 - off);
  }

  TestingFolder own;
  const fs::path folder = own.path();
  SimulatedWorld world;
  FaultPlan faults;
  std::unique_ptr<Firmware> firmware;
  PlainPatience patience;
};

}  // namespace keypose::capture::shoot
