// The photographs of one pose while `capture` reads, masks and writes them.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "capture/board/board_detection.h"
#include "capture/capture_options.h"
#include "capture/find_photographs.h"
#include "capture/room/stroke_masks.h"
#include "capture/shoot/record/side_file.h"
#include "core/io/pictures/image_set.h"
#include "core/stage/stage_context.h"
#include "core/values/image.h"

namespace keypose::capture {

namespace fs = std::filesystem;

/// Longer side that suffices for masks and checks. Larger photographs are looked at reduced by
/// eighths to this or a little more: later stages look at 2000 pixels (sfm) or 1600 (dense,
/// refine).
inline constexpr int kDetail_px = 2000;

/// How a person's mask is to be taken; see own_mask_import.h.
struct MaskWay {
  bool inverted = false;   ///< white is all but the figure
  bool as_stored = false;  ///< it lies as the photograph is stored, though it fits upright too
};

/// The set during import.
struct PhotographImport {
  fs::path folder, masks;  // masks: empty if the user gave none
  std::vector<PhotographGroup> groups;
  std::vector<fs::path> backgrounds;  // for each group; empty if the user gave none
  std::vector<fs::path> files;        // of all groups
  std::vector<std::string> left_out;  // by a person: names as they would be written
  std::vector<Photograph> photographs;
  std::vector<char> quarter_turns;
  std::vector<SizeGroup> sizes;  // the most common one first
  std::vector<double> factors;   // size written over size read
  // of each group's folder; none for photographs that `keypose shoot` has not made
  std::map<fs::path, shoot::SideFile> side_files;
  std::vector<Image8> small;  // working images
  std::vector<Image8> small_masks;
  std::vector<ViewStrokes> strokes;  // of a person, in pixels of the working images
  std::vector<fs::path> user_masks;
  std::vector<MaskWay> mask_ways;     // how those masks are to be taken
  std::optional<BoardPattern> board;  // that is looked for
  // for each photograph; empty if it shows no board
  std::vector<std::vector<BoardCorner>> board_corners;
  std::vector<BoardOdds> boards;  // their odds for the working images
};

/// Lists and inspects the photographs, masks and clean plates that the stage is given.
/// @throws InputError  too few, damaged, masks of others; not enough memory
PhotographImport OpenPhotographs(StageContext& stage, const CaptureOptions& options);

/// Pixels of the photograph as they will be written: upright, those of one camera of one size.
Image8 LoadUpright(const PhotographImport& import, std::size_t i);
/// Eighths of the size written at which the photograph is looked at; 8 for ordinary ones.
int DetailEighths(const PhotographImport& import, std::size_t i);
/// Pixels of the photograph, upright, at `eighths` of the size written.
Image8 LoadReduced(const PhotographImport& import, std::size_t i, int eighths);
/// The clean plate of a group, with the white balance of its photographs.
/// @pre there is one
Image8 LoadPlate(const PhotographImport& import, std::size_t group);
/// The photograph's place in its session with `keypose shoot`.
std::optional<TurntablePlace> PlaceOf(const PhotographImport& import, std::size_t i);

/// Width and height of a picture.
struct Size {
  int width = 0, height = 0;
};
/// Size of the photograph as it is written.
Size WrittenSize(const PhotographImport& import, std::size_t i);

/// A photograph and its mask, as written and as looked at.
struct MaskedPhotograph {
  Image8 detail, detail_mask;  ///< at DetailEighths of the size
  Image8 mask;                 ///< at full size; empty where detail_mask has it
  Size size;                   ///< in full
};
/// Writes the photograph and its mask, the user's or the segmented one with its border refined. The
/// photograph is copied where nothing changed; else encoded, with its EXIF data.
/// @param own  the user's mask, of LoadOwnMask; empty if there is none
/// @throws DiskError
MaskedPhotograph WriteMasked(const PhotographImport& import, std::size_t i, Image8 own,
                             const fs::path& to, const fs::path& mask_to, int quality);

/// Calls body(i) for all photographs in parallel and collects the errors.
/// @throws InputError  of each photograph; "... 3 files WHAT"
void ForEachPhotograph(const PhotographImport& import, Progress* progress, const std::string& what,
                       const std::function<void(std::size_t)>& body);

}  // namespace keypose::capture
