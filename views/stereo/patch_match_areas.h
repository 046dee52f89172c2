// The areas of neighbours from which a pixel takes plane candidates; they have the other colour of
// the checkerboard.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace keypose::stereo {

struct Offset {
  int dx, dy;
};

/// Pixels of the other colour, upwards; rotations give the other directions.
inline constexpr std::array<Offset, 7> kNear = {
    {{0, -1}, {-1, -2}, {1, -2}, {-2, -3}, {2, -3}, {-3, -4}, {3, -4}}};
inline constexpr std::array<Offset, 11> kFar = {{{0, -3},
                                                 {0, -5},
                                                 {0, -7},
                                                 {0, -9},
                                                 {0, -11},
                                                 {0, -13},
                                                 {0, -15},
                                                 {0, -17},
                                                 {0, -19},
                                                 {0, -21},
                                                 {0, -23}}};

constexpr int kNearReach = 4, kFarReach = 23;

/// An area in a view of a given width: offsets, and the same as distances in memory.
struct Area {
  std::vector<Offset> offsets;
  std::vector<std::ptrdiff_t> steps;
};

/// @param up       an area
/// @param quarter  number of rotations by 90 degrees, 0 to 3
/// @param width    pixels of the view's rows
template <std::size_t n>
Area Turned(const std::array<Offset, n>& up, int quarter, int width) {
  Area area;
  for (Offset o : up) {
    for (int i = 0; i < quarter; ++i) o = {-o.dy, o.dx};
    area.offsets.push_back(o);
    area.steps.push_back(static_cast<std::ptrdiff_t>(o.dy) * width + o.dx);
  }
  return area;
}

}  // namespace keypose::stereo
