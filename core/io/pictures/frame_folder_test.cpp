#include "core/io/pictures/frame_folder.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::frame_folder_test {

class FrameFolder : public ::testing::Test, public TestingFolder {};

TEST_F(FrameFolder, FramesComeByNumberAndAGapIsAnError) {
  for (const int frame : {2, 0, 1}) Put(FrameFileName(frame), "x");
  const auto frames = NumberedFrames(folder_, "export");
  ASSERT_EQ(frames.size(), 3u);
  EXPECT_EQ(frames[2].filename(), "frame_0002.ply");
  Put(FrameFileName(4), "x");
  EXPECT_THROW(NumberedFrames(folder_, "export"), InputError);
  EXPECT_THROW(NumberedFrames(folder_ / "absent", "export"), InputError);
}

TEST_F(FrameFolder, TimesAreThoseOfTheNotesAndGoWithTheirFrames) {
  Put("distortion.json",
      R"({"fps": 25, "key_frames": [0, 2], "frames": [{"t": 0}, {"t": 0.4}, {"t": 1}]})");
  const FrameTimes times = ReadFrameTimes(folder_, 3);
  EXPECT_EQ(times.fps, 25);
  EXPECT_EQ(times.key_frames, (std::vector<int>{0, 2}));
  EXPECT_EQ(times.t, (std::vector<double>{0, 0.4, 1}));
  EXPECT_TRUE(ReadFrameTimes(folder_, 4).t.empty());
}

TEST_F(FrameFolder, NotesOfAMotionHaveItsRateAndNoKeys) {
  EXPECT_EQ(FrameRateOf(folder_), 0);
  Put("distortion.json", FrameNotesText({{1, 1}, {1.1, 0.9}, {1, 1}}, 25, "transfer"));
  EXPECT_EQ(FrameRateOf(folder_), 25);
  EXPECT_TRUE(ReadFrameTimes(folder_, 3).key_frames.empty());
}

TEST_F(FrameFolder, NotesThatAreNoneAreAnError) {
  Put("distortion.json", "[");
  EXPECT_THROW(ReadFrameTimes(folder_, 3), InputError);
}

}  // namespace keypose::frame_folder_test
