#include "capture/films/pixel_modes.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"

namespace keypose::capture {
namespace {

constexpr int kMostCandidates = 12;

struct Candidate {
  std::array<double, 3> mean{};
  int count = 0, name = 0;
};

double DistanceTo(const Candidate& candidate, const std::uint8_t* lab) {
  const double light = 0.5 * (lab[0] - candidate.mean[0]), a = lab[1] - candidate.mean[1],
               b = lab[2] - candidate.mean[2];
  return std::sqrt(light * light + a * a + b * b);
}

/// One pixel's colours in the film's order: each joins the nearest mode, or begins one.
class PixelHistory {
 public:
  explicit PixelHistory(double radius) : radius_(radius) {}

  /// @return the candidate's name; -1: all places are taken
  int Add(const std::uint8_t* lab) {
    int best = -1;
    double nearest = radius_;
    for (int i = 0; i < count_; ++i)
      if (const double d = DistanceTo(candidates_[i], lab); d < nearest) {
        nearest = d;
        best = i;
      }
    if (best < 0 && count_ == kMostCandidates) return -1;
    if (best < 0) {
      best = count_++;
      candidates_[best].name = best;
    }
    Candidate& into = candidates_[best];
    ++into.count;
    for (int c = 0; c < 3; ++c) into.mean[c] += (lab[c] - into.mean[c]) / into.count;
    return best;
  }

  /// Writes the most frequent modes. @return the rank of each candidate
  std::array<std::uint8_t, kMostCandidates> Write(int frames, PixelMode* modes) {
    std::stable_sort(candidates_.begin(), candidates_.begin() + count_,
                     [](const Candidate& a, const Candidate& b) { return a.count > b.count; });
    std::array<std::uint8_t, kMostCandidates> rank;
    rank.fill(kNoMode);
    for (int i = 0; i < std::min(count_, kMostModes); ++i) {
      rank[candidates_[i].name] = static_cast<std::uint8_t>(i);
      for (int c = 0; c < 3; ++c)
        modes[i].lab[c] = static_cast<std::uint8_t>(std::lround(candidates_[i].mean[c]));
      modes[i].share = static_cast<std::uint8_t>(std::max(1, 255 * candidates_[i].count / frames));
    }
    return rank;
  }

 private:
  double radius_;
  std::array<Candidate, kMostCandidates> candidates_;
  int count_ = 0;
};

}  // namespace

double ModeDistance(const std::uint8_t* a, const std::uint8_t* b) {
  const double light = 0.5 * (a[0] - b[0]), da = a[1] - b[1], db = a[2] - b[2];
  return std::sqrt(light * light + da * da + db * db);
}

double ModeRadius(const std::vector<Image8>& lab) {
  constexpr double kUsual = 0.8, kTimes = 5, kLeast = 6, kMost = 14;
  constexpr std::size_t kStride = 7;
  std::vector<float> changes;
  for (std::size_t k = 1; k < lab.size(); k += 1 + lab.size() / 8)
    for (std::size_t p = 0; p + 2 < lab[k].data.size(); p += 3 * kStride)
      changes.push_back(static_cast<float>(ModeDistance(&lab[k].data[p], &lab[k - 1].data[p])));
  if (changes.empty()) return kLeast;
  const double usual = QuantileFloor(std::move(changes), kUsual);
  return std::clamp(kTimes * usual, kLeast, kMost);
}

PixelModes FindPixelModes(const std::vector<Image8>& lab, double radius) {
  PixelModes found;
  if (lab.empty()) return found;
  found.width = lab[0].width;
  found.height = lab[0].height;
  found.modes.resize(static_cast<std::size_t>(found.width) * found.height * kMostModes);
  for (const Image8& frame : lab) found.labels.emplace_back(frame.width, frame.height, 1, kNoMode);
  const int frames = static_cast<int>(lab.size());
  ParallelFor(found.height, [&](std::int64_t y) {
    std::vector<int> names(lab.size());
    for (int x = 0; x < found.width; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * found.width + x;
      PixelHistory history(radius);
      for (std::size_t k = 0; k < lab.size(); ++k) names[k] = history.Add(&lab[k].data[3 * pixel]);
      const auto rank = history.Write(frames, &found.modes[pixel * kMostModes]);
      for (std::size_t k = 0; k < lab.size(); ++k)
        if (names[k] >= 0) found.labels[k].data[pixel] = rank[names[k]];
    }
  });
  return found;
}

}  // namespace keypose::capture
