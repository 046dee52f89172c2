#include "capture/pictures/own_masks.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

constexpr double kBorderOfSurroundings = 0.9;
/// A speck of black in a white mask is no figure: the mask says that the figure fills the picture.
constexpr double kLeastFigure = 0.001;
/// A smaller mask has no outline that would be worth using.
constexpr int kMostEnlarged = 8;
/// Pixels on either side of a border that are compared.
constexpr int kBorderReach = 2;

/// Whether a picture of one size has the shape of another, to a pixel's rounding.
bool SameShape(const Image8& image, int width, int height) {
  const std::int64_t a = std::int64_t{image.width} * height, b = std::int64_t{image.height} * width;
  return std::abs(a - b) <= std::max(width, height);
}

bool IsOfSize(const Image8& image, int width, int height) {
  return image.width == width && image.height == height;
}

std::string MaskSizeText(int width, int height) {
  return std::to_string(width) + " x " + std::to_string(height);
}

Image8 ResizedTo(const Image8& mask, int width, int height) {
  const bool shrinks = width < mask.width;
  Image8 resized(width, height, 1);
  cv::Mat to = MatOf(resized);
  cv::resize(MatOf(mask), to, to.size(), 0, 0, shrinks ? cv::INTER_AREA : cv::INTER_LINEAR);
  for (std::uint8_t& m : resized.data) m = m > 127 ? 255 : 0;
  return resized;
}

double WhiteShare(const Image8& mask) {
  const auto white = std::count(mask.data.begin(), mask.data.end(), 255);
  return static_cast<double>(white) / static_cast<double>(mask.data.size());
}

double WhiteShareOfBorder(const Image8& mask) {
  int white = 0, all = 0;
  const auto count = [&](int x, int y) {
    white += *mask.at(x, y) > 127;
    ++all;
  };
  for (int x = 0; x < mask.width; ++x) {
    count(x, 0);
    count(x, mask.height - 1);
  }
  for (int y = 0; y < mask.height; ++y) {
    count(0, y);
    count(mask.width - 1, y);
  }
  return static_cast<double>(white) / all;
}

}  // namespace

Image8 PlacedMask(Image8 mask, const MaskPlace& place, MaskChange* change) {
  MaskChange found;
  const bool on_its_side = place.orientation >= 5;
  if (!IsOfSize(mask, place.width, place.height)) {
    const bool stored = on_its_side && (IsOfSize(mask, place.height, place.width) ||
                                        (!SameShape(mask, place.width, place.height) &&
                                         SameShape(mask, place.height, place.width)));
    if (stored) {
      mask = Oriented(std::move(mask), place.orientation);
      found.turned = true;
    }
  }
  if (!SameShape(mask, place.width, place.height) || mask.width * kMostEnlarged < place.width)
    throw InputError("capture: mask " + place.mask + " is " +
                     MaskSizeText(mask.width, mask.height) + ", but " + place.photograph + " is " +
                     MaskSizeText(place.width, place.height) +
                     "; make the mask at the photograph's size, or smaller in its shape");
  if (!IsOfSize(mask, place.width, place.height)) {
    mask = ResizedTo(mask, place.width, place.height);
    found.enlarged = true;
  }
  if (change) *change = found;
  return mask;
}

MaskSide SideOf(const Image8& mask) {
  const double white = WhiteShare(mask);
  if (white == 0) return MaskSide::kNothing;
  if (white > 1 - kLeastFigure) return MaskSide::kFigure;
  return WhiteShareOfBorder(mask) > kBorderOfSurroundings ? MaskSide::kSurroundings
                                                          : MaskSide::kFigure;
}

Image8 Inverted(Image8 mask) {
  for (std::uint8_t& m : mask.data) m = static_cast<std::uint8_t>(255 - m);
  return mask;
}

double BorderContrast(const Image8& grey, const Image8& mask) {
  double sum = 0;
  std::int64_t pairs = 0;
  const auto compare = [&](int x, int y, int to_x, int to_y) {
    if (to_x >= mask.width || to_y >= mask.height || *mask.at(x, y) == *mask.at(to_x, to_y)) return;
    sum += std::abs(int{*grey.at(x, y)} - int{*grey.at(to_x, to_y)});
    ++pairs;
  };
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      compare(x, y, x + kBorderReach, y);
      compare(x, y, x, y + kBorderReach);
    }
  return pairs ? sum / static_cast<double>(pairs) : 0;
}

}  // namespace keypose::capture
