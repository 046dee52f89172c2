// Options of keypose-report.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::report {

struct ReportOptions {
  int picture_width = 360;
  int film_frames = 10;
  int mask_tiles = 48;
  double color_scale_top = 0;
  int compared_px = 640;
  std::string up = "z";

  void Describe(OptionVisitor& visit) {
    visit("picture_width", picture_width, {"width of a rendered picture", "px", 64, 2048});
    visit("color_scale_top", color_scale_top,
          {"distance at the end of the colour scale, as a share of the diagonal; 0: the 99 % "
           "quantile",
           "", 0, 1});
    visit("compared_px", compared_px,
          {"longer side of the photographs when they are compared with the mesh", "px", 64, 8192});
    visit("up", up, {"axis that points upwards in the pictures", "", 0, 0, {"x", "y", "z"}});
  }
};

}  // namespace keypose::report
