#include "capture/rig/rig_calibrator.h"

#include <gtest/gtest.h>

#include "capture/rig/testing/boards_in_room.h"
#include "core/values/errors.h"

namespace keypose::capture::rig_calibrator_test {

TEST(CalibrateRig, ExactCornersGiveTheCamerasBack) {
  const Room room = MakeRoom(4, 30, 0);
  const RigResult result = CalibrateRig(room.sightings, room.cameras, room.board, {});
  for (int c = 0; c < 4; ++c) {
    // OpenCV's first estimate works on single-precision pixels; the adjustment removes its errors.
    EXPECT_LT((result.views[c].Center() - room.views[c].Center()).norm(), 1e-5);
    EXPECT_NEAR(result.views[c].camera.fx, room.views[c].camera.fx, 1e-2);
    EXPECT_NEAR(result.views[c].camera.cx, room.views[c].camera.cx, 1e-2);
    EXPECT_NEAR(result.views[c].camera.k1, room.views[c].camera.k1, 1e-4);
    EXPECT_LT(result.cameras[c].rms_px, 1e-3);
  }
}

TEST(CalibrateRig, NoiseOfATenthOfAPixelMovesCamerasByMillimetres) {
  const Room room = MakeRoom(4, 40, 0.1);
  const RigResult result = CalibrateRig(room.sightings, room.cameras, room.board, {});
  // two coordinates of 0.1 px each
  EXPECT_NEAR(result.rms_px, 0.141, 0.02);
  for (int c = 0; c < 4; ++c) {
    EXPECT_LT((result.views[c].Center() - room.views[c].Center()).norm(), 0.004);
    EXPECT_GT(result.cameras[c].coverage, 0.3);
    EXPECT_EQ(result.cameras[c].boards, result.cameras[c].shared);
  }
}

TEST(CalibrateRig, ACameraThatSawNothingWithTheOthersIsNamed) {
  Room room = MakeRoom(3, 24, 0);
  for (BoardSighting& s : room.sightings)
    if (s.camera == 2) s.frame += 1000;
  try {
    CalibrateRig(room.sightings, room.cameras, room.board, {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cam3 never saw"), std::string::npos);
  }
}

TEST(CalibrateRig, TooFewBoardsAndNoFloorAreErrors) {
  Room room = MakeRoom(2, 20, 0);
  EXPECT_THROW(CalibrateRig({room.sightings.begin(), room.sightings.begin() + 4}, room.cameras,
                            room.board, {}),
               InputError);
  RigCalibratorOptions options;
  options.floor_frame = 99;
  EXPECT_THROW(CalibrateRig(room.sightings, room.cameras, room.board, options), InputError);
}

/// The same boards, some of them numbered from another corner that looks the same.
void TurnSome(int turns, Room* room) {
  const int columns = room->board.columns - 1, rows = room->board.rows - 1;
  int count = 0;
  for (BoardSighting& s : room->sightings) {
    const int quarters = ++count * 7 % turns * (4 / turns);
    for (BoardCorner& corner : s.corners) {
      int column = corner.id % columns, row = corner.id / columns;
      if (quarters == 2) column = columns - 1 - column, row = rows - 1 - row;
      if (quarters % 2 == 1) std::swap(column, row);
      if (quarters == 1) column = columns - 1 - column;
      if (quarters == 3) row = rows - 1 - row;
      corner.id = row * columns + column;
    }
  }
}

TEST(CalibrateRig, CheckerboardsThatLookTheSameTurnedGiveTheCamerasBack) {
  for (const int turns : {2, 4}) {
    Room room = MakeRoom(4, 30, 0);
    if (turns == 4) room = MakeRoom(4, 30, 0, {7, 7, 0.06, 0.045});
    TurnSome(turns, &room);
    RigCalibratorOptions options;
    options.turns = turns;
    const RigResult result = CalibrateRig(room.sightings, room.cameras, room.board, options);
    EXPECT_LT(result.rms_px, 1e-3) << turns;
    // the board on the floor may be turned, so distances are compared
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < a; ++b)
        EXPECT_NEAR((result.views[a].Center() - result.views[b].Center()).norm(),
                    (room.views[a].Center() - room.views[b].Center()).norm(), 1e-4)
            << turns;
  }
}

TEST(CalibrateRig, ABoardThatLooksTheSameTurnedInOnePlaceOnlyIsRefused) {
  Room room = MakeRoom(2, 20, 0);
  for (BoardSighting& s : room.sightings)
    if (s.camera == 1 && s.frame > 0) s.frame += 1000;
  RigCalibratorOptions options;
  options.turns = 2;
  try {
    CalibrateRig(room.sightings, room.cameras, room.board, options);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the same after a half turn"), std::string::npos);
  }
}

TEST(CalibrateRig, KnownLensesStayAndOneBoardIsEnoughForPlaces) {
  Room room = MakeRoom(3, 1, 0);
  RigCalibratorOptions options;
  for (const View& view : room.views) options.lenses.push_back(view.camera);
  const RigResult result = CalibrateRig(room.sightings, room.cameras, room.board, options);
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT((result.views[c].Center() - room.views[c].Center()).norm(), 1e-5);
    EXPECT_EQ(result.views[c].camera.fx, room.views[c].camera.fx);
  }
}

TEST(CalibrateRig, PartsOfACheckerboardCountForTheLensOnly) {
  Room room = MakeRoom(2, 30, 0);
  for (BoardSighting& s : room.sightings)
    if (s.frame % 3 == 1) {
      // the last column is out of sight, and numbers begin one column early
      s.partial = true;
      std::erase_if(s.corners, [](const BoardCorner& c) { return c.id % 8 == 0; });
      for (BoardCorner& corner : s.corners) --corner.id;
    }
  const RigResult result = CalibrateRig(room.sightings, room.cameras, room.board, {});
  EXPECT_LT((result.views[1].Center() - room.views[1].Center()).norm(), 1e-5);
  EXPECT_EQ(result.cameras[0].boards, 20);
}

}  // namespace keypose::capture::rig_calibrator_test
