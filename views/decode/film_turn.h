// How a film lies in its file, by the display matrix that phones and cameras write.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace keypose {

/// A display matrix as ISO/IEC 14496-12 has it, row by row: a pixel (x, y) is shown at
/// (a x + c y, b x + d y) with a, b, c, d = matrix[0, 1, 3, 4] / 65536, but for a shift.
using DisplayMatrix = std::array<std::int32_t, 9>;

/// The EXIF orientation (see Oriented) that makes the pictures upright: 1 to 8; nothing where the
/// matrix turns by no multiple of 90 degrees, or shears.
std::optional<int> OrientationOf(const DisplayMatrix& matrix);

/// By how much the matrix turns, clockwise [deg], for words to people.
double TurnOf(const DisplayMatrix& matrix);

}  // namespace keypose
