#include "core/io/pictures/drawn_mask.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/mask_channels.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr std::size_t kFewLevels = 8;
constexpr float kHalf = 127.5F;
/// As far from black or white as a JPEG's noise carries a level.
constexpr float kNoise = 12;
/// A level of fewer pixels is a smoothed border.
constexpr double kLabelShare = 0.005;

/// Pixels of each level; empty where there are more than a few.
std::map<float, std::size_t> FewLevels(const ImageF& levels) {
  std::map<float, std::size_t> counts;
  for (const float level : levels.data) {
    ++counts[level];
    if (counts.size() > kFewLevels) return {};
  }
  return counts;
}

std::string Listed(const std::map<float, std::size_t>& counts) {
  std::string text;
  for (const auto& [level, count] : counts)
    text += fmt::format("{}{:g}", text.empty() ? "" : ", ", level);
  return text;
}

/// Whether a level between the lowest and the highest is one of its own, as of a second label.
bool HasLabels(const std::map<float, std::size_t>& counts, std::size_t pixels, bool lossless) {
  const float lowest = counts.begin()->first, highest = counts.rbegin()->first;
  return std::any_of(counts.begin(), counts.end(), [&](const auto& entry) {
    const auto [level, count] = entry;
    if (level == lowest || level == highest) return false;
    // Hardly any program numbers its labels down from white, and some write a white of 250 too.
    const bool noise = level > 255 - kNoise || (!lossless && level < kNoise);
    return !noise && static_cast<double>(count) >= kLabelShare * static_cast<double>(pixels);
  });
}

Image8 Above(const ImageF& levels, float limit) {
  Image8 mask(levels.width, levels.height, 1);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    mask.data[i] = levels.data[i] > limit ? 255 : 0;
  return mask;
}

}  // namespace

Image8 MaskOfLevels(const ImageF& levels, bool lossless, const std::string& name) {
  if (!lossless && IsEmptyMatte(levels)) return Image8(levels.width, levels.height, 1);
  const std::map<float, std::size_t> counts = FewLevels(levels);
  if (counts.size() == 1) return Above(levels, 0);
  if (counts.size() == 2) return Above(levels, counts.begin()->first);
  if (!counts.empty() && HasLabels(counts, levels.data.size(), lossless))
    throw InputError(
        fmt::format("mask {} has the levels {}: several labels, or pixels that are undecided; "
                    "paint the figure white and all else black",
                    name, Listed(counts)));
  const float highest = *std::max_element(levels.data.begin(), levels.data.end());
  if (highest <= kHalf)
    throw InputError(
        fmt::format("mask {} is dark all over, its brightest level is {:g} of 255; paint the "
                    "figure white and all else black",
                    name, highest));
  return Above(levels, kHalf);
}

Image8 ReadDrawnMask(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (const Image8 alpha = ReadAlpha(path); AlphaIsMask(alpha))
    return MaskOfLevels(AsLevels(alpha), true, name);
  const ImageF rgb = ReadLevels(path, 3);
  const ImageF levels = BrightestChannel(rgb);
  if (IsColoured(rgb) && FewLevels(levels).empty())
    throw InputError(
        fmt::format("mask {} is a picture in colours; a mask is white where the figure is and "
                    "black elsewhere, or has it in its alpha",
                    name));
  return MaskOfLevels(levels, KeepsLevels(path), name);
}

bool KeepsLevels(const std::filesystem::path& path) {
  const std::string format = ReadImageInfo(path).format;
  return format != "jpeg" && format != "heif";
}

}  // namespace keypose
