// Splits a connected surface where a person said that a part of it is another thing.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::capture {

/// Points of a surface with their colours, and which lie beside each other.
struct ColouredSurface {
  std::vector<Eigen::Vector3f> colours;      ///< RGB, 0 to 255
  std::vector<std::vector<int>> neighbours;  ///< by point, symmetric
  /// by point, how its distance from the other thing's marks speaks for that thing: 1, to -1 for
  /// the figure; empty: not at all
  std::vector<float> lean = {};
};

/// Which points belong to another thing. What is much nearer to one kind of marks than to the
/// other, on ways over the surface that avoid steps between colours, belongs to it; between, the
/// surface is cut where it is narrow and its colour changes.
/// @param figure, other  marked points, one of each at least
/// @return 1 for the points of `other`
/// Same bits for any thread count.
/// Source: Bai & Sapiro, "A geodesic framework for fast interactive image and video segmentation",
/// ICCV 2007, for what is near; Boykov & Jolly, ICCV 2001, for the cut; both over a surface.
std::vector<char> OtherPart(const ColouredSurface& surface, const std::vector<int>& figure,
                            const std::vector<int>& other);

/// What the border between two parts costs, over the square root of the smaller part's points, as
/// borders of parts of one shape go: less where it is narrow and colours change across it. Infinite
/// where one part is empty.
double BorderOf(const ColouredSurface& surface, const std::vector<char>& is_other);

}  // namespace keypose::capture
