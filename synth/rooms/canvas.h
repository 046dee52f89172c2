// Draws the prints of a room: shapes, letters and grain, in metres.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "synth/rooms/print.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {

using Ink = std::array<std::uint8_t, 3>;  ///< sRGB

/// A colour from a hue in turns, and saturation and value in [0,1].
Ink InkOf(double hue, double saturation, double value);
/// `share` of the way from a to b, in [0,1].
Ink Mixed(const Ink& a, const Ink& b, double share);
/// An invented word of two to four syllables, in capitals.
std::string Word(Random& random);

/// Smooth noise on the plane's unit lattice, in about [-1, 1], zero mean: Perlin's, cheaper than in
/// space.
double PlaneNoise(double x, double y, std::uint32_t seed);
/// Sum of `octaves` of it, each with half the wavelength and `gain` times the height of the one
/// before.
double PlaneFractal(double x, double y, int octaves, double gain, std::uint32_t seed);

/// A sheet to draw on. Lengths are metres from the upper left corner, x to the right and y down;
/// angles turn clockwise. Shapes have smooth edges; they may reach beyond the border.
class Canvas {
 public:
  Canvas(double width_m, double height_m, double pixels_per_m, const Ink& ground);

  double width_m() const { return picture_.width / pixels_per_m_; }
  double height_m() const { return picture_.height / pixels_per_m_; }
  void Polygon(const std::vector<Eigen::Vector2d>& corners, const Ink& ink);
  void Bar(const Eigen::Vector2d& center, const Eigen::Vector2d& size, double turn_rad,
           const Ink& ink);
  void Disc(const Eigen::Vector2d& center, double radius, const Ink& ink);
  /// @param from_rad, to_rad  of an arc, from +x clockwise
  void Ring(const Eigen::Vector2d& center, double radius, double width, const Ink& ink,
            double from_rad = 0, double to_rad = 6.283185307179586);
  void Line(const Eigen::Vector2d& a, const Eigen::Vector2d& b, double width, const Ink& ink);
  /// Letters, digits and signs of ASCII around `center`, with capitals of that height.
  void Text(const std::string& text, const Eigen::Vector2d& center, double height, double turn_rad,
            const Ink& ink);
  /// Multiplies each pixel's light by `factor` of its place.
  void Shade(const std::function<double(double x, double y)>& factor);
  /// Replaces each pixel by a mixture with `ink`, of the share in [0,1] that `share` gives.
  void Tint(const Ink& ink, const std::function<double(double x, double y)>& share);
  /// Fine irregular grain: `octaves` of noise from this wavelength down, `strength` of the light.
  void Grain(double wavelength_m, double strength, int octaves, std::uint32_t seed);

  Print Done(bool repeats = false) &&;

 private:
  Image8 picture_;
  double pixels_per_m_;
};

}  // namespace keypose::synth
