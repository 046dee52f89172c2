// Options of keypose-track.
#pragma once

#include <string>

#include "core/values/options.h"
#include "motion/films/track_input.h"

namespace keypose::motion {

struct TrackOptions {
  int actor_frame = 0;
  int actor_frames = 12;
  std::string cameras;
  std::string up = "auto";
  double height_m = 0;
  double fps = 0;
  int sync_frames = 10;
  double calm = 1;
  std::string clock_offsets = "auto";

  void Describe(OptionVisitor& visit) {
    visit("actor_frame", actor_frame,
          {"the frame that the actor's lengths and girths are fitted to first: one in which the "
           "limbs are apart",
           "",
           0,
           1e6,
           {}});
    visit("actor_frames", actor_frames,
          {"frames over the whole performance that lengths and girths are fitted to then; 1: only "
           "that one, as in the paper",
           "",
           1,
           60,
           {}});
    visit(
        "cameras", cameras,
        {.help = "names of the cameras that are used, comma-separated; empty: all. The others are "
                 "only compared with the result"});
    visit(
        "up", up,
        {.help = "the calibration's axis that points up; auto: the one that is up in the pictures",
         .choices = {"auto", "x", "y", "z", "-x", "-y", "-z"}});
    visit("height_m", height_m,
          {"the actor's height, where the calibration has no unit; 0: not known", "m", 0, 3, {}});
    visit("fps", fps,
          {"frames per second of numbered pictures; 0: the videos', else 25", "1/s", 0, 1000, {}});
    visit("sync_frames", sync_frames,
          {"largest offset between the cameras' clocks that is looked for; 0: they agree",
           "frames",
           0,
           1000,
           {}});
    visit("calm", calm,
          {"how much of the fits' trembling from frame to frame is taken out: a factor on the "
           "noise that the take itself shows; 0: none, each frame as it was fitted",
           "",
           0,
           10,
           {}});
    visit("clock_offsets", clock_offsets, {.help = kClockOffsetsHelp});
  }
  std::vector<std::string> Problems() const { return ClockWishProblems(clock_offsets); }
  TrackInputOptions Input() const {
    return {cameras, up, height_m, sync_frames, actor_frame, ParseClockWish(clock_offsets)};
  }
};

}  // namespace keypose::motion
