// The films, masks and clean plate of one camera of a shot.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "views/decode/film_index.h"

namespace keypose {

/// One camera's frames: either numbered pictures or a video.
struct FrameSource {
  std::vector<std::filesystem::path> pictures;  ///< sorted, numbers as numbers
  std::filesystem::path video;
  int frames = 0;
  double frames_per_second = 0;            ///< of a video; 0: not known
  std::shared_ptr<const FilmIndex> index;  ///< of a video; may be null: not read yet
  /// For each frame the picture that shows it, where films were joined by their times; empty: all
  /// pictures in their order.
  std::vector<int> order;
  bool empty() const { return frames == 0; }
};

struct ShotCamera {
  std::string name;
  FrameSource pictures;         ///< empty when only masks are given
  FrameSource masks;            ///< empty when there are none
  std::filesystem::path plate;  ///< empty when there is none
  int frames() const { return pictures.empty() ? masks.frames : pictures.frames; }
};

}  // namespace keypose
