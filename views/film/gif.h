// Writes pictures as an animated GIF that loops.
#pragma once

#include <filesystem>
#include <memory>

#include "core/values/image.h"

namespace keypose {

struct GifOptions {
  int height = 480;         ///< px; smaller pictures are not enlarged
  double max_seconds = 12;  ///< what comes later is left out
};

/// Pictures are collected and written by Finish, in one palette for all of them (see ColorCounts
/// and Ditherer), and only where they differ from the picture before. GIF counts time in hundredths
/// of a second: each picture begins at the hundredth nearest to its time, so that errors do not add
/// up. Browsers slow down pictures that last one hundredth: above 50 per second some are left out.
/// Equal consecutive pictures become one that lasts longer.
/// Same bits for any thread count.
class GifWriter {
 public:
  /// @throws ToolError  libavcodec cannot write GIF
  /// @throws DiskError  the file cannot be written
  GifWriter(const std::filesystem::path& path, double fps, const GifOptions& options = {});
  ~GifWriter();
  GifWriter(const GifWriter&) = delete;
  GifWriter& operator=(const GifWriter&) = delete;

  /// @param picture  RGB, or RGBA, which is laid over kFilmBackground
  /// @throws InputError  not such a picture, or not of the first one's size
  void Add(const Image8& picture);
  /// Call once, after the last picture.
  /// @throws InputError  there is no picture
  /// @throws DiskError, ToolError
  void Finish();
  /// Whether pictures after max_seconds were left out.
  bool Shortened() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The picture made smaller by area, mixed as light: RGB.
/// @param picture  RGB, at least as large as the result
Image8 Shrunk(const Image8& picture, int width, int height);

}  // namespace keypose
