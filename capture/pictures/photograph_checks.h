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

/// Which photographs must be turned by 90 degrees so that those of one camera, held upright or on
/// its side, have one size: the more common way.
std::vector<char> QuarterTurns(const std::vector<Photograph>& photographs);

/// Photographs of one size.
struct SizeGroup {
  int width = 0, height = 0;  ///< turned as QuarterTurns says
  std::vector<std::size_t> photographs;
};

/// All photographs by size, the most common one first.
/// @param turns  of QuarterTurns
std::vector<SizeGroup> GroupedBySize(const std::vector<Photograph>& photographs,
                                     const std::vector<char>& turns);

/// "the photographs have different sizes: 9 are 800 x 600, 3 are 480 x 360: a.jpg, b.jpg, c.jpg";
/// names those of all sizes but the first.
std::string DifferentSizes(const std::vector<Photograph>& photographs,
                           const std::vector<SizeGroup>& groups);

/// Whether a set that may be as small as `min_images` must go all round the figure. Below 8 it need
/// not: another pose's mesh is fitted to it.
bool IsOfAScan(int min_images);

/// @throws InputError  fewer than `min_images`, or two files with the same bytes; names them
void RequireEnoughAndDistinct(const std::vector<Photograph>& photographs, int min_images,
                              const std::string& folder);

/// @throws InputError  photographs that are too small or too narrow to be segmented; names all of
/// them
void RequireUsableSizes(const std::vector<Photograph>& photographs);

/// The largest deviation of a known focal length from the median of its size, over that median; 0
/// when no size has two that are known.
double FocalSpread(const std::vector<Photograph>& photographs,
                   const std::vector<SizeGroup>& groups);
/// The median of the known focal lengths of a size; 0 when there are none.
double MedianFocalPx(const std::vector<Photograph>& photographs, const SizeGroup& group);

/// "a.jpg, b.jpg, c.jpg and 4 more".
std::string JoinNames(const std::vector<std::string>& names, std::size_t at_most = 12);

}  // namespace keypose::capture
