#include "reconstruct/matching/feature_crop.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "core/values/errors.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

// No record of the data. Sensitivity: docs/results/sensitivity.md.
// Pixels around the grown mask that stay unchanged, and over which the rest then fades. The fade is
// wide relative to a feature's window, so that it is no feature itself; features' centres are
// inside the grown mask.
struct FeatureCropTuning {
  KEYPOSE_TUNED(int, kKeep_px, 16);  // unchanged
  KEYPOSE_TUNED(int, kFade_px, 24);  // of the fade
};

struct CropBox {
  int x0, y0, x1, y1;
};

CropBox BoxOf(const Image8& mask) {
  CropBox box{mask.width, mask.height, 0, 0};
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) > 127)
        box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1),
               std::max(box.y1, y + 1)};
  return box;
}

/// Chessboard distance to the mask, at most `limit`: two passes.
ImageT<int> DistanceTo(const Image8& mask, int limit) {
  ImageT<int> distance(mask.width, mask.height, 1, limit);
  const auto relax = [&](int x, int y, int dx, int dy) {
    if (x + dx < 0 || x + dx >= mask.width || y + dy < 0 || y + dy >= mask.height) return;
    *distance.at(x, y) = std::min(*distance.at(x, y), *distance.at(x + dx, y + dy) + 1);
  };
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (*mask.at(x, y) > 127) *distance.at(x, y) = 0;
      relax(x, y, -1, 0);
      relax(x, y, -1, -1);
      relax(x, y, 0, -1);
      relax(x, y, 1, -1);
    }
  for (int y = mask.height - 1; y >= 0; --y)
    for (int x = mask.width - 1; x >= 0; --x) {
      relax(x, y, 1, 0);
      relax(x, y, 1, 1);
      relax(x, y, 0, 1);
      relax(x, y, -1, 1);
    }
  return distance;
}

Image8 Cut(const Image8& image, const CropBox& box) {
  Image8 cut(box.x1 - box.x0, box.y1 - box.y0, 1);
  for (int y = 0; y < cut.height; ++y)
    std::copy_n(image.at(box.x0, box.y0 + y), cut.width, cut.at(0, y));
  return cut;
}

}  // namespace

ObjectCrop CropToObject(const Image8& photo, const Image8& mask, int margin_px) {
  if (photo.channels != 1 || mask.channels != 1 || photo.width != mask.width ||
      photo.height != mask.height)
    throw InputError("a photograph of " + std::to_string(photo.width) + " x " +
                     std::to_string(photo.height) + " has a mask of " + std::to_string(mask.width) +
                     " x " + std::to_string(mask.height) + "; both must be grey and of one size");
  CropBox box = BoxOf(mask);
  if (box.x0 >= box.x1) return {photo, Image8(photo.width, photo.height, 1, 0), 0, 0};
  const int reach = margin_px + FeatureCropTuning::kKeep_px + FeatureCropTuning::kFade_px;
  box = {std::max(0, box.x0 - reach), std::max(0, box.y0 - reach),
         std::min(photo.width, box.x1 + reach), std::min(photo.height, box.y1 + reach)};
  ObjectCrop crop{Cut(photo, box), Cut(mask, box), box.x0, box.y0};
  const ImageT<int> distance = DistanceTo(crop.mask, reach + 1);
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < distance.data.size(); ++i)
    if (distance.data[i] > margin_px && distance.data[i] <= reach) {
      sum += crop.image.data[i];
      count += 1;
    }
  const double far = count > 0 ? sum / count : 128;
  for (std::size_t i = 0; i < distance.data.size(); ++i) {
    const double t = std::clamp((distance.data[i] - margin_px - FeatureCropTuning::kKeep_px) /
                                    static_cast<double>(FeatureCropTuning::kFade_px),
                                0.0, 1.0);
    const double share = t * t * (3 - 2 * t);
    crop.image.data[i] = static_cast<std::uint8_t>(
        std::lround(crop.image.data[i] + share * (far - crop.image.data[i])));
    crop.mask.data[i] = distance.data[i] <= margin_px ? 255 : 0;
  }
  return crop;
}

}  // namespace keypose::reconstruct
