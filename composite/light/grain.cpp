#include "composite/light/grain.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/srgb.h"

namespace keypose::composite {
namespace {

constexpr std::size_t kFewestInBin = 200, kFewestOfAll = 2000;
/// Standard deviation of a normal distribution over its median absolute value.
constexpr double kSigmaOverMedian = 1.4826;
constexpr double kMostAlike = 0.6;

/// Stored levels are whole numbers: a median of their differences knows no fractions. A hash of the
/// place spreads each over its level.
float Spread(std::uint64_t key) {
  key ^= key >> 31;
  key *= 0x9e3779b97f4a7c15ULL;
  key ^= key >> 29;
  return static_cast<float>(key & 0xffff) / 65536.0f - 0.5f;
}

std::uint64_t Mixed(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15ULL;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ULL;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebULL;
  return x ^ (x >> 31);
}

/// Nearly normal: the sum of four uniform numbers of 16 bits.
float NormalAt(std::uint64_t key) {
  const std::uint64_t h = Mixed(key);
  const double sum =
      static_cast<double>((h & 0xffff) + (h >> 16 & 0xffff) + (h >> 32 & 0xffff) + (h >> 48)) /
      65535.0;
  return static_cast<float>((sum - 2) * 1.7320508075688772);
}

/// Differences along a row of the difference of two pictures, by level, for one distance.
struct Differences {
  std::array<std::vector<float>, Grain::kBins> by_level;
  std::vector<float> all;
};

Differences DifferencesOf(const Image8& a, const Image8& b, const Image8& away, int channel,
                          int distance) {
  Differences found;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x + distance < a.width; ++x) {
      if (!away.empty() && (*away.at(x, y) > 127 || *away.at(x + distance, y) > 127)) continue;
      const int a0 = a.at(x, y)[channel], b0 = b.at(x, y)[channel],
                a1 = a.at(x + distance, y)[channel], b1 = b.at(x + distance, y)[channel];
      if (std::min({a0, b0, a1, b1}) <= 1 || std::max({a0, b0, a1, b1}) >= 254) continue;
      const std::uint64_t place = (static_cast<std::uint64_t>(y) << 20) + x;
      const float d = std::abs(static_cast<float>((a0 - b0) - (a1 - b1)) + Spread(place));
      found.by_level[std::min((a0 + b0) / 64, Grain::kBins - 1)].push_back(d);
      found.all.push_back(d);
    }
  return found;
}

/// Variance that rounding and spreading add to each difference: four roundings and one spread.
constexpr double kRounding = 5.0 / 12;

double SigmaOf(std::vector<float>& differences, double share_b) {
  const double sd = kSigmaOverMedian * UpperMedianInPlace(differences);
  return std::sqrt(std::max(0.0, sd * sd - kRounding) / (2 * (1 + share_b)));
}

/// Bins without pixels take the value of the nearest one with.
void FillBins(const std::array<double, Grain::kBins>& known, double otherwise,
              std::array<double, Grain::kBins>* sigma) {
  for (int bin = 0; bin < Grain::kBins; ++bin) {
    (*sigma)[bin] = otherwise;
    for (int away = 0; away < Grain::kBins; ++away) {
      const int low = bin - away, high = bin + away;
      if (low >= 0 && known[low] >= 0)
        (*sigma)[bin] = known[low];
      else if (high < Grain::kBins && known[high] >= 0)
        (*sigma)[bin] = known[high];
      else
        continue;
      break;
    }
  }
}

/// Weight of the neighbours in a filter [w, 1, w] whose output has this correlation at distance 1.
double NeighbourWeight(double correlation) {
  double low = 0, high = 0.7;
  for (int i = 0; i < 40; ++i) {
    const double w = (low + high) / 2;
    (2 * w / (1 + 2 * w * w) < correlation ? low : high) = w;
  }
  return low;
}

}  // namespace

double Grain::SigmaAt(int channel, double level) const {
  const double at = std::clamp(level / 256 * kBins - 0.5, 0.0, kBins - 1.0);
  const int low = std::min(static_cast<int>(at), kBins - 2);
  const double share = at - low;
  return (1 - share) * sigma[channel][low] + share * sigma[channel][low + 1];
}

