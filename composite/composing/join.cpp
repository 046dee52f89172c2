#include "composite/composing/join.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "composite/layer/linear_light.h"

namespace keypose::composite {
namespace {

constexpr int kBoxMargin = 8;   // [px]
constexpr double kProfile = 5;  // [px] to each side of the outline
constexpr double kMostShift = 3, kShiftStep = 0.1, kProfileStep = 0.5;
constexpr double kLeastContrast = 20;  // levels along a profile

double LumaAt(const Image8& picture, double x, double y) {
  const double px = std::clamp(x - 0.5, 0.0, picture.width - 1.001),
               py = std::clamp(y - 0.5, 0.0, picture.height - 1.001);
  const int x0 = static_cast<int>(px), y0 = static_cast<int>(py);
  const double fx = px - x0, fy = py - y0;
  const auto luma = [&](int i, int j) {
    const std::uint8_t* p = picture.at(x0 + i, y0 + j);
    return 0.3 * p[0] + 0.59 * p[1] + 0.11 * p[2];
  };
  return (1 - fy) * ((1 - fx) * luma(0, 0) + fx * luma(1, 0)) +
         fy * ((1 - fx) * luma(0, 1) + fx * luma(1, 1));
}

/// Luma along a line through a point of the outline.
std::vector<double> ProfileOf(const Image8& picture, const Eigen::Vector2d& at,
                              const Eigen::Vector2d& normal, double shift, double reach) {
  std::vector<double> values;
  for (double s = -reach; s <= reach + 1e-9; s += kProfileStep) {
    const Eigen::Vector2d p = at + (s + shift) * normal;
    values.push_back(LumaAt(picture, p.x(), p.y()));
  }
  return values;
}

double SumOfSquares(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

/// How far the filmed edge lies from the rendered one; NaN where there is hardly an edge.
double EdgeShift(const Image8& rendered, const Image8& filmed, const Eigen::Vector2d& at,
                 const Eigen::Vector2d& normal) {
  const std::vector<double> mine = ProfileOf(rendered, at, normal, 0, kProfile);
  const auto [low, high] = std::minmax_element(mine.begin(), mine.end());
  if (*high - *low < kLeastContrast) return std::nan("");
  double best = 0, least = SumOfSquares(mine, ProfileOf(filmed, at, normal, 0, kProfile));
  for (double shift = -kMostShift; shift <= kMostShift + 1e-9; shift += kShiftStep) {
    const double cost = SumOfSquares(mine, ProfileOf(filmed, at, normal, shift, kProfile));
    if (cost < least) {
      least = cost;
      best = shift;
    }
  }
  return best;
}

void MeasureEdges(const Image8& rendered, const Image8& filmed, const ImageF& coverage,
                  JoinFigures* figures) {
  const ImageF soft = Blurred(coverage, 1.0);
  double sum = 0;
  int measured = 0, all = 0;
  for (int y = std::max(1, figures->box[1]); y < std::min(coverage.height - 1, figures->box[3]);
       ++y)
    for (int x = std::max(1, figures->box[0]); x < std::min(coverage.width - 1, figures->box[2]);
         ++x) {
      const bool outline = *coverage.at(x, y) >= 0.5f &&
                           std::min({*coverage.at(x - 1, y), *coverage.at(x + 1, y),
                                     *coverage.at(x, y - 1), *coverage.at(x, y + 1)}) < 0.5f;
      if (!outline || (x + 2 * y) % 3 != 0) continue;  // one in three
      const Eigen::Vector2d normal(*soft.at(x + 1, y) - *soft.at(x - 1, y),
                                   *soft.at(x, y + 1) - *soft.at(x, y - 1));
      if (normal.norm() < 1e-3) continue;
      ++all;
      const double shift = EdgeShift(rendered, filmed, {x + 0.5, y + 0.5}, normal.normalized());
      if (std::isnan(shift)) continue;
      sum += std::abs(shift);
      ++measured;
    }
  if (measured) figures->edge_px = sum / measured;
  if (all) figures->edge_share = static_cast<double>(measured) / all;
}

double ColourDifference(const Image8& a, const Image8& b, const ImageF& coverage) {
  ImageF difference(a.width, a.height, 4);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      const float w = *coverage.at(x, y) > 0.99f ? 1 : 0;
      for (int c = 0; c < 3; ++c)
        difference.at(x, y)[c] = w * static_cast<float>(a.at(x, y)[c] - b.at(x, y)[c]);
      difference.at(x, y)[3] = w;
    }
  const ImageF soft = Blurred(difference, 4);
  double sum = 0, count = 0;
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      if (*coverage.at(x, y) <= 0.99f) continue;
      const float* d = soft.at(x, y);
      for (int c = 0; c < 3; ++c) sum += std::abs(d[c] / std::max(d[3], 1e-3f)) / 3;
      ++count;
    }
  return count ? sum / count : 0;
}

}  // namespace

double PsnrWithin(const Image8& a, const Image8& b, const int box[4]) {
  double sum = 0, count = 0;
  for (int y = box[1]; y < box[3]; ++y)
    for (int x = box[0]; x < box[2]; ++x)
      for (int c = 0; c < 3; ++c) {
        const double d = static_cast<double>(a.at(x, y)[c]) - b.at(x, y)[c];
        sum += d * d;
        ++count;
      }
  if (count == 0 || sum == 0) return 99;
  return std::min(99.0, 10 * std::log10(255.0 * 255.0 * count / sum));
}

JoinFigures MeasureJoin(const Image8& rendered, const Image8& filmed, const ImageF& coverage) {
  JoinFigures figures;
  int* box = figures.box;
  box[0] = coverage.width;
  box[1] = coverage.height;
  for (int y = 0; y < coverage.height; ++y)
    for (int x = 0; x < coverage.width; ++x) {
      if (*coverage.at(x, y) < 0.5f) continue;
      box[0] = std::min(box[0], x);
      box[2] = std::max(box[2], x + 1);
      box[1] = std::min(box[1], y);
      box[3] = std::max(box[3], y + 1);
    }
  if (box[2] == 0) return {};
  for (int k = 0; k < 2; ++k) {
    box[k] = std::max(0, box[k] - kBoxMargin);
    box[k + 2] = std::min(k ? coverage.height : coverage.width, box[k + 2] + kBoxMargin);
  }
  figures.psnr_db = PsnrWithin(rendered, filmed, box);
  figures.colour_levels = ColourDifference(rendered, filmed, coverage);
  MeasureEdges(rendered, filmed, coverage, &figures);
  return figures;
}

Image8 SideBySide(const Image8& filmed, const Image8& rendered) {
  constexpr int kGap = 4, kTimes = 4;
  Image8 sheet(3 * filmed.width + 2 * kGap, filmed.height, 3, 255);
  for (int y = 0; y < filmed.height; ++y)
    for (int x = 0; x < filmed.width; ++x)
      for (int c = 0; c < 3; ++c) {
        const int a = filmed.at(x, y)[c], b = rendered.at(x, y)[c];
        sheet.at(x, y)[c] = static_cast<std::uint8_t>(a);
        sheet.at(x + filmed.width + kGap, y)[c] = static_cast<std::uint8_t>(b);
        sheet.at(x + 2 * (filmed.width + kGap), y)[c] =
            static_cast<std::uint8_t>(std::clamp(128 + kTimes * (b - a), 0, 255));
      }
  return sheet;
}

}  // namespace keypose::composite
