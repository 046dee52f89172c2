#include <gphoto2/gphoto2-port-result.h>
#include <gphoto2/gphoto2-result.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <set>

#include "capture/shoot/devices/gphoto2_camera.h"
#include "core/io/text/files.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

/// The desktop's file manager mounts a camera by gvfs; KDE and photograph managers do the same.
const char* const kHowToFree =
    "close the desktop's window of the camera's files and eject the camera there, or type `gio "
    "mount -s gphoto2`; if that does not help, `pkill gvfs-gphoto2`. It goes on by itself";

std::string CommandOf(const fs::path& process) {
  try {
    std::string name = ReadFile(process / "comm");
    while (!name.empty() && name.back() == '\n') name.pop_back();
    return WithoutOddBytes(name);
  } catch (const std::exception&) {
    return "";  // it has ended meanwhile
  }
}

/// Whether one of the process's open files is a USB device.
bool HoldsUsb(const fs::path& process) {
  std::error_code denied;
  for (const auto& file : fs::directory_iterator(process / "fd", denied)) {
    std::error_code gone;
    if (fs::read_symlink(file.path(), gone).string().starts_with("/dev/bus/usb/")) return true;
  }
  return false;
}

}  // namespace

std::string HoldersOfUsbCameras() {
  std::set<std::string> holders;
  std::error_code ignored;
  const std::string self = fs::read_symlink("/proc/self", ignored).string();
  for (const auto& entry : fs::directory_iterator("/proc", ignored)) {
    const std::string pid = entry.path().filename().string();
    if (pid == self ||
        !std::all_of(pid.begin(), pid.end(), [](unsigned char c) { return std::isdigit(c); }))
      continue;
    const std::string command = CommandOf(entry.path());
    const bool by_name =
        command.starts_with("gvfs-gphoto2") || command.starts_with("gvfsd-gphoto2");
    if (by_name || HoldsUsb(entry.path())) holders.insert(command + " (process " + pid + ")");
  }
  std::string text;
  for (const std::string& holder : holders) text += (text.empty() ? "" : ", ") + holder;
  return text;
}

namespace {

DeviceFault Grabbed() {
  const std::string holders = HoldersOfUsbCameras();
  return DeviceFault("camera-grabbed",
                     "another program holds the camera" + (holders.empty() ? "" : ": " + holders),
                     kHowToFree, false);
}

DeviceFault NotFound() {
  return DeviceFault("camera-gone", "no camera is found",
                     "switch it on, plug its USB cable in, and set it to PTP or 'PC remote' where "
                     "its menu has that; it goes on by itself",
                     false);
}

DeviceFault Silent(const std::string& doing) {
  return DeviceFault("camera-gone", "the camera does not answer while it should " + doing,
                     "see whether its cable is in, its battery is charged, and it has not gone to "
                     "sleep (switch its power saving off); it goes on by itself",
                     false);
}

DeviceFault NotByCable(const std::string& doing) {
  return DeviceFault("camera-failed", "this camera cannot " + doing + " by cable",
                     "let a tethering program or your phone save its photographs in a folder, and "
                     "start with --camera folder:PATH",
                     true);
}

}  // namespace

DeviceFault FaultOfGphoto2(int error, const std::string& doing, const std::string& text) {
  switch (error) {
    case GP_ERROR_IO_USB_CLAIM:
    case GP_ERROR_IO_LOCK:
      return Grabbed();
    case GP_ERROR_MODEL_NOT_FOUND:
    case GP_ERROR_UNKNOWN_PORT:
    case GP_ERROR_IO_USB_FIND:
      return NotFound();
    case GP_ERROR_IO:
    case GP_ERROR_IO_READ:
    case GP_ERROR_IO_WRITE:
    case GP_ERROR_IO_INIT:
    case GP_ERROR_IO_UPDATE:
    case GP_ERROR_IO_USB_CLEAR_HALT:
    case GP_ERROR_TIMEOUT:
      return Silent(doing);
    case GP_ERROR_NO_SPACE:
    case GP_ERROR_NO_MEMORY:
      return DeviceFault("card-full", "the camera's memory card is full",
                         "empty it or put in another", true);
    case GP_ERROR_CAMERA_BUSY:
      return DeviceFault("camera-failed", "the camera is busy", "it is tried again by itself",
                         false);
    case GP_ERROR_NOT_SUPPORTED:
      return NotByCable(doing);
    default:
      return DeviceFault("camera-failed", "the camera could not " + doing + ": " + text,
                         "see what its screen says (focus not found, battery, card, lens cap); set "
                         "the lens to manual focus",
                         true);
  }
}

}  // namespace keypose::capture::shoot
