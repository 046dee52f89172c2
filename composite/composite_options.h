// Options of keypose-composite.
#pragma once

#include <string>

#include "composite/light/stated_light.h"
#include "core/values/options.h"

namespace keypose::composite {

struct CompositeOptions {
  int samples = 4;
  double shutter = 0;
  double fps = 24;
  std::string format = "film";
  bool follow = false;
  StatedLight light;
  std::string plate_colorspace;
  bool shadow = true, grain = true, video = true, compare = true, blender = true;
  double sound_at = 0;  // s

  void Describe(OptionVisitor& visit) {
    visit("samples", samples, {"rays along each side of a pixel", "", 1, 16, {}});
    visit("shutter", shutter,
          {"motion blur: how long the shutter is open, 360 is a picture's whole time; 0: none, as "
           "filmed frames of stop motion have none",
           "deg",
           0,
           360,
           {}});
    visit("fps", fps, {"of the frames, where their folder does not say", "1/s", 0.1, 1000, {}});
    visit("format", format,
          {.help = "of rendered pictures; film: TIFF beside filmed TIFFs, else PNG; exr is linear "
                   "light without grain, layers premultiplied",
           .unit = "",
           .choices = {"film", "png", "tiff", "exr"}});
    visit("plate_colorspace", plate_colorspace,
          {"what an OpenEXR or DPX plate's values are, such as ACEScg or arri-logc3, or a space of "
           "ocio_config; empty: by the file",
           "",
           0,
           0,
           {}});
    visit("follow", follow,
          {"bend the frames that were filmed until they lie on the film, and in-betweens as the "
           "filmed frames beside them",
           ""});
    visit("shadow", shadow, {"the character's shadow on the table", ""});
    visit(
        "lamp", light.lamp,
        {"where no filmed frame shows the character: share of the light that comes from a lamp; 0: "
         "an even sky",
         "",
         0,
         1,
         {}});
    visit("lamp_from", light.from_deg,
          {"where that lamp stands: 0 on the camera's side, 90 to the right, -90 to the left, 180 "
           "behind",
           "deg",
           -180,
           180,
           {}});
    visit("lamp_height", light.height_deg, {"its height above the table", "deg", 10, 90, {}});
    visit(
        "lamp_size", light.size_deg,
        {"how large it looks from the table; the larger, the softer the shadow", "deg", 1, 90, {}});
    visit("brightness", light.brightness,
          {"of the character over its textures, where no filmed frame shows it", "", 0.1, 10, {}});
    visit("grain", grain, {"the film's grain on rendered pictures", ""});
    visit("video", video, {"write shot.mp4", ""});
    visit("sound_at", sound_at,
          {"when the sound begins in shot.mp4; below 0: so much of its beginning is left out",
           "s",
           -3600,
           3600,
           {}});
    visit(
        "compare", compare,
        {"write compare/: for each located frame filmed, rendered, and four times their difference",
         ""});
    visit("blender", blender, {"write blender/: the shot as a scene", ""});
  }
};

}  // namespace keypose::composite
