// What a film's file holds: its pictures, in order and by their times.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/numbers/picture_times.h"
#include "core/values/progress.h"

namespace keypose {

struct FilmIndex {
  /// When each picture is shown [s], ascending; 0 is where the file says that it begins, so that a
  /// film whose first picture comes late begins later. Of streams that are cut from broadcasts
  /// (MPEG-TS, MPEG-PS), which count from anywhere, 0 is their first sound or picture. The delay of
  /// an encoder, which MP4 without an edit list shows, counts not.
  std::vector<double> times_s;
  std::vector<std::int64_t> stamps;  ///< the same in the file's unit; empty: counted, without times
  double zero_s = 0;  ///< the time in the file [s] that counts as 0 above, of sound too
  PictureRate rate;
  int width = 0, height = 0;  ///< as shown
  bool has_alpha = false;
  std::string codec;               ///< libav's name, such as h264
  std::vector<std::string> notes;  ///< sentences for the user on what was assumed

  int frames() const { return static_cast<int>(times_s.size()); }
  /// The picture that is shown at this time: the last one that does not begin after it (by more
  /// than a microsecond); before the first one, that one.
  int PictureAt(double time_s) const;
  /// The picture that begins nearest to this time.
  int PictureNearest(double time_s) const;
};

/// Whether the file is to be read as a film: no folder, and no picture by its name.
bool IsFilmFile(const std::filesystem::path& path);

/// Reads the times of all pictures of the first video, and decodes the first picture. Only what has
/// no times, or may hold pictures that are not shown (VP8), is decoded whole.
/// @param progress  asked for cancel; may be null
/// @throws InputError  no video; cut off; nothing decodes it; colours, pixels or turns that are not
/// read. Names the file and the cure
/// @throws DiskError   cannot be opened
FilmIndex ReadFilmIndex(const std::filesystem::path& path, const Progress* progress = nullptr);

}  // namespace keypose
