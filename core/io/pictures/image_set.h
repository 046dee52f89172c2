// The `images` artifact: a folder with photographs, masks/ and capture.json. `capture` writes it;
// other stages read it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/values/board_print.h"
#include "core/values/image.h"

namespace keypose {

/// Where a photograph belongs in a session of `keypose shoot`: a start for cameras, not measured.
struct TurntablePlace {
  int ring = 1;          ///< from 1, of one height of the camera
  double angle_deg = 0;  ///< of the table; which way it turns is not known
  double tilt_deg = 0;   ///< elevation of the camera above the table
  int flip = 0;          ///< placement of the figure, 0 upright
};

struct CapturedImage {
  std::string name;  ///< file name in the folder, e.g. "IMG_0001.jpg"
  int width = 0, height = 0;
  /// of the photograph, upright, where it is another: it was made smaller or turned; else 0
  int photograph_width = 0, photograph_height = 0;
  double focal_px = 0;      ///< from EXIF, 0 when unknown
  std::string mask;         ///< path relative to the folder, "masks/IMG_0001.jpg.png"
  bool mask_given = false;  ///< the user made the mask; it must not be changed
  bool trusted = true;   ///< false: it contradicts the others, and is not used for shape and colour
  std::string why;       ///< why it is not trusted; for the user
  double sharpness = 0;  ///< variance of the Laplacian inside the mask, grey levels^2
  /// in [0, 1], 1 sharp; hardly depends on the texture (capture/pictures/photograph_quality.h); 0:
  /// not known
  double crispness = 0;
  double exposure = 0;   ///< mean luma inside the mask, 0..255
  double mask_fraction = 0;  ///< share of the image that the mask covers
  /// the figure's placement, such as "upright" or "lying"; "" when there is only one
  std::string group;
  /// corners of the printed calibration board, by id; none when it was not seen
  std::vector<BoardCorner> board_corners;
  /// from shoot.json; none for photographs of another origin
  std::optional<TurntablePlace> place;
};

/// Whether `capture` turned the photograph by a quarter, as most of the set lie otherwise: what
/// stood upright lies across.
bool LiesAcross(const CapturedImage& image);

struct ImageSet {
  std::filesystem::path folder;
  std::vector<CapturedImage> images;  ///< sorted by name
  std::string camera_model;
  /// the printed calibration board under the figure, when one was found
  std::optional<BoardLayout> board;
  BoardPrint board_print;  ///< of that board
  /// height (z, in the cameras' frame) of the level plane that the figure stands on, where `masks`
  /// found one: nothing in the masks is below it
  std::optional<double> floor;

  std::filesystem::path ImagePath(int i) const { return folder / images[i].name; }
  std::filesystem::path MaskPath(int i) const { return folder / images[i].mask; }
  int Find(const std::string& name) const;  ///< index, or -1
};

/// Reads capture.json and checks that the files it names exist.
/// @throws InputError  capture.json missing or malformed, or a file it names is missing
ImageSet ReadImageSet(const std::filesystem::path& folder);
/// Writes capture.json only.
/// @throws DiskError
void WriteImageSet(const ImageSet& set);

}  // namespace keypose
