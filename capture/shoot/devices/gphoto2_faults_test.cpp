#include <gphoto2/gphoto2-port-result.h>
#include <gphoto2/gphoto2-result.h>
#include <gtest/gtest.h>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/gphoto2_camera.h"

namespace keypose::capture::shoot::gphoto2_faults_test {

TEST(FaultOfGphoto2, SaysWhoHoldsTheCameraAndHowToFreeIt) {
  const DeviceFault fault = FaultOfGphoto2(GP_ERROR_IO_USB_CLAIM, "be opened", "");
  EXPECT_EQ(fault.code, "camera-grabbed");
  EXPECT_NE(fault.what_to_do.find("gio mount -s gphoto2"), std::string::npos);
  EXPECT_NE(fault.what_to_do.find("pkill gvfs-gphoto2"), std::string::npos);
  EXPECT_FALSE(fault.needs_hand);
}

TEST(FaultOfGphoto2, HasAKindAndAdviceForEveryNumber) {
  const std::pair<int, const char*> kinds[] = {{GP_ERROR_MODEL_NOT_FOUND, "camera-gone"},
                                               {GP_ERROR_IO, "camera-gone"},
                                               {GP_ERROR_TIMEOUT, "camera-gone"},
                                               {GP_ERROR_NO_SPACE, "card-full"},
                                               {GP_ERROR_CAMERA_BUSY, "camera-failed"},
                                               {GP_ERROR_NOT_SUPPORTED, "camera-failed"},
                                               {GP_ERROR, "camera-failed"},
                                               {-1000000, "camera-failed"}};
  for (const auto& [number, code] : kinds) {
    const DeviceFault fault = FaultOfGphoto2(number, "release the shutter", "words");
    EXPECT_EQ(fault.code, code) << number;
    EXPECT_FALSE(fault.what_to_do.empty()) << number;
  }
}

}  // namespace keypose::capture::shoot::gphoto2_faults_test
