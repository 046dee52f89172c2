#include "capture/shoot/simulation/simulated_camera.h"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/turntable_device.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

class Simulated final : public SimulatedCamera {
 public:
  Simulated(const SimulatedWorld& world, FaultPlan& faults) : world_(world), faults_(faults) {}

  void SetPose(const DrawnPose& pose) override { pose_ = pose; }

  void Connect(Patience&) override {
    if (gone_ > 0) {
      --gone_;
      throw DeviceFault("camera-gone", "no camera is found",
                        "switch it on and plug its cable in; it goes on by itself", false);
    }
  }

  std::string Name() const override { return "simulated"; }

  Exposure Take(const fs::path& into, bool, Patience&) override {
    ++releases_;
    const auto due = [&](const char* kind) { return faults_.Due(kind, releases_); };
    if (due("battery"))
      throw DeviceFault("camera-battery", "the camera's battery is empty",
                        "put in a charged one, and switch the camera on", true);
    if (due("card-full"))
      throw DeviceFault("card-full", "the camera's memory card is full",
                        "empty it or put in another", true);
    if (due("grabbed"))
      throw DeviceFault("camera-grabbed", "another program holds the camera",
                        "close the desktop's window of the camera's files; it goes on by itself",
                        false);
    if (due("camera-unplugged")) {
      gone_ = 2;
      throw DeviceFault("camera-gone", "the camera does not answer",
                        "see whether its cable is in; it goes on by itself", false);
    }
    const int place = Place();
    Exposure exposure{{into / "SIM.JPG"}, kFirst + kBetween_s * (place + 1000 * world_.flip())};
    WriteFile(exposure.files[0], Bytes(place, due("half-file"), due("blurred")));
    return exposure;
  }

  std::optional<std::string> Preview() override { return ReadFile(FileOf(Place())); }

 private:
  static constexpr std::int64_t kFirst = 978307200;  // 2001-01-01T00:00:00Z
  static constexpr std::int64_t kBetween_s = 10;

  /// The place in the set of what the camera sees, from 0.
  int Place() const {
    const double steps = WithinTurn(world_.table_deg()) * pose_.angles / 360;
    const double off = std::abs(steps - std::round(steps)) * 360 / pose_.angles;
    const int index = static_cast<int>(std::lround(steps)) % pose_.angles;
    // A photograph of a table that still turns, or stands elsewhere, must not pass for a right one.
    if (off > 0.5)
      throw InputError("the simulated table stands " + std::to_string(off) +
                       " degrees off the drawn photographs");
    return (world_.ring() - 1) * pose_.angles + index;
  }

  fs::path FileOf(int place) const {
    char name[32];
    std::snprintf(name, sizeof name, "%s_%04d.jpg", world_.flip() > 0 ? "LYING" : "IMG", place + 1);
    return pose_.folder / name;
  }

  std::string Bytes(int place, bool half, bool blurred) const {
    const std::string bytes = ReadFile(FileOf(place));
    if (half) return bytes.substr(0, bytes.size() / 2);
    if (!blurred) return bytes;
    const Image8 image = ReadImage(FileOf(place), 3);
    const Image8 small = Resized(image, image.width / 6, image.height / 6);
    // Of this process: sessions may run side by side.
    const fs::path scratch =
        fs::temp_directory_path() / ("keypose_blurred_" + std::to_string(::getpid()) + ".jpg");
    WriteImage(scratch, Resized(small, image.width, image.height));
    std::string out = ReadFile(scratch);
    fs::remove(scratch);
    return out;
  }

  const SimulatedWorld& world_;
  FaultPlan& faults_;
  DrawnPose pose_;
  int releases_ = 0, gone_ = 0;
};

}  // namespace

std::unique_ptr<SimulatedCamera> MakeSimulatedCamera(const SimulatedWorld& world,
                                                     FaultPlan& faults) {
  return std::make_unique<Simulated>(world, faults);
}

}  // namespace keypose::capture::shoot
