// A figure and small photographs of it.
#pragma once

#include "synth/photographs/photographer_options.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

inline const World& Creature() {
  static const World world = [] {
    WorldOptions options;
    options.spacing_m = 0.005;
    return MakeWorld(options);
  }();
  return world;
}

inline PhotographerOptions Small(int views = 4) {
  PhotographerOptions options;
  options.views = views;
  options.elevations_deg = {15, 35};
  options.width = 240;
  options.height = 180;
  return options;
}

}  // namespace keypose::synth
