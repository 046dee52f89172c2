// The clocks of a shot's cameras, from what their films recorded.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/values/progress.h"
#include "views/shot/clock_wish.h"
#include "views/shot/shot_camera.h"

namespace keypose {

struct FilmClocks {
  std::map<std::string, FilmClock> clocks;  ///< by cameras; empty: as the time stamps say
  std::vector<std::string> notes;           ///< sentences for the user
};

/// Offsets between the clocks of all cameras that have videos. Sound tells them first; films that
/// it does not join are joined by what moves in their pictures. Where these offsets are smaller
/// than what they can be told to (half a picture, 20 ms of sound, 1.5 pictures of motion), where
/// nothing is clear, or where offsets contradict each other, the time stamps are kept, and a note
/// says so.
///
/// @param progress  asked for cancel; may be null
/// @throws InputError  by sound some films are offset, and others cannot be joined with them; a
/// clock that runs faster than another by more than 0.2 %. Names cameras and numbers
FilmClocks FindFilmClocks(const std::vector<ShotCamera>& cameras, const Progress* progress);

/// As a person or an earlier stage said.
/// @throws UsageError  not a number for each film
/// @throws InputError  a camera that is not named
FilmClocks GivenFilmClocks(const std::vector<ShotCamera>& cameras, const ClockWish& wish);

/// Moves the times of films to these clocks.
void SetClocks(const std::map<std::string, FilmClock>& clocks, std::vector<ShotCamera>* cameras);

}  // namespace keypose
