#include "core/io/pictures/sight_io.h"

#include <iterator>

#include "core/io/pictures/reduced_image.h"
#include "core/numbers/parallel.h"

namespace keypose {

Sight ReadMaskedViews(const ImageSet& set, const Scene& scene) {
  // Larger masks are made at about this size, and enlarged.
  constexpr int kLonger_px = 2000;
  Sight sight;
  std::vector<int> index;
  for (const View& view : scene.views) {
    const int i = set.Find(view.name);
    if (i < 0 || set.images[i].mask.empty() || !set.images[i].trusted) continue;
    sight.views.push_back(view);
    index.push_back(i);
  }
  sight.masks.resize(index.size());
  ParallelFor(std::ssize(index), [&](std::int64_t k) {
    const CapturedImage& image = set.images[index[k]];
    sight.masks[k] =
        ReadReduced(set.MaskPath(index[k]), 1, EighthsFor(image.width, image.height, kLonger_px));
  });
  return sight;
}

Sight ReadSight(const ImageSet& set, const Scene& scene) {
  Sight sight = ReadMaskedViews(set, scene);
  sight.lines = LinesThroughHoles(sight.views, sight.masks);
  return sight;
}

}  // namespace keypose
