#include "capture/own_mask_import.h"

#include <algorithm>
#include <utility>

#include "capture/pictures/own_masks.h"
#include "capture/pictures/photograph_checks.h"
#include "capture/shoot/develop/photograph.h"
#include "core/io/pictures/drawn_mask.h"
#include "core/io/pictures/image_io.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"

namespace keypose::capture {
namespace {

/// How much more contrast an outline must have the other way round before a mask is turned.
constexpr double kClearlyBetter = 1.5;
constexpr int kLookedAt_px = 800;

int OrientationOf(const PhotographImport& import, std::size_t i) {
  return shoot::ReadPhotographInfo(import.files[i]).orientation;
}

MaskPlace PlaceOfMask(const PhotographImport& import, std::size_t i) {
  const Photograph& photograph = import.photographs[i];
  return {photograph.width, photograph.height, OrientationOf(import, i),
          import.user_masks[i].string(), photograph.name};
}

/// A mask as it is found, before what the set tells.
struct FoundMask {
  MaskSide side = MaskSide::kFigure;
  MaskChange change;
  double upright = 0, stored = 0;  ///< contrast of its outline, where it would fit either way
};

/// Whether a mask of the photograph's size would also fit if it lay as the photograph is stored.
bool FitsEitherWay(const Image8& mask, const MaskPlace& place, const MaskChange& change) {
  if (place.orientation == 1 || change.turned) return false;
  return place.orientation < 5 || mask.width == mask.height;
}

void CompareWays(const PhotographImport& import, std::size_t i, const Image8& mask, int orientation,
                 FoundMask* found) {
  const Image8 photograph = shoot::ReadPhotograph(import.files[i]);
  const double factor =
      std::min(1.0, static_cast<double>(kLookedAt_px) / std::max(mask.width, mask.height));
  const int width = std::max(1, static_cast<int>(mask.width * factor)),
            height = std::max(1, static_cast<int>(mask.height * factor));
  const Image8 rgb = Resized(photograph, width, height);
  Image8 grey(width, height, 1);
  for (std::size_t p = 0; p < grey.data.size(); ++p)
    grey.data[p] = static_cast<std::uint8_t>(
        (rgb.data[3 * p] + rgb.data[3 * p + 1] + rgb.data[3 * p + 2]) / 3);
  found->upright = BorderContrast(grey, ResizedMask(mask, width, height));
  found->stored = BorderContrast(grey, ResizedMask(Oriented(mask, orientation), width, height));
}

FoundMask LookAt(const PhotographImport& import, std::size_t i) {
  FoundMask found;
  const MaskPlace place = PlaceOfMask(import, i);
  const Image8 mask = PlacedMask(ReadDrawnMask(import.user_masks[i]), place, &found.change);
  found.side = SideOf(mask);
  if (FitsEitherWay(mask, place, found.change))
    CompareWays(import, i, mask, place.orientation, &found);
  return found;
}

/// One way for all that fit both: programs write a set's masks alike.
bool LieAsStored(const std::vector<FoundMask>& found) {
  double upright = 0, stored = 0;
  for (const FoundMask& mask : found) {
    upright += mask.upright;
    stored += mask.stored;
  }
  return stored > kClearlyBetter * upright;
}

using Indices = std::vector<std::size_t>;

std::string Names(const PhotographImport& import, const Indices& which) {
  std::vector<std::string> names;
  for (const std::size_t i : which) names.push_back(import.user_masks[i].filename().string());
  return JoinNames(names);
}

void Tell(StageContext& stage, const PhotographImport& import, const Indices& which,
          const std::string& words) {
  if (!which.empty()) stage.Warn(words + ": " + Names(import, which));
}

}  // namespace

void FindWaysOfMasks(StageContext& stage, PhotographImport* import) {
  import->mask_ways.assign(import->files.size(), {});
  Indices given;
  for (std::size_t i = 0; i < import->files.size(); ++i)
    if (!import->user_masks[i].empty()) given.push_back(i);
  if (given.empty()) return;
  std::vector<FoundMask> found(import->files.size());
  ForEachPhotograph(*import, nullptr, "have a mask that cannot be used", [&](std::size_t i) {
    if (!import->user_masks[i].empty()) found[i] = LookAt(*import, i);
  });
  const bool stored = LieAsStored(found);
  Indices inverted, turned, enlarged, empty;
  for (const std::size_t i : given) {
    const FoundMask& mask = found[i];
    const bool turns = stored && (mask.stored > 0 || mask.upright > 0);
    if (mask.side == MaskSide::kSurroundings) inverted.push_back(i);
    if (mask.side == MaskSide::kNothing) empty.push_back(i);
    if (mask.change.turned || turns) turned.push_back(i);
    if (mask.change.enlarged) enlarged.push_back(i);
    import->mask_ways[i] = {.inverted = mask.side == MaskSide::kSurroundings, .as_stored = turns};
  }
  Tell(stage, *import, inverted,
       "these masks are white where the figure is not, and were turned round: black is taken for "
       "the figure");
  Tell(stage, *import, turned,
       "these masks lie as their photographs are stored, and were turned as EXIF says");
  Tell(stage, *import, enlarged,
       "these masks have another size than their photographs, and were resized");
  if (empty.size() == given.size()) return;  // refused later, with all other masks that are black
  Tell(stage, *import, empty,
       "these masks are black, so they are not used and the photographs are masked without them");
  for (const std::size_t i : empty) import->user_masks[i].clear();
}

Image8 LoadOwnMask(const PhotographImport& import, std::size_t i) {
  const MaskPlace place = PlaceOfMask(import, i);
  const MaskWay& way = import.mask_ways[i];
  Image8 mask = PlacedMask(ReadDrawnMask(import.user_masks[i]), place, nullptr);
  if (way.as_stored) mask = Oriented(std::move(mask), place.orientation);
  if (way.inverted) mask = InvertedMatte(std::move(mask));
  if (import.quarter_turns[i]) mask = QuarterTurned(mask);
  const Size size = WrittenSize(import, i);
  return import.factors[i] == 1 ? mask : ResizedMask(mask, size.width, size.height);
}

}  // namespace keypose::capture
