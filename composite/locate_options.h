// Options of keypose-locate.
#pragma once

#include <string>

#include "core/values/options.h"

namespace keypose::composite {

struct LocateStageOptions {
  double focal_35mm = 0;
  bool distortion = true;
  std::string camera = "still";
  std::string shows, poses, plate_colorspace;
  double fps = 0;
  int max_size = 1920;
  double min_iou = 0.8;
  bool quick = false;

  void Describe(OptionVisitor& visit) {
    visit("focal_35mm", focal_35mm,
          {"35 mm equivalent focal length; 0: from EXIF, else solved where the pictures show it",
           "mm",
           0,
           2000,
           {}});
    visit("distortion", distortion, {.help = "also solve the lens distortion k1"});
    visit(
        "camera", camera,
        {"still: the camera stands on a tripod, and frames may share one place; moving: each frame "
         "has a camera of its own, and those between the shown ones are located too, by the "
         "animation",
         "",
         0,
         0,
         {"still", "moving"}});
    visit("shows", shows,
          {"which pictures show which pose, such as 0=rest,4=wave: frame number and a name of "
           "--poses, or the number of a mesh from 0; other pictures are left out; empty: all "
           "pictures, one mesh each or evenly spread",
           "",
           0,
           0,
           {}});
    visit("poses", poses,
          {"names of the meshes, in order, such as rest,wave; of an animation those of its keys",
           "",
           0,
           0,
           {}});
    visit("fps", fps,
          {"pictures a second of the film; 0: those of a video, else 12", "1/s", 0, 1000, {}});
    visit(
        "plate_colorspace", plate_colorspace,
        {"what an OpenEXR or DPX picture's values are, such as ACEScg or arri-logc3, or a space of "
         "ocio_config; empty: by the file",
         "",
         0,
         0,
         {}});
    visit("max_size", max_size,
          {"pictures are scaled down to this longer side", "px", 240, 16384, {}});
    visit("min_iou", min_iou,
          {"a frame in which the mesh overlaps with the matte by less than this does not show the "
           "character (intersection over union)",
           "",
           0,
           1,
           {}});
    visit("quick", quick,
          {.help = "only by the clicks, of which each frame needs four, and roughly by a matte: an "
                   "answer at once, to be looked at before the whole work"});
  }
};

}  // namespace keypose::composite