double Grain::MeanSigma() const {
  double sum = 0;
  for (const auto& channel : sigma)
    for (const double s : channel) sum += s;
  return sum / (3 * kBins);
}

std::optional<Grain> MeasureGrain(const Image8& a, const Image8& b, const Image8& away,
                                  double share_b) {
  Grain grain;
  double near_sum = 0, far_sum = 0;
  for (int c = 0; c < 3; ++c) {
    // Two pixels apart, so that the likeness of neighbours does not make the grain look weaker.
    Differences far = DifferencesOf(a, b, away, c, 3), near = DifferencesOf(a, b, away, c, 1);
    if (far.all.size() < kFewestOfAll) return std::nullopt;
    std::array<double, Grain::kBins> known;
    known.fill(-1);
    for (int bin = 0; bin < Grain::kBins; ++bin)
      if (far.by_level[bin].size() >= kFewestInBin)
        known[bin] = SigmaOf(far.by_level[bin], share_b);
    const double over_all = SigmaOf(far.all, share_b);
    FillBins(known, over_all, &grain.sigma[c]);
    far_sum += over_all * over_all;
    near_sum += std::pow(SigmaOf(near.all, share_b), 2);
  }
  if (far_sum > 0) grain.neighbours = std::clamp(1 - near_sum / far_sum, 0.0, kMostAlike);
  return grain;
}

namespace {

/// Calls put(x, y, c, level, what grain adds to it) for each value.
template <class Level, class Put>
void ForGrain(const ImageF& picture, const Grain& grain, const ImageF& share, std::uint64_t seed,
              const Level& level_of, const Put& put) {
  const double w = grain.neighbours > 0.03 ? NeighbourWeight(grain.neighbours) : 0;
  const double norm = 1 / (1 + 2 * w * w);  // of the filter along rows and columns
  const std::uint64_t stream = Mixed(seed) << 16;
  const auto noise = [&](int x, int y, int c) {
    const std::uint64_t place = (static_cast<std::uint64_t>(y + 1) << 24) + ((x + 1) << 2) + c;
    return NormalAt(stream ^ place);
  };
  const auto grainy = [&](int x, int y, int c) {
    if (w == 0) return static_cast<double>(noise(x, y, c));
    double sum = 0;
    for (int j = -1; j <= 1; ++j)
      for (int i = -1; i <= 1; ++i) sum += (i ? w : 1) * (j ? w : 1) * noise(x + i, y + j, c);
    return sum * norm;
  };
  ParallelFor(picture.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < picture.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const double level = level_of(picture.at(x, y)[c]);
        const double lacks = share.empty() ? 1 : std::clamp(*share.at(x, y), 0.0f, 1.0f);
        const double sigma = grain.SigmaAt(c, level) * std::sqrt(lacks);
        put(x, y, c, level, sigma > 0 ? sigma * grainy(x, y, c) : 0);
      }
  });
}

/// Also of light below black and above white; what is no number counts as black.
double LevelOfLight(float light) {
  if (!(light > 0)) return light < 0 ? std::max(255 * 12.92 * light, -255.0) : 0;
  return std::min(255 * SrgbFromLinear(light), 1e6);
}

}  // namespace

ImageF WithGrain(const ImageF& levels, const Grain& grain, const ImageF& share,
                 std::uint64_t seed) {
  ImageF out(levels.width, levels.height, 3);
  ForGrain(
      levels, grain, share, seed, [](float level) { return static_cast<double>(level); },
      [&](int x, int y, int c, double level, double added) {
        out.at(x, y)[c] = static_cast<float>(std::clamp(level + added, 0.0, 255.0));
      });
  return out;
}

ImageF LightWithGrain(const ImageF& light, const Grain& grain, const ImageF& share,
                      std::uint64_t seed) {
  ImageF out = light;
  ForGrain(light, grain, share, seed, LevelOfLight,
           [&](int x, int y, int c, double level, double added) {
             if (added != 0)
               out.at(x, y)[c] += static_cast<float>(LinearFromSrgb((level + added) / 255) -
                                                     LinearFromSrgb(level / 255));
           });
  return out;
}

}  // namespace keypose::composite
