// A camera on USB, by libgphoto2.
#pragma once

#include <memory>
#include <string>

#include "capture/shoot/devices/camera_device.h"
#include "capture/shoot/devices/device_fault.h"

namespace keypose::capture::shoot {

/// The first camera that is found. Settings stay as they are on the camera.
std::unique_ptr<CameraDevice> MakeGphoto2Camera();

/// What an error of libgphoto2 means for the person, by its number (GP_ERROR_...).
/// @param doing  what was tried, such as "release the shutter"
/// @param text   libgphoto2's own words, for errors without better ones
DeviceFault FaultOfGphoto2(int error, const std::string& doing, const std::string& text);

/// Programs that hold a USB camera, as far as this user may see: "gvfs-gphoto2-volume-monitor
/// (process 1234)"; empty if unknown.
std::string HoldersOfUsbCameras();

}  // namespace keypose::capture::shoot
