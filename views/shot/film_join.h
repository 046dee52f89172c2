// Films of several cameras joined by their times: frame N of each is the same moment.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "views/clocks/clock_network.h"
#include "views/shot/shot_camera.h"

namespace keypose {

/// What is done with a moment of which a camera has no picture within half a frame of the slowest
/// camera.
enum class FilmGaps {
  kRefused,  ///< an error
  kLeftOut,  ///< the moment is left out: where only pictures of one moment matter, not their rate
};

/// Where the frames of several films end.
enum class FilmEnds {
  kEach,    ///< each where it does
  kCommon,  ///< all where the first one does, if they are not left in their order
};

struct FilmJoin {
  double frames_per_second = 0;             ///< of the frames; 0: no camera has a video
  double worst_s = 0;                       ///< how far a picture lies from its frame's moment
  std::map<std::string, FilmClock> clocks;  ///< by cameras, where they were set; else empty
  std::vector<std::string> notes;           ///< sentences for the user
};

/// Films whose pictures of the same number lie within half a frame of each other stay as they are,
/// and one film alone of constant rate. Else frames are taken at the rate of the slowest camera,
/// from where all have begun; each shows the picture nearest to its moment. Of one film alone, a
/// picture that is missing is held. Masks that are one for each picture of a film follow it.
///
/// @throws InputError  gaps (unless they are left out); films that have no moment in common; films
/// that would have to be joined with numbered pictures, which have no times. Names camera, time and
/// cure
FilmJoin JoinFilms(std::vector<ShotCamera>& cameras, FilmGaps gaps = FilmGaps::kRefused,
                   FilmEnds ends = FilmEnds::kEach);

/// Gives the camera these masks; those that are one for each picture of its film follow its frames.
void TakeMasks(const FrameSource& masks, ShotCamera* camera);

}  // namespace keypose
