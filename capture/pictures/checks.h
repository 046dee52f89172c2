// Checks of a set of photographs before any work is done on it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace keypose::capture {

/// Data from the header of a photograph.
struct Photograph {
  std::string name;   ///< file name; with its subfolder's name and _ before it if there is one
  std::string group;  ///< placement of the figure: the subfolder, or "lying" and "upright"; "" for
                      ///< a single placement
  int width = 0, height = 0;  ///< after EXIF orientation
  std::uint64_t digest = 0;   ///< of the file's bytes
  std::uint64_t bytes = 0;
  double focal_px = 0;  ///< 0 when unknown
  std::string camera_model;
};

/// Which photographs must be turned by 90 degrees so that all have one size; empty if none.
/// @throws InputError  two sizes that differ by more than a turn; names photographs of each
std::vector<char> QuarterTurns(const std::vector<Photograph>& photographs);

/// Whether a set that may be as small as `min_images` must go all round the figure. Below 8 it need
/// not: another pose's mesh is fitted to it.
bool IsOfAScan(int min_images);

/// @throws InputError  fewer than `min_images`, or two files with the same bytes; names them
void RequireEnoughAndDistinct(const std::vector<Photograph>& photographs, int min_images,
                              const std::string& folder);

/// @throws InputError  photographs that are too small or too narrow to be segmented; names all of
/// them
void RequireUsableSizes(const std::vector<Photograph>& photographs);

/// The largest deviation of a known focal length from their median, over that median; 0 when fewer
/// than two are known.
double FocalSpread(const std::vector<Photograph>& photographs);
double MedianFocalPx(const std::vector<Photograph>& photographs);

/// "a.jpg, b.jpg, c.jpg and 4 more".
std::string JoinNames(const std::vector<std::string>& names, std::size_t at_most = 12);

}  // namespace keypose::capture
