// What of the figure is hidden behind other things: there a photograph tells nothing of it.
#pragma once

#include <vector>

#include "capture/room/standing_figure.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct HiddenPart {
  Image8 where;      ///< at reduced size: 255 where another thing is nearer than the figure
  double share = 0;  ///< of the figure's surface as the camera would see it
};

/// By view. Same bits for any thread count.
std::vector<HiddenPart> HiddenParts(const std::vector<View>& views, const StandingFigure& figure);

}  // namespace keypose::capture
