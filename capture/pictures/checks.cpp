#include "capture/pictures/checks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/errors.h"
#include "core/size_of.h"

namespace keypose::capture {
namespace {

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

std::vector<double> KnownFocals(const std::vector<Photograph>& photographs) {
  std::vector<double> focals;
  for (const Photograph& p : photographs)
    if (p.focal_px > 0) focals.push_back(p.focal_px);
  std::sort(focals.begin(), focals.end());
  return focals;
}

}  // namespace

std::vector<char> QuarterTurns(const std::vector<Photograph>& photographs) {
  std::map<std::pair<int, int>, std::vector<std::string>> by_size;
  for (const Photograph& p : photographs) by_size[{p.width, p.height}].push_back(p.name);
  std::vector<char> turns(photographs.size(), 0);
  if (by_size.size() < 2) return turns;
  auto most = by_size.begin();
  for (auto it = by_size.begin(); it != by_size.end(); ++it)
    if (it->second.size() > most->second.size()) most = it;
  const auto [width, height] = most->first;
  std::string others;
  for (const auto& [size, names] : by_size)
    if (size != most->first && size != std::pair{height, width})
      others += "; " + SizeText(size.first, size.second) + ": " + JoinNames(names);
  if (!others.empty())
    throw InputError(
        "capture: the photographs have different sizes: " + std::to_string(most->second.size()) +
        " are " + SizeText(width, height) + others +
        "; one pose is shot with one camera at one setting: leave out the others, or export all at "
        "one size without cropping");
  for (std::size_t i = 0; i < photographs.size(); ++i) turns[i] = photographs[i].width != width;
  return turns;
}

bool IsOfAScan(int min_images) { return min_images >= 8; }

void RequireEnoughAndDistinct(const std::vector<Photograph>& photographs, int min_images,
                              const std::string& folder) {
  const int count = SizeOf(photographs);
  if (count < min_images)
    throw InputError("capture: " + folder + " has " + std::to_string(count) +
                     (count == 1 ? " photograph" : " photographs") + "; at least " +
                     std::to_string(min_images) +
                     (IsOfAScan(min_images)
                          ? " are needed, and 24 or more all round the object are better; in a "
                            "project a further pose takes 6 with `method: fit` beside its photos "
                            "in pipeline.yaml"
                          : " are needed, and 6 or more from different sides are better"));
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::string> seen;
  std::vector<std::string> twins;
  for (const Photograph& p : photographs) {
    const auto [it, fresh] = seen.emplace(std::pair{p.digest, p.bytes}, p.name);
    if (!fresh) twins.push_back(p.name + " = " + it->second);
  }
  if (!twins.empty())
    throw InputError("capture: photographs are there twice, byte for byte: " + JoinNames(twins) +
                     "; delete the copies");
}

void RequireUsableSizes(const std::vector<Photograph>& photographs) {
  constexpr int kLeastSide_px = 16,
                kLongest = 20;  // times as long as wide: nothing is left of such a strip at the
                                // size at which masks are segmented
  std::vector<std::string> odd;
  for (const Photograph& p : photographs) {
    const auto [shorter, longer] = std::minmax(p.width, p.height);
    if (shorter < kLeastSide_px || longer / kLongest > shorter)
      odd.push_back(p.name + " (" + SizeText(p.width, p.height) + ")");
  }
  if (!odd.empty())
    throw InputError(
        "capture: these are too small or too narrow to be photographs of anything: " +
        JoinNames(odd) +
        "; at least 16 pixels each way, and at most 20 times as long as wide; leave them out");
}

double MedianFocalPx(const std::vector<Photograph>& photographs) {
  const auto focals = KnownFocals(photographs);
  return focals.empty() ? 0 : focals[focals.size() / 2];
}

double FocalSpread(const std::vector<Photograph>& photographs) {
  const auto focals = KnownFocals(photographs);
  if (focals.size() < 2) return 0;
  const double median = focals[focals.size() / 2];
  return std::max(focals.back() - median, median - focals.front()) / median;
}

std::string JoinNames(const std::vector<std::string>& names, std::size_t at_most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), at_most); ++i)
    text += (i ? ", " : "") + names[i];
  if (names.size() > at_most) text += " and " + std::to_string(names.size() - at_most) + " more";
  return text;
}

}  // namespace keypose::capture
