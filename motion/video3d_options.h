// Options of keypose-video3d.
#pragma once

#include <string>
#include <vector>

#include "core/values/options.h"

namespace keypose::motion {

struct Video3dOptions {
  int texture_size = 0;
  std::string pictures = "png", cameras, up = "auto", view = "orbit";
  bool level_exposure = true, agreement = true, shadow = true;
  double erosion_px = 2, smoothing = 0.2, turns = 1;
  int fill_frames = 8, gutter = 12, view_width = 960, view_height = 720;

  void Describe(OptionVisitor& visit) {
    visit("texture_size", texture_size,
          {"width and height of the textures; 0: about one texel per pixel of the films, a power "
           "of two up to 2048",
           "px",
           0,
           8192,
           {}});
    visit("pictures", pictures,
          {.help = "format of the textures", .unit = "", .choices = {"png", "jpg"}});
    visit("cameras", cameras,
          {.help = "names of the cameras that are used, comma-separated; empty: all. The others "
                   "are only compared with the result"});
    visit("level_exposure", level_exposure,
          {.help = "one gain per camera and channel, so that exposure and white balance agree"});
    visit("agreement", agreement,
          {.help = "a camera that contradicts the others at a place has less weight there"});
    visit("erosion_px", erosion_px,
          {"width of the unused band in the films along the edges of mesh, masks and depth",
           "px",
           0,
           100,
           {}});
    visit("smoothing", smoothing,
          {"share of the frame before in the weights of a frame", "", 0, 0.95, {}});
    visit(
        "fill_frames", fill_frames,
        {"frames before and after from which hidden places are filled first", "frames", 0, 60, {}});
    visit("gutter", gutter,
          {"width by which colours continue around each chart", "px", 0, 256, {}});
    visit("view", view,
          {.help = "of the film: orbit: round the actor; else the name of a camera of the "
                   "calibration. `camera_path` goes before both"});
    visit("turns", turns, {"of an orbit, over the whole film", "", -100, 100, {}});
    visit("view_width", view_width, {"of the film; even", "px", 64, 7680, {}});
    visit("view_height", view_height, {"of the film; even", "px", 64, 4320, {}});
    visit("shadow", shadow, {.help = "the film has a soft shadow on the floor"});
    visit(
        "up", up,
        {.help = "the calibration's axis that points up; auto: the one that is up in the pictures",
         .unit = "",
         .choices = {"auto", "x", "y", "z", "-x", "-y", "-z"}});
  }
  std::vector<std::string> Problems() const {
    if (view_width % 2 == 0 && view_height % 2 == 0) return {};
    return {"view_width and view_height must be even: a film's colours have half its resolution"};
  }
};

}  // namespace keypose::motion
