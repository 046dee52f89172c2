// A camera, as a session needs it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "capture/shoot/devices/patience.h"

namespace keypose::capture::shoot {

/// One release of the shutter: one file, or a RAW file and a JPEG.
struct Exposure {
  std::vector<std::filesystem::path> files;  ///< where they were put, with the camera's extensions
  /// seconds since 1970 for a camera with a clock of its own (the simulated one); else it is the
  /// moment of landing
  std::optional<std::int64_t> time;
};

class CameraDevice {
 public:
  virtual ~CameraDevice() = default;

  /// Finds the camera, or finds it again after a fault.
  /// @throws DeviceFault  there is none, or another program holds it
  virtual void Connect(Patience& patience) = 0;
  /// Maker and model, or the folder; for the side file.
  virtual std::string Name() const = 0;
  /// Releases the shutter and fetches the files.
  /// @param into  an empty folder to put them in
  /// @param fetch_again  the last photograph came in halves: fetch it again where possible, without
  /// a new release
  /// @throws DeviceFault
  virtual Exposure Take(const std::filesystem::path& into, bool fetch_again,
                        Patience& patience) = 0;
  /// A photograph that came without Take: by the camera's own button. Returns at once.
  virtual std::optional<Exposure> Arrived(const std::filesystem::path& into, Patience& patience) {
    (void)into;
    (void)patience;
    return std::nullopt;
  }
  /// Photographs only ever arrive: somebody else releases the shutter.
  virtual bool OnlyArrives() const { return false; }
  /// Sets the focus for photograph `i` of `count` of a focus stack, near to far. False: it cannot,
  /// and the person has to.
  virtual bool Focus(int i, int count, Patience& patience) {
    (void)i;
    (void)count;
    (void)patience;
    return false;
  }
  /// A small JPEG of what the camera sees; nothing if it has no live view.
  virtual std::optional<std::string> Preview() { return std::nullopt; }
};

}  // namespace keypose::capture::shoot
