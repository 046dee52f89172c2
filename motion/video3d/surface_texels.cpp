#include "motion/video3d/surface_texels.h"

namespace keypose::motion {

SurfaceTexels ListTexels(const Atlas& atlas) {
  SurfaceTexels list;
  for (std::size_t i = 0; i < atlas.face.size(); ++i) {
    if (atlas.face[i] < 0) continue;
    list.texel.push_back(static_cast<int>(i));
    list.face.push_back(atlas.face[i]);
    list.weights.push_back(atlas.Weights(i));
  }
  return list;
}

}  // namespace keypose::motion
