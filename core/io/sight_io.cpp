#include "core/io/sight_io.h"

#include "core/io/image_io.h"

namespace keypose {

Sight ReadSight(const ImageSet& set, const Scene& scene) {
  Sight sight;
  for (const View& view : scene.views) {
    const int i = set.Find(view.name);
    if (i < 0 || set.images[i].mask.empty() || !set.images[i].trusted) continue;
    sight.views.push_back(view);
    sight.masks.push_back(ReadImage(set.MaskPath(i), 1));
  }
  sight.lines = LinesThroughHoles(sight.views, sight.masks);
  return sight;
}

}  // namespace keypose
