#include "capture/pictures/photograph_checks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

std::string SizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

/// Ascending.
std::vector<double> KnownFocals(const std::vector<Photograph>& photographs,
                                const SizeGroup& group) {
  std::vector<double> focals;
  for (const std::size_t i : group.photographs)
    if (photographs[i].focal_px > 0) focals.push_back(photographs[i].focal_px);
  std::sort(focals.begin(), focals.end());
  return focals;
}

}  // namespace

std::vector<char> QuarterTurns(const std::vector<Photograph>& photographs) {
  std::map<std::pair<int, int>, std::size_t> count;
  for (const Photograph& p : photographs) ++count[{p.width, p.height}];
  std::vector<char> turns;
  for (const Photograph& p : photographs) {
    const std::size_t as_it_is = count[{p.width, p.height}], turned = count[{p.height, p.width}];
    // As many of both: all upright.
    turns.push_back(turned > as_it_is || (turned == as_it_is && p.width > p.height));
  }
  return turns;
}

std::vector<SizeGroup> GroupedBySize(const std::vector<Photograph>& photographs,
                                     const std::vector<char>& turns) {
  std::map<std::pair<int, int>, SizeGroup> by_size;
  for (std::size_t i = 0; i < photographs.size(); ++i) {
    const auto [a, b] = std::pair{photographs[i].width, photographs[i].height};
    const auto [width, height] = turns[i] ? std::pair{b, a} : std::pair{a, b};
    SizeGroup& group = by_size[{width, height}];
    group.width = width;
    group.height = height;
    group.photographs.push_back(i);
  }
  std::vector<SizeGroup> groups;
  for (auto& [size, group] : by_size) groups.push_back(std::move(group));
  std::stable_sort(groups.begin(), groups.end(), [](const SizeGroup& a, const SizeGroup& b) {
    return a.photographs.size() > b.photographs.size();
  });
  return groups;
}

std::string DifferentSizes(const std::vector<Photograph>& photographs,
                           const std::vector<SizeGroup>& groups) {
  std::string text = "the photographs have different sizes: ";
  for (const SizeGroup& group : groups) {
    const bool first = &group == &groups.front();
    text += (first ? "" : ", ") + std::to_string(group.photographs.size()) +
            (group.photographs.size() == 1 ? " is " : " are ") +
            SizeText(group.width, group.height);
    if (first) continue;
    std::vector<std::string> names;
    for (const std::size_t i : group.photographs) names.push_back(photographs[i].name);
    text += ": " + JoinNames(names, 6);
  }
  return text;
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

double MedianFocalPx(const std::vector<Photograph>& photographs, const SizeGroup& group) {
  const auto focals = KnownFocals(photographs, group);
  return focals.empty() ? 0 : focals[focals.size() / 2];
}

double FocalSpread(const std::vector<Photograph>& photographs,
                   const std::vector<SizeGroup>& groups) {
  double spread = 0;
  for (const SizeGroup& group : groups) {
    const auto focals = KnownFocals(photographs, group);
    if (focals.size() < 2) continue;
    const double median = focals[focals.size() / 2];
    spread = std::max(spread, std::max(focals.back() - median, median - focals.front()) / median);
  }
  return spread;
}

std::string JoinNames(const std::vector<std::string>& names, std::size_t at_most) {
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), at_most); ++i)
    text += (i ? ", " : "") + names[i];
  if (names.size() > at_most) text += " and " + std::to_string(names.size() - at_most) + " more";
  return text;
}

}  // namespace keypose::capture
