// Which photographs of a set matches join, and whether the set falls into pieces that nothing can
// put together.
#pragma once

#include <vector>

namespace keypose {

/// Two photographs that show some of the same places.
struct ImageTie {
  int first = 0, second = 0;
  int matches = 0;  ///< that fit one rigid scene
};

/// Images that ties join, directly or through others; the largest group first, each in the images'
/// order.
std::vector<std::vector<int>> JoinedImages(int images, const std::vector<ImageTie>& ties);

/// Whether photographs were shot so far apart that they cannot be joined. Most of them match
/// another one very well, so texture and focus are good enough, and yet they fall into four groups
/// or more, each of fewer than eight photographs and of a third of the set at most: some sides shot
/// many times, and nothing between them. Rings that do not touch each other are larger and stay
/// together; a figure that shows few features has few strong ties. Sets of fewer than twenty
/// photographs are not judged: to try them costs little.
/// @param strong_matches  from here on a tie is a strong one
bool FallsApart(int images, const std::vector<ImageTie>& ties, int strong_matches);

}  // namespace keypose
