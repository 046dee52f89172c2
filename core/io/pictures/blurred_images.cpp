#include "core/io/pictures/blurred_images.h"

#include <utility>
#include <vector>

#include "core/numbers/statistics.h"

namespace keypose {

std::set<std::string> BlurredImages(const ImageSet& set) {
  std::vector<double> known;
  for (const CapturedImage& image : set.images)
    if (image.crispness > 0) known.push_back(image.crispness);
  std::set<std::string> blurred;
  if (known.empty()) return blurred;
  const double least = kBlurredOfMedian * UpperMedian(std::move(known));
  for (const CapturedImage& image : set.images)
    if (image.crispness > 0 && image.crispness < least) blurred.insert(image.name);
  return blurred;
}

}  // namespace keypose
