// A page with a player of a turning ball.
#pragma once

#include <gmock/gmock.h>

#include <string>

#include "core/surfaces/shapes.h"
#include "core/values/image.h"
#include "report/page/page.h"
#include "report/player/player_data.h"

namespace keypose::report {

inline std::string Pixel(const Image8&) {
  return "data:image/"
         "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAYAAAAfFcSJAAAADUlEQVR42mNk+"
         "M9QDwADhgGAWjR9awAAAABJRU5ErkJggg==";
}

inline PlayerData Ball() {
  PlayerData data;
  data.mesh = MakeIcosphere(3);
  data.frames = {data.mesh.points, 1.5 * data.mesh.points};
  data.moments = {{0, 0, 0, {1, 0}}, {0, 1, 0.5, {0.5, 0.5}}, {1, 1, 0, {0, 1}}};
  data.keys = {0, 1};
  data.textures = {Image8(1, 1, 3), Image8(1, 1, 3)};
  return data;
}

inline std::string PageWithPlayer() {
  Contents contents;
  contents.run.project = "ball";
  contents.run.poses = {"rest", "up"};
  contents.player = PlayerPart{
      PlayerJson(Ball(), Pixel), 3, 2, 2, 2, true, Picture{"poster", Image8(4, 4, 3, 200)}};
  return BuildPage(contents, Pixel);
}

}  // namespace keypose::report
