// A shot: what several fixed cameras filmed of one performance, as videos or numbered pictures.
//
//     shot/
//       cam1/000.jpg ...         or cam1.mp4     a folder or a video for each camera
//       masks/cam1/000.png ...   or masks/cam1.mp4     optional: 255 where the actor is
//       background/cam1.jpg      optional: the set without the actor
//       rate.json                optional, beside masks alone: {"fps"} of their films
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "core/values/progress.h"
#include "views/shot/clock_wish.h"
#include "views/shot/film_join.h"
#include "views/shot/shot_camera.h"

namespace keypose {

struct Shot {
  std::vector<ShotCamera> cameras;  ///< sorted by name, numbers as numbers
  double frames_per_second = 0;     ///< of the frames, or by rate.json; 0: not known
  FilmJoin join;                    ///< how videos were joined
  bool has_masks() const;           ///< every camera has them
  std::vector<std::string> names() const;
};

/// Films are joined by their times (JoinFilms), after their clocks are set as wished.
/// @param progress  asked for cancel while clocks are looked for; may be null
/// @throws InputError  no camera; a video that cannot be read; as many masks as pictures are
/// needed; films that do not run together (JoinFilms, RequireSameGaps,
/// FindFilmClocks)
Shot OpenShot(const std::filesystem::path& folder, FilmGaps gaps = FilmGaps::kRefused,
              const ClockWish& clocks = {}, const Progress* progress = nullptr);

/// Films or pictures of several cameras that need not run together, sorted by name.
/// @throws InputError  no camera; a video that cannot be read
std::vector<ShotCamera> OpenSeparateFilms(const std::filesystem::path& folder);

/// As OpenShot has them where they can be joined, else as OpenSeparateFilms.
/// @throws InputError  as OpenSeparateFilms
std::vector<ShotCamera> OpenFilmsToShow(const std::filesystem::path& folder);

/// Writes rate.json, so that a folder of masks says how fast their films are.
void WriteShotRate(const std::filesystem::path& folder, double frames_per_second);

/// Reads the frames of one source. Reading in order is fast; videos are decoded anew from their
/// start when an earlier frame is asked for. Not for use in several threads at once.
class FrameReader {
 public:
  explicit FrameReader(FrameSource source);
  ~FrameReader();
  FrameReader(FrameReader&&) noexcept;
  FrameReader& operator=(FrameReader&&) noexcept;

  /// @param channels  1 (luma) or 3 (RGB); of a video also 4 (RGB and alpha, 255 where it has none)
  /// @param progress  asked for cancel before each frame of a video that is decoded; may be null
  /// @throws InputError  it cannot be decoded; names the file and the frame
  /// @throws UsageError  no such frame
  Image8 Read(int frame, int channels, const Progress* progress = nullptr);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose
