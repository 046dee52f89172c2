#include "views/shot/sync_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {

namespace fs = std::filesystem;

namespace {

/// Names whose numbers do not rise by one step are no frame numbers: times, or counters.
constexpr double kRegular = 0.9;

/// For each picture its number after the first one's, in steps; empty if the names are not
/// numbered so.
std::vector<long> StepsOf(const FrameSource& source) {
  const std::vector<long> numbers = FrameNumbersOf(source.pictures);
  std::map<long, int> count;
  for (int i = 1; i < SizeOf(numbers); ++i) ++count[numbers[i] - numbers[i - 1]];
  if (count.empty()) return {};
  const auto [step, times] = *std::max_element(
      count.begin(), count.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  if (step < 1 || times < kRegular * (SizeOf(numbers) - 1)) return {};
  std::vector<long> steps;
  for (const long number : numbers) {
    if ((number - numbers[0]) % step != 0 || number < numbers[0]) return {};
    steps.push_back((number - numbers[0]) / step);
  }
  return steps;
}

}  // namespace

/// A camera whose card was too slow has no picture 57 and goes on with 58: all later ones would be
/// taken for the moment before.
void RequireSameGaps(const std::vector<ShotCamera>& cameras) {
  const ShotCamera* first = nullptr;
  std::vector<long> expected;
  for (const ShotCamera& camera : cameras) {
    const std::vector<long> steps = StepsOf(camera.pictures);
    if (steps.empty()) continue;
    if (!first) {
      first = &camera;
      expected = steps;
      continue;
    }
    const auto [a, b] = std::mismatch(
        steps.begin(), steps.begin() + std::min(SizeOf(steps), SizeOf(expected)), expected.begin());
    const std::size_t at = static_cast<std::size_t>(a - steps.begin());
    if (at >= std::min(steps.size(), expected.size())) continue;
    // The one that jumped further lacks a picture.
    const ShotCamera& lacks = *a > *b ? camera : *first;
    const auto& before = lacks.pictures.pictures[at - 1];
    throw InputError(fmt::format(
        "the films do not run together: camera {} has no picture between {} and {}, where {} has "
        "one; put a copy of {} in its place, or take that picture out of all cameras",
        lacks.name, before.filename().string(), lacks.pictures.pictures[at].filename().string(),
        (&lacks == &camera ? first->name : camera.name), before.filename().string()));
  }
}

std::string WordsOnGaps(const ShotCamera& camera) {
  const std::vector<fs::path>& pictures = camera.pictures.pictures;
  const std::vector<long> steps = StepsOf(camera.pictures);
  long missing = 0;
  std::string first;
  for (std::size_t i = 1; i < steps.size(); ++i) {
    if (steps[i] - steps[i - 1] < 2) continue;
    missing += steps[i] - steps[i - 1] - 1;
    if (first.empty())
      first = fmt::format("between {} and {}", PrintableName(pictures[i - 1].filename()),
                          PrintableName(pictures[i].filename()));
  }
  if (missing == 0) return "";
  return fmt::format(
      "camera {}: by their numbers {} pictures are missing, first {}; frames are counted without "
      "them, so no time passes there: put copies in their places where it shall",
      camera.name, missing, first);
}

}  // namespace keypose
