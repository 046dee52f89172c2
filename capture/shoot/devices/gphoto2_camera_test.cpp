#include "capture/shoot/devices/gphoto2_camera.h"

#include <gphoto2/gphoto2-port-result.h>
#include <gphoto2/gphoto2-result.h>
#include <gtest/gtest.h>

#include "capture/shoot/devices/device_fault.h"

namespace keypose::capture::shoot::gphoto2_camera_test {

TEST(Gphoto2Camera, WithoutACameraSaysWhatToPlugIn) {
  const auto camera = MakeGphoto2Camera();
  PlainPatience patience;
  try {
    camera->Connect(patience);
    GTEST_SKIP() << "a camera is plugged into this machine";
  } catch (const DeviceFault& fault) {
    if (fault.code == "camera-grabbed") GTEST_SKIP() << "a camera is plugged into this machine";
    EXPECT_EQ(fault.code, "camera-gone");
    EXPECT_NE(fault.what_to_do.find("USB"), std::string::npos);
  }
}

}  // namespace keypose::capture::shoot::gphoto2_camera_test
