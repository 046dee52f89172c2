// Pictures into an MP4 file with H.264 video, as browsers and QuickTime play it.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "core/image.h"

namespace keypose::exporting {

/// Whether this machine's libavcodec can encode H.264 by x264.
bool CanWriteMp4();

/// Writes pictures one after the other. H.264 with 4:2:0 colours of BT.709, the index at the file's
/// beginning.
/// Same bits for any thread count: one thread encodes.
class Mp4Writer {
 public:
  /// @param width, height  of all pictures; even
  /// @throws ToolError  no encoder, or it does not take these values
  /// @throws DiskError  the file cannot be written
  Mp4Writer(const std::filesystem::path& path, int width, int height, double fps);
  ~Mp4Writer();
  Mp4Writer(const Mp4Writer&) = delete;
  Mp4Writer& operator=(const Mp4Writer&) = delete;

  /// @throws InputError  not RGB of the writer's size
  void Add(const Image8& picture);
  /// To be called once, after the last picture.
  /// @throws DiskError
  void Finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace keypose::exporting
