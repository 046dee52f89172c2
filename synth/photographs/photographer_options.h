// Options of turntable photographs of a synthetic world: cameras, light, lens, mishaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "synth/photographs/board_picture.h"
#include "synth/photographs/mishaps.h"

namespace keypose::synth {

struct PhotographerOptions {
  int views = 32;                                 ///< in total, spread evenly over the rings
  std::vector<double> elevations_deg = {12, 40};  ///< one ring per elevation
  int width = 1024, height = 768;
  double focal_35mm = 60;  ///< 35 mm equivalent
  double k1 = -0.06, k2 = 0.02, p1 = 0.0003, p2 = -0.0002;
  /// shift of the principal point from the centre, to the right and down
  double principal_shift_px = 3;
  double fill = 0.8;                  ///< share of the image's height that the character fills
  double azimuth_jitter_deg = 1.0;    ///< simulates turning by hand
  double aim_jitter = 0.004;          ///< of the camera between rings, as a share of its distance
  std::string background = "studio";  ///< studio (structured, static in the camera's frame) | plain
  bool shadows = true;
  /// darkness of the shadow on the table; 1: one lamp in a dark room, 0.25: a light tent
  double table_shadow = 0.25;
  double ambient = 0.42, lamp = 0.75;  ///< light on white clay, linear
  /// azimuth of the lamp relative to the camera, about z; negative: to the left
  double lamp_aside_rad = -0.85;
  double lamp_elevation_deg = 52;  ///< elevation of the lamp above the table
  double gloss = 0.035;            ///< strength of the specular highlight, linear
  double noise = 1;                ///< sensor noise, as a factor on an ordinary camera's
  double blur_px = 0.55;           ///< standard deviation of the lens blur
  double vignetting = 0.12;        ///< share of light lost in the corners
  int supersampling = 2;           ///< rays per pixel along each axis
  /// drawn so many times smaller, then enlarged before noise: large photographs in little time, as
  /// soft as a telephone's
  int enlarge = 1;
  std::uint64_t seed = 1;
  BoardOptions board;
  /// Take() applies moves, hands and lamps; photographs of another figure or pose need another
  /// Photographer
  Mishaps mishaps;
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

}  // namespace keypose::synth
