// Flat pictures of a known size, seen from near and far: cloth, wood, book covers, printed mats.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/values/image.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {

/// What a print is drawn by: random numbers, and how finely.
struct PrintRandom : Random {
  PrintRandom(std::uint64_t seed, double the_detail) : Random(seed), detail(the_detail) {}
  double Fine(double pixels_per_m) const { return detail * pixels_per_m; }
  double detail;  ///< 1: for photographs of 1 to 2 megapixels
};

/// A picture in metres, with smaller copies so that it does not flicker where it is far away.
class Print {
 public:
  /// @param picture    sRGB, 3 channels, not empty
  /// @param width_m    of the whole picture; pixels are square
  /// @param repeats    continues beyond its border; otherwise the border's colour does
  Print(Image8 picture, double width_m, bool repeats = false);

  double width_m() const { return width_m_; }
  double height_m() const { return height_m_; }
  /// Linear RGB around a point, blurred to about `footprint_m`.
  /// @param x  [m] to the right from the left border @param y  [m] down from the upper border
  Eigen::Vector3d At(double x, double y, double footprint_m) const;

 private:
  Eigen::Vector3d AtLevel(const Image8& level, double x, double y) const;

  std::vector<Image8> levels_;  // each has half the size of the one before
  double width_m_, height_m_, texel_m_;
  bool repeats_;
};

}  // namespace keypose::synth
