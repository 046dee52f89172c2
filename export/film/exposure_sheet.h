// An exposure sheet: a row for each picture of the film, with what it shows and how its sound is.
#pragma once

#include <string>

#include "export/animation/scene.h"
#include "views/film/sound.h"

namespace keypose::exporting {

/// The lowest and the highest sample of a picture's time, of both channels.
struct SoundRange {
  float low = 0, high = 0;
};

/// Of each picture of a film that begins with the sound. Past the sound's end: 0.
std::vector<SoundRange> SoundRanges(const Sound& sound, int pictures, double fps);

/// A page for A4, black on white, that needs nothing else: `character_sheet.html`. A row for each
/// picture: its number from 1 on, seconds and pictures, the pose or the way to the next, a line
/// where the picture before stays, the wave of the sound, and room for notes.
/// @param sound  from the first picture on; empty: the column is left out
FormatFiles MakeExposureSheet(const Scene& scene, const Sound& sound);

}  // namespace keypose::exporting
