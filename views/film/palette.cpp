#include "views/film/palette.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

#include "core/values/size_of.h"

namespace keypose {
namespace {

using Color = std::array<std::uint8_t, 3>;

/// How much a difference in red, green and blue counts to the eye.
constexpr std::array<double, 3> kWeights{2, 4, 3};
constexpr int kKMeansRounds = 4;

/// A colour that occurs, and how often.
struct Weighted {
  std::array<double, 3> color{};
  double count = 0;
};

/// Consecutive colours that share one entry of the palette.
struct ColorBox {
  int begin = 0, end = 0;
  std::array<double, 3> mean{};
  double error = 0;  ///< sum of squared distances from the mean along the longest axis
  int axis = 0;
};

ColorBox Measured(const std::vector<Weighted>& colors, int begin, int end) {
  ColorBox box{begin, end, {}, 0, 0};
  double count = 0;
  for (int i = begin; i < end; ++i) count += colors[i].count;
  for (int axis = 0; axis < 3; ++axis) {
    double sum = 0, error = 0;
    for (int i = begin; i < end; ++i) sum += colors[i].count * colors[i].color[axis];
    box.mean[axis] = count > 0 ? sum / count : 0;
    for (int i = begin; i < end; ++i)
      error += colors[i].count * std::pow(colors[i].color[axis] - box.mean[axis], 2);
    error *= kWeights[axis];
    if (error > box.error) {
      box.error = error;
      box.axis = axis;
    }
  }
  return box;
}

/// Boxes of a median cut. Reorders the colours.
std::vector<ColorBox> CutBoxes(std::vector<Weighted>& colors, int count) {
  std::vector<ColorBox> boxes{Measured(colors, 0, SizeOf(colors))};
  while (SizeOf(boxes) < count) {
    const auto worst = std::max_element(
        boxes.begin(), boxes.end(), [](const auto& a, const auto& b) { return a.error < b.error; });
    if (!(worst->error > 0)) break;
    const ColorBox whole = *worst;
    const auto middle = std::stable_partition(
        colors.begin() + whole.begin, colors.begin() + whole.end,
        [&](const Weighted& one) { return one.color[whole.axis] < whole.mean[whole.axis]; });
    const int at = static_cast<int>(middle - colors.begin());
    if (at == whole.begin || at == whole.end) {  // equal but for rounding
      worst->error = 0;
      continue;
    }
    *worst = Measured(colors, whole.begin, at);
    boxes.push_back(Measured(colors, at, whole.end));
  }
  return boxes;
}

double SquaredDistance(const std::array<double, 3>& a, const std::array<double, 3>& b) {
  double sum = 0;
  for (int k = 0; k < 3; ++k) sum += kWeights[k] * (a[k] - b[k]) * (a[k] - b[k]);
  return sum;
}

/// Moves all centres but the first to the mean of the colours nearest to them.
void KMeansRound(const std::vector<Weighted>& colors, std::vector<std::array<double, 3>>& centers) {
  std::vector<Weighted> sums(centers.size());
  for (const Weighted& one : colors) {
    std::size_t nearest = 0;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t c = 0; c < centers.size(); ++c) {
      const double distance = SquaredDistance(one.color, centers[c]);
      if (distance < least) {
        least = distance;
        nearest = c;
      }
    }
    sums[nearest].count += one.count;
    for (int k = 0; k < 3; ++k) sums[nearest].color[k] += one.count * one.color[k];
  }
  for (std::size_t c = 1; c < centers.size(); ++c)
    if (sums[c].count > 0)
      for (int k = 0; k < 3; ++k) centers[c][k] = sums[c].color[k] / sums[c].count;
}

Color MostFrequent(const Image8& picture) {
  std::vector<std::uint32_t> colors(picture.data.size() / 3);
  for (std::size_t i = 0; i < colors.size(); ++i) {
    const std::uint8_t* rgb = picture.data.data() + 3 * i;
    colors[i] = static_cast<std::uint32_t>(rgb[0] << 16 | rgb[1] << 8 | rgb[2]);
  }
  std::sort(colors.begin(), colors.end());
  std::size_t most = 0;
  std::uint32_t best = 0;
  for (auto at = colors.begin(); at != colors.end();) {
    const auto end = std::upper_bound(at, colors.end(), *at);
    const auto count = static_cast<std::size_t>(end - at);
    if (count > most) {
      most = count;
      best = *at;
    }
    at = end;
  }
  const auto byte = [&](int shift) { return static_cast<std::uint8_t>(best >> shift & 255); };
  return {byte(16), byte(8), byte(0)};
}

/// Where the error of a pixel goes: columns in the direction of travel, rows down, sixteenths.
struct Share {
  int ahead, down, sixteenths;
};
constexpr Share kFloydSteinberg[] = {{1, 0, 7}, {-1, 1, 3}, {0, 1, 5}, {1, 1, 1}};

/// Errors that pixels pass on, for the row at hand and the next one. In fine steps, since a slow
/// gradient has errors of less than a level, which must add up.
class ErrorRows {
 public:
  explicit ErrorRows(int width) {
    for (auto& row : rows_) row.resize(static_cast<std::size_t>(width) + 2);
  }
  /// The colour with the error of its neighbours, in steps.
  std::array<int, 3> Wanted(const std::uint8_t* color, int x) const {
    std::array<int, 3> wanted;
    for (int k = 0; k < 3; ++k)
      wanted[k] = std::clamp(color[k] * kSteps + rows_[0][x + 1][k], 0, 255 * kSteps);
    return wanted;
  }
  void Pass(const std::array<int, 3>& wanted, const Color& taken, int x, int direction) {
    for (const Share& share : kFloydSteinberg)
      for (int k = 0; k < 3; ++k)
        rows_[share.down][x + 1 + direction * share.ahead][k] +=
            share.sixteenths * (wanted[k] - kSteps * taken[k]) / 16;
  }
  void NextRow() {
    std::swap(rows_[0], rows_[1]);
    std::fill(rows_[1].begin(), rows_[1].end(), std::array<int, 3>{});
  }
  static std::array<int, 3> Rounded(std::array<int, 3> steps) {
    for (int& value : steps) value = (value + kSteps / 2) / kSteps;
    return steps;
  }

