// What is measured of a photograph as it lands, and what is wrong with a set of them.
#pragma once

#include <filesystem>

#include "capture/shoot/record/side_file.h"
#include "core/values/image.h"

namespace keypose::capture::shoot {

/// A photograph of the figure, measured by itself: a function of its pixels alone.
struct Measured {
  int width = 0, height = 0;
  double crispness = 0, sharpness = 0, exposure = 0, light = 0, clipped = 0, mask_fraction = 0;
  bool touches_border = false;
};
/// @param image  RGB
/// Same bits for any thread count.
Measured MeasurePhotograph(const Image8& image);

/// How far things moved between two photographs of one angle [px of the photograph]: the 90 %
/// largest of the displacements of the figure's corners, so that one sunk arm counts. If the figure
/// has hardly any corners, the shift of the whole picture.
/// @param before, after  RGB, same size
/// @throws InputError  different sizes
double MovedBetween(const Image8& before, const Image8& after);

/// Sets the findings of all photographs and rings from their numbers. A function of what is there,
/// not of the order in which it came.
void JudgeAll(SideFile* side);

}  // namespace keypose::capture::shoot
