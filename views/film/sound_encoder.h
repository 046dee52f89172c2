// Encodes sound as AAC, beside the pictures of a film.
#pragma once

#include "views/film/libav.h"
#include "views/film/sound.h"

namespace keypose {

class SoundEncoder {
 public:
  /// Adds its stream to the file.
  /// @throws ToolError  libavcodec has no AAC encoder
  SoundEncoder(AvFile* file, Sound sound);

  /// Writes what is heard before this time and was not written yet, in whole blocks.
  /// @throws DiskError, ToolError
  void WriteUntil(double seconds);
  /// Writes what is heard before this time, the film's end, and what the encoder still holds. What
  /// is later is left out.
  void FinishAt(double seconds);

 private:
  void Write(std::int64_t end);

  AvFile* file_;
  Sound sound_;
  AvEncoder encoder_;
  AvFrame block_;
  int stream_ = -1;
  std::int64_t written_ = 0;  // samples of one channel
};

}  // namespace keypose
