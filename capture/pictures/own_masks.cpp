#include "capture/pictures/own_masks.h"

#include <cstdlib>
#include <utility>

#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "core/pictures/given_matte.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

/// Pixels on either side of a border that are compared.
constexpr int kBorderReach = 2;

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

}  // namespace

Image8 PlacedMask(Image8 mask, const MaskPlace& place, MaskChange* change) {
  MaskChange found;
  if (LiesAsStored(mask, place.width, place.height, place.orientation)) {
    mask = Oriented(std::move(mask), place.orientation);
    found.turned = true;
  }
  if (!CanLieOn(mask, place.width, place.height))
    throw InputError("capture: mask " + place.mask + " is " +
                     MaskSizeText(mask.width, mask.height) + ", but " + place.photograph + " is " +
                     MaskSizeText(place.width, place.height) +
                     "; make the mask at the photograph's size, or smaller in its shape");
  if (mask.width != place.width || mask.height != place.height) {
    mask = ResizedTo(mask, place.width, place.height);
    found.enlarged = true;
  }
  if (change) *change = found;
  return mask;
}

MaskSide SideOf(const Image8& mask) {
  if (IsEmptyMatte(mask)) return MaskSide::kNothing;
  return CoversBorder(mask) ? MaskSide::kSurroundings : MaskSide::kFigure;
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
