// Writes pictures as an MP4 file with H.264 video that browsers and QuickTime can play.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/values/image.h"
#include "views/film/sound.h"

namespace keypose {

/// Whether this machine's libavcodec can encode H.264 with x264.
bool CanWriteMp4();

/// Writes pictures one after the other: H.264, 4:2:0, BT.709, with the index at the beginning of
/// the file. Same bits for any thread count: one thread encodes.
class Mp4Writer {
 public:
  /// @param width, height  size of all pictures [px]; even numbers
  /// @param sound          heard from the first picture on, as AAC; what is longer than the film is
  ///                       left out; empty: a film without sound
  /// @throws ToolError  no encoder, or it rejects these values
  /// @throws DiskError  the file cannot be written
  Mp4Writer(const std::filesystem::path& path, int width, int height, double fps, Sound sound = {});
  ~Mp4Writer();
  Mp4Writer(const Mp4Writer&) = delete;
  Mp4Writer& operator=(const Mp4Writer&) = delete;

  /// @param picture  RGB, or RGBA, which is laid over kFilmBackground
  /// @throws InputError  not such a picture of the writer's size
  void Add(const Image8& picture);
  /// Call once, after the last picture.
  /// @throws DiskError
  void Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace keypose
