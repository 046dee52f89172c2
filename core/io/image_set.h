// The `images` artifact: a folder with photographs, masks/ and capture.json, as capture writes it
// and others read it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/calibration_board.h"

#include "core/image.h"

namespace keypose {

struct CapturedImage {
  std::string name;  ///< file name in the folder, e.g. "IMG_0001.jpg"
  int width = 0, height = 0;
  double focal_px = 0;      ///< from EXIF, 0 when unknown
  std::string mask;         ///< path relative to the folder, "masks/IMG_0001.jpg.png"
  bool mask_given = false;  ///< the mask is the user's own, not to be touched
  bool trusted = true;   ///< false: it contradicts the others, and has no say in shape and colour
  std::string why;       ///< it is not trusted: what contradicts, in words
  double sharpness = 0;  ///< variance of the Laplacian inside the mask, grey levels^2
  double exposure = 0;   ///< mean luma inside the mask, 0..255
  double mask_fraction = 0;  ///< share of the image that the mask covers
  /// figure's placement, such as "upright" or "lying"; "" where there is only one
  std::string group;
  /// of the printed calibration board, by id; none when it was not seen
  std::vector<BoardCorner> board_corners;
};

struct ImageSet {
  std::filesystem::path folder;
  std::vector<CapturedImage> images;  ///< sorted by name
  std::string camera_model;
  /// the printed calibration board under the figure, where one was found
  std::optional<BoardLayout> board;

  std::filesystem::path ImagePath(int i) const { return folder / images[i].name; }
  std::filesystem::path MaskPath(int i) const { return folder / images[i].mask; }
  int Find(const std::string& name) const;  ///< index, or -1
};

/// @throws InputError  capture.json missing or malformed, or a file it names is missing
ImageSet ReadImageSet(const std::filesystem::path& folder);
/// Writes capture.json only.
/// @throws DiskError
void WriteImageSet(const ImageSet& set);

}  // namespace keypose
