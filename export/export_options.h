// Options of keypose-export.
#pragma once

#include <string>
#include <vector>

#include "core/values/options.h"
#include "export/formats.h"

namespace keypose::exporting {

constexpr double kLeastRate = 0.1, kMostRate = 1000;  // frames per second

struct ExportOptions {
  std::string formats = "glb,video,sheet";
  double fps = 0;
  PlaybackOptions playback;
  std::string up = "z";    // axis that points up in the frames
  std::string unit = "m";  // of the frames
  double front = 0;  // deg, counter-clockwise seen from above, from the first photograph's side
  std::string poses;
  double sound_at = 0;  // s on the film's time
  FormatOptions format;

  void Describe(OptionVisitor& visit);

  std::vector<std::string> Problems() const;

 private:
  void DescribeFilm(OptionVisitor& visit);
};

}  // namespace keypose::exporting
