#include "synth/rooms/canvas.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;

constexpr int kFraction = 4;  // bits of a pixel in OpenCV's drawing
constexpr int kOne = 1 << kFraction;

cv::Mat MatOf(Image8& image) { return {image.height, image.width, CV_8UC3, image.data.data()}; }

cv::Scalar ScalarOf(const Ink& ink) { return {double(ink[0]), double(ink[1]), double(ink[2])}; }

/// OpenCV has the middle of the first pixel at 0.
cv::Point Fixed(const Vector2d& pixel) {
  return {static_cast<int>(std::lround((pixel.x() - 0.5) * kOne)),
          static_cast<int>(std::lround((pixel.y() - 0.5) * kOne))};
}

std::vector<Vector2d> Arc(const Vector2d& center, double radius, double from, double to,
                          int steps) {
  std::vector<Vector2d> points;
  for (int i = 0; i <= steps; ++i) {
    const double angle = from + (to - from) * i / steps;
    points.push_back(center + radius * Vector2d(std::cos(angle), std::sin(angle)));
  }
  return points;
}

/// x ^ (1 / 2.2) for light that is multiplied by x; by a table, since each pixel needs it.
double Encoded(double x) {
  constexpr int kSteps = 2048;
  constexpr double kMost = 8;
  static const std::vector<double> table = [] {
    std::vector<double> values;
    for (int i = 0; i <= kSteps + 1; ++i) values.push_back(std::pow(kMost * i / kSteps, 1 / 2.2));
    return values;
  }();
  const double at = std::clamp(x, 0.0, kMost) / kMost * kSteps;
  const int i = static_cast<int>(at);
  return table[i] + (at - i) * (table[i + 1] - table[i]);
}

/// One of eight directions at a lattice point, times the way from it.
double Slope(int x, int y, std::uint32_t seed, double dx, double dy) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8da6b343u ^
                    static_cast<std::uint32_t>(y) * 0xd8163841u ^ seed * 0x9e3779b1u;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 13;
  constexpr double kHalf = 0.7071067811865476;
  static constexpr double kWays[8][2] = {{1, 0},          {0, 1},          {-1, 0},
                                         {0, -1},         {kHalf, kHalf},  {-kHalf, kHalf},
                                         {kHalf, -kHalf}, {-kHalf, -kHalf}};
  const double* way = kWays[h & 7];
  return way[0] * dx + way[1] * dy;
}

}  // namespace

