// A film as numbered pictures: those of a folder, or of a video.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/project/shot_io.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::composite {

/// How many plates of a moving camera there are for each filmed frame: 1, or as many as pictures of
/// a finished shot, whose plates reach twice as far or more.
/// @param last_plate, last_frame  numbers, counted from 0
int PlatesAFrame(int last_plate, int last_frame);

/// Of a matte or a holdout: the alpha of a picture that has one which is not opaque all over, else
/// its grey values.
Image8 ReadMatte(const std::filesystem::path& path);

/// Pictures of a video are decoded when they are asked for, into a folder of PNG files that is
/// removed with this object. They are what the decoder gives, bit for bit.
class FilmFiles {
 public:
  /// Lists the pictures. Does not decode yet.
  /// @throws InputError  no picture; a video that is cut off or damaged; see FilmPictures
  explicit FilmFiles(const std::filesystem::path& film);
  ~FilmFiles();
  FilmFiles(const FilmFiles&) = delete;
  FilmFiles& operator=(const FilmFiles&) = delete;

  bool is_video() const { return fps_ > 0; }
  double fps() const { return fps_; }  ///< of a video; 0: not known
  /// All, in order. Those of a video lie at their paths only when they were decoded.
  const std::vector<FilmPicture>& pictures() const { return pictures_; }

  /// Of a video: writes these pictures, where that has not been done. Else does nothing.
  /// @param frames  ascending
  /// @throws InputError  no decoder for it; data that cannot be decoded; names file and frame
  /// @throws DiskError
  /// @throws Cancelled  before the next frame of the video
  void Decode(const std::vector<int>& frames, Progress* progress = nullptr);
  void DecodeAll(Progress* progress = nullptr);

 private:
  std::filesystem::path film_, scratch_;
  double fps_ = 0;
  std::string codec_;
  std::vector<FilmPicture> pictures_;
};

}  // namespace keypose::composite