 private:
  static constexpr int kSteps = 256;
  std::vector<std::array<int, 3>> rows_[2];  ///< with a column more at both ends
};

}  // namespace

int Palette::Nearest(const std::array<int, 3>& color) const {
  int best = 0, least = std::numeric_limits<int>::max();
  for (int i = 0; i < SizeOf(colors); ++i) {
    int sum = 0;
    for (int k = 0; k < 3; ++k) {
      const int way = color[k] - colors[i][k];
      sum += static_cast<int>(kWeights[k]) * way * way;
    }
    if (sum < least) {
      least = sum;
      best = i;
    }
  }
  return best;
}

ColorCounts::ColorCounts() : bins_(1 << 18) {}

void ColorCounts::Add(const Image8& picture) {
  if (empty_) background_ = MostFrequent(picture);
  empty_ = false;
  for (std::size_t i = 0; i + 2 < picture.data.size(); i += 3) {
    const std::uint8_t* rgb = picture.data.data() + i;
    Bin& bin = bins_[(rgb[0] >> 2) << 12 | (rgb[1] >> 2) << 6 | rgb[2] >> 2];
    ++bin.count;
    for (int k = 0; k < 3; ++k) bin.sum[k] += rgb[k];
  }
}

Palette ColorCounts::Choose(int count) const {
  std::vector<Weighted> colors;
  for (const Bin& bin : bins_) {
    if (bin.count == 0) continue;
    Weighted one;
    one.count = static_cast<double>(bin.count);
    for (int k = 0; k < 3; ++k) one.color[k] = static_cast<double>(bin.sum[k]) / one.count;
    colors.push_back(one);
  }
  std::vector<std::array<double, 3>> centers(1);
  std::copy(background_.begin(), background_.end(), centers[0].begin());
  for (const ColorBox& box : CutBoxes(colors, count - 1)) centers.push_back(box.mean);
  for (int round = 0; round < kKMeansRounds; ++round) KMeansRound(colors, centers);
  Palette palette;
  for (const auto& center : centers) {
    Color color;
    for (int k = 0; k < 3; ++k)
      color[k] = static_cast<std::uint8_t>(std::lround(std::clamp(center[k], 0.0, 255.0)));
    if (std::find(palette.colors.begin(), palette.colors.end(), color) == palette.colors.end())
      palette.colors.push_back(color);
  }
  return palette;
}

bool Ditherer::Keeps(const std::uint8_t* color, std::size_t pixel) const {
  if (shown_.empty()) return false;
  for (int k = 0; k < 3; ++k)
    if (std::abs(color[k] - shown_.data[3 * pixel + k]) > kSameColor) return false;
  return true;
}

Image8 Ditherer::Indices(const Image8& picture) {
  const int width = picture.width;
  Image8 indices(width, picture.height, 1);
  Image8 shown = shown_.empty() ? picture : shown_;
  ErrorRows errors(width);
  for (int y = 0; y < picture.height; ++y) {
    const int direction = y % 2 == 0 ? 1 : -1;
    for (int n = 0; n < width; ++n) {
      const int x = direction > 0 ? n : width - 1 - n;
      const std::uint8_t* color = picture.at(x, y);
      const std::size_t pixel = static_cast<std::size_t>(y) * width + x;
      if (Keeps(color, pixel)) {  // and takes no error on, which could only grow
        indices.data[pixel] = previous_.data[pixel];
        continue;
      }
      const auto wanted = errors.Wanted(color, x);
      const int index = palette_.Nearest(ErrorRows::Rounded(wanted));
      indices.data[pixel] = static_cast<std::uint8_t>(index);
      errors.Pass(wanted, palette_.colors[index], x, direction);
      std::copy_n(color, 3, shown.at(x, y));
    }
    errors.NextRow();
  }
  shown_ = std::move(shown);
  previous_ = indices;
  return indices;
}

}  // namespace keypose
