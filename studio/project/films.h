// The films of a performance's shot and the masks of its actor, a frame at a time.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/values/figure_strokes.h"
#include "pipeline/graph/pipeline_file.h"
#include "studio/project/snapshot.h"
#include "views/shot/shot_camera.h"

namespace keypose::studio {

/// The folder of a shot's films. @throws UsageError  no such shot
std::filesystem::path FilmFolder(const std::filesystem::path& project,
                                 const pipeline::PipelineFile& file, const std::string& shot);

/// The cameras whose films lie in a folder, without those that are links to other places. Opened
/// once, and again when a file has changed. Safe to call from many threads.
/// @throws InputError  none, or a video that cannot be read
std::vector<ShotCamera> FilmsIn(const std::filesystem::path& folder);

/// Of a frame as a viewer shows it.
PictureSize FrameSize(const FrameSource& film, int frame);

/// - problem  why there are no films to show, or ""
/// - cameras  {name, frames, width, height, masked}: `masked` where each frame has a mask
nlohmann::json FilmsJson(Snapshot& snapshot, const std::string& shot);

/// @throws UsageError  no such shot @throws NotFound  no such camera or frame
FrameSource FilmOf(Snapshot& snapshot, const std::string& shot, const std::string& camera);
/// Masks that lie beside the films, else those that `silhouettes` made last. @throws NotFound
FrameSource MasksOf(Snapshot& snapshot, const std::string& shot, const std::string& camera);

/// A JPEG or PNG of a frame, at most `width` pixels wide (0: full size). Made once, and kept. Safe
/// to call from many threads.
/// @param folder  where pictures are kept
/// @throws NotFound  the film has no such frame
std::filesystem::path FramePicture(const std::filesystem::path& folder, const FrameSource& film,
                                   int frame, int width);
/// A grey PNG.
std::filesystem::path FrameMask(const std::filesystem::path& folder, const FrameSource& masks,
                                int frame);

/// A video of the project as the numbered pictures that a filmed shot takes, in the folder of its
/// name beside it.
struct CutFilm {
  std::string folder;  ///< in the project
  int pictures = 0;
  double fps = 0;  ///< 0: not known
};
/// Cut already: what there is.
/// @param video  its path in the project
/// @throws UsageError  no such video; it is longer than kMostCutFrames; other files are in the way
/// @throws InputError  it cannot be decoded
inline constexpr int kMostCutFrames = 3000;
CutFilm CutIntoPictures(const std::filesystem::path& project, const std::string& video);

}  // namespace keypose::studio
