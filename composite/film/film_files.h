// A film as numbered pictures: those of a folder, or of a video.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/io/project/shot_io.h"
#include "core/values/image.h"
#include "core/values/progress.h"
#include "views/decode/film_index.h"

namespace keypose::composite {

/// How many plates of a moving camera there are for each filmed frame: 1, or as many as pictures of
/// a finished shot, whose plates reach twice as far or more.
/// @param last_plate, last_frame  numbers, counted from 0
int PlatesAFrame(int last_plate, int last_frame);

/// Makes a picture of scene light (OpenEXR, DPX) one to look at: RGB.
using ShowLight = std::function<Image8(const std::filesystem::path& picture)>;

/// The pictures of a film of scene light, by their names: OpenEXR and DPX.
/// @return empty  of other pictures, and of a video, which is not opened
/// @throws InputError  see FilmPictures
std::vector<FilmPicture> LightPictures(const std::filesystem::path& film);

/// Pictures of a video are decoded when they are asked for, into a folder of PNG files that is
/// removed with this object: 8 bits a channel, with alpha where the video has it. So are pictures
/// of scene light, if it is said how they are shown; else these are listed as they are.
class FilmFiles {
 public:
  /// Lists the pictures. Does not decode yet.
  /// @throws InputError  no picture; a video that is cut off, damaged or not read; see FilmPictures
  /// @param show  of scene light; may be none
  explicit FilmFiles(const std::filesystem::path& film, ShowLight show = {});
  ~FilmFiles();
  FilmFiles(const FilmFiles&) = delete;
  FilmFiles& operator=(const FilmFiles&) = delete;

  bool is_video() const { return index_ != nullptr; }
  /// Whether its pictures are OpenEXR or DPX.
  bool is_light() const { return is_light_; }
  double fps() const { return fps_; }  ///< of a video; 0: not known
  /// Sentences on what was taken for granted of a video, such as of its colours.
  std::vector<std::string> notes() const;
  /// All, in order; `frame` is by their times, so that what a video leaves out takes time. Those of
  /// a video lie at their paths only when they were decoded.
  const std::vector<FilmPicture>& pictures() const { return pictures_; }

  /// Of a video, and of light that is shown: writes these pictures, where that has not been done.
  /// Else does nothing.
  /// @param frames  `frame` of pictures, ascending; those that the video does not have are left out
  /// @throws InputError  no decoder for it; data that cannot be decoded; names file and frame
  /// @throws DiskError
  /// @throws Cancelled  before the next frame of the video
  void Decode(const std::vector<int>& frames, Progress* progress = nullptr);
  void DecodeAll(Progress* progress = nullptr);

 private:
  std::filesystem::path film_, scratch_;
  std::shared_ptr<const FilmIndex> index_;    // of a video; else null
  ShowLight show_;                            // of scene light that is decoded; else none
  std::vector<std::filesystem::path> light_;  // its pictures as they were found
  bool is_light_ = false;
  double fps_ = 0;
  std::vector<FilmPicture> pictures_;
};

}  // namespace keypose::composite
