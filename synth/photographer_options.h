// How turntable photographs of a synthetic world are taken: cameras, light, lens, mishaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synth/calibration_board.h"
#include "synth/mishaps.h"

namespace keypose::synth {

struct PhotographerOptions {
  int views = 32;                                 ///< in all, spread evenly over the rings
  std::vector<double> elevations_deg = {12, 40};  ///< one ring each
  int width = 1024, height = 768;
  double focal_35mm = 60;  ///< 35 mm equivalent
  double k1 = -0.06, k2 = 0.02, p1 = 0.0003, p2 = -0.0002;
  double principal_shift_px = 3;  ///< of the principal point off the centre, to the right and down
  double fill = 0.8;              ///< share of the image's height that the character takes
  double azimuth_jitter_deg = 1.0;    ///< the turntable is turned by hand
  double aim_jitter = 0.004;          ///< of the camera between rings, times distance
  std::string background = "studio";  ///< studio (structured, static in the camera's frame) | plain
  bool shadows = true;
  double table_shadow = 0.25;  ///< darkness of the shadow on the table: 1 is one lamp in a dark
                               ///< room, 0.25 a light tent
  double ambient = 0.42, lamp = 0.75;  ///< light on white clay, linear
  double lamp_aside_rad = -0.85;   ///< of the lamp from the camera, about z: it stands to the left
  double lamp_elevation_deg = 52;  ///< of the lamp above the table
  double gloss = 0.035;            ///< height of the wet highlight, linear
  double noise = 1;                ///< sensor noise, times that of an ordinary camera
  double blur_px = 0.55;           ///< standard deviation of the lens blur
  double vignetting = 0.12;        ///< light lost in the corners
  int supersampling = 2;           ///< rays per pixel along each axis
  std::uint64_t seed = 1;
  BoardOptions board;
  Mishaps mishaps;  ///< Take() knows of moves on the table, of hands and of lamps; what shows
                    ///< another figure takes another Photographer
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

}  // namespace keypose::synth
