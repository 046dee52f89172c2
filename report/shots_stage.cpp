#include "report/shots_stage.h"

#include <algorithm>
#include <cmath>

#include "core/io/image_io.h"

namespace keypose::report {

Shot Shrunk(const Shot& shot, double factor) {
  if (factor >= 1) return shot;
  Shot small = shot;
  small.view.camera = shot.view.camera.Scaled(factor);
  small.view.camera.width =
      std::max(1, static_cast<int>(std::lround(shot.photograph.width * factor)));
  small.view.camera.height =
      std::max(1, static_cast<int>(std::lround(shot.photograph.height * factor)));
  small.photograph = Resized(shot.photograph, small.view.camera.width, small.view.camera.height);
  small.mask = Resized(shot.mask, small.view.camera.width, small.view.camera.height);
  return small;
}

}  // namespace keypose::report
