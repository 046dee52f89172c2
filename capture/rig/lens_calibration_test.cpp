#include "capture/rig/lens_calibration.h"

#include <gtest/gtest.h>

#include "capture/rig/testing/boards_in_room.h"

namespace keypose::capture::lens_calibration_test {

TEST(CalibrateLens, ABoardThatIsNoneIsLeftOut) {
  Room room = MakeRoom(1, 24, 0.05);
  for (BoardSighting& s : room.sightings)
    if (s.frame == 7 || s.frame == 11)
      for (BoardCorner& c : s.corners)
        c.pixel += Eigen::Vector2d(Wobble(c.id, 9), Wobble(-c.id, 9));
  const CalibratedLens lens = CalibrateLens(room.sightings, 0, room.cameras[0], room.board, 60);
  EXPECT_EQ(lens.left_out, 2);
  EXPECT_EQ(lens.boards, 22);
  EXPECT_NEAR(lens.camera.fx, room.views[0].camera.fx, 3);
  EXPECT_LT(lens.rms_px, 0.1);
}

}  // namespace keypose::capture::lens_calibration_test