double PlaneNoise(double x, double y, std::uint32_t seed) {
  const double fx = std::floor(x), fy = std::floor(y), u = x - fx, v = y - fy;
  const int ix = static_cast<int>(fx), iy = static_cast<int>(fy);
  const auto fade = [](double t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  const double su = fade(u), sv = fade(v);
  const double above =
                   (1 - su) * Slope(ix, iy, seed, u, v) + su * Slope(ix + 1, iy, seed, u - 1, v),
               below = (1 - su) * Slope(ix, iy + 1, seed, u, v - 1) +
                       su * Slope(ix + 1, iy + 1, seed, u - 1, v - 1);
  return 1.4 * ((1 - sv) * above + sv * below);
}

double PlaneFractal(double x, double y, int octaves, double gain, std::uint32_t seed) {
  double sum = 0, height = 1, frequency = 1;
  for (int i = 0; i < octaves; ++i, height *= gain, frequency *= 2)
    sum += height *
           PlaneNoise(frequency * x, frequency * y, seed + 101u * static_cast<std::uint32_t>(i));
  return sum;
}

Ink InkOf(double hue, double saturation, double value) {
  Ink ink{};
  for (int c = 0; c < 3; ++c) {
    const double turn = hue + 1 - c / 3.0, to_primary = std::abs(turn - std::round(turn)) * 6;
    const double full = std::clamp(2 - to_primary, 0.0, 1.0);
    ink[c] = static_cast<std::uint8_t>(
        std::lround(255 * std::clamp(value * (1 - saturation * (1 - full)), 0.0, 1.0)));
  }
  return ink;
}

Ink Mixed(const Ink& a, const Ink& b, double share) {
  Ink mixed{};
  for (int c = 0; c < 3; ++c)
    mixed[c] = static_cast<std::uint8_t>(std::lround(a[c] + share * (b[c] - a[c])));
  return mixed;
}

std::string Word(Random& random) {
  static const char* const kSyllables[] = {"KA",  "LO", "MI",  "REN", "TU",  "SOL", "VA", "NE",
                                           "PRI", "DO", "BEL", "FU",  "GAR", "ZI",  "OX", "TAM"};
  std::string word;
  for (int i = 2 + random.Below(3); i > 0; --i) word += kSyllables[random.Below(16)];
  return word;
}

Canvas::Canvas(double width_m, double height_m, double pixels_per_m, const Ink& ground)
    : picture_(std::max(1, static_cast<int>(std::lround(width_m * pixels_per_m))),
               std::max(1, static_cast<int>(std::lround(height_m * pixels_per_m))), 3),
      pixels_per_m_(pixels_per_m) {
  MatOf(picture_).setTo(ScalarOf(ground));
}

void Canvas::Polygon(const std::vector<Vector2d>& corners, const Ink& ink) {
  std::vector<cv::Point> fixed;
  for (const Vector2d& corner : corners) fixed.push_back(Fixed(pixels_per_m_ * corner));
  cv::Mat mat = MatOf(picture_);
  cv::fillPoly(mat, std::vector<std::vector<cv::Point>>{fixed}, ScalarOf(ink), cv::LINE_AA,
               kFraction);
}

void Canvas::Bar(const Vector2d& center, const Vector2d& size, double turn_rad, const Ink& ink) {
  const Vector2d along(std::cos(turn_rad), std::sin(turn_rad)), across(-along.y(), along.x());
  const Vector2d a = size.x() / 2 * along, b = size.y() / 2 * across;
  Polygon({center - a - b, center + a - b, center + a + b, center - a + b}, ink);
}

void Canvas::Disc(const Vector2d& center, double radius, const Ink& ink) {
  Polygon(Arc(center, radius, 0, 6.283185307179586, 48), ink);
}

void Canvas::Ring(const Vector2d& center, double radius, double width, const Ink& ink,
                  double from_rad, double to_rad) {
  const int steps = std::max(4, static_cast<int>(std::ceil((to_rad - from_rad) * 24)));
  std::vector<Vector2d> outline = Arc(center, radius + width / 2, from_rad, to_rad, steps);
  const std::vector<Vector2d> inner = Arc(center, radius - width / 2, from_rad, to_rad, steps);
  outline.insert(outline.end(), inner.rbegin(), inner.rend());
  Polygon(outline, ink);
}

void Canvas::Line(const Vector2d& a, const Vector2d& b, double width, const Ink& ink) {
  const Vector2d way = b - a;
  if (way.isZero(0)) return;
  Bar((a + b) / 2, {way.norm(), width}, std::atan2(way.y(), way.x()), ink);
}

void Canvas::Text(const std::string& text, const Vector2d& center, double height, double turn_rad,
                  const Ink& ink) {
  constexpr int kFace = cv::FONT_HERSHEY_DUPLEX;
  const double pixels = height * pixels_per_m_;
  if (pixels < 2) return;
  const double scale = pixels / 21;  // a capital has 21 units
  const int weight = std::max(1, static_cast<int>(std::lround(pixels / 11)));
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFace, scale, weight, &below);
  const int margin = weight + 2;
  cv::Mat letters =
      cv::Mat::zeros(size.height + below + 2 * margin, size.width + 2 * margin, CV_8UC1);
  cv::putText(letters, text, {margin, margin + size.height}, kFace, scale, 255, weight,
              cv::LINE_AA);
  const Vector2d middle = pixels_per_m_ * center;
  const double c = std::cos(turn_rad), s = std::sin(turn_rad), mx = letters.cols / 2.0,
               my = margin + size.height / 2.0;
  const cv::Matx23d placed(c, -s, middle.x() - c * mx + s * my, s, c, middle.y() - s * mx - c * my);
  const int reach = static_cast<int>(std::hypot(letters.cols, letters.rows) / 2) + 2;
  const cv::Rect part = cv::Rect(static_cast<int>(middle.x()) - reach,
                                 static_cast<int>(middle.y()) - reach, 2 * reach, 2 * reach) &
                        cv::Rect(0, 0, picture_.width, picture_.height);
  if (part.empty()) return;
  cv::Matx23d shifted = placed;
  shifted(0, 2) -= part.x;
  shifted(1, 2) -= part.y;
  cv::Mat cover;
  cv::warpAffine(letters, cover, shifted, part.size(), cv::INTER_LINEAR);
  for (int y = 0; y < part.height; ++y)
    for (int x = 0; x < part.width; ++x) {
      std::uint8_t* out = picture_.at(part.x + x, part.y + y);
      const int share = cover.at<std::uint8_t>(y, x);
      for (int k = 0; k < 3; ++k)
        out[k] = static_cast<std::uint8_t>((out[k] * (255 - share) + ink[k] * share + 127) / 255);
    }
}

void Canvas::Shade(const std::function<double(double, double)>& factor) {
  ParallelFor(
      picture_.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < picture_.width; ++x) {
          // Nearly the factor on the byte that belongs to this one on the light.
          const double by = Encoded(factor((x + 0.5) / pixels_per_m_, (y + 0.5) / pixels_per_m_));
          std::uint8_t* pixel = picture_.at(x, y);
          for (int c = 0; c < 3; ++c)
            pixel[c] = static_cast<std::uint8_t>(std::min(by * pixel[c] + 0.5, 255.0));
        }
      },
      16);
}

void Canvas::Tint(const Ink& ink, const std::function<double(double, double)>& share) {
  ParallelFor(
      picture_.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < picture_.width; ++x) {
          const double part =
              std::clamp(share((x + 0.5) / pixels_per_m_, (y + 0.5) / pixels_per_m_), 0.0, 1.0);
          std::uint8_t* pixel = picture_.at(x, y);
          const Ink mixed = Mixed({pixel[0], pixel[1], pixel[2]}, ink, part);
          std::copy(mixed.begin(), mixed.end(), pixel);
        }
      },
      16);
}

void Canvas::Grain(double wavelength_m, double strength, int octaves, std::uint32_t seed) {
  Shade([=](double x, double y) {
    return 1 + strength * PlaneFractal(x / wavelength_m, y / wavelength_m, octaves, 0.7, seed);
  });
}

Print Canvas::Done(bool repeats) && {
  const double width = width_m();
  return Print(std::move(picture_), width, repeats);
}

}  // namespace keypose::synth
