// Groups of photographs that are connected by matches, and whether a set falls into groups that
// cannot be joined.
#pragma once

#include <vector>

namespace keypose {

/// Two photographs that show some of the same places.
struct ImageTie {
  int first = 0, second = 0;
  int matches = 0;  ///< that fit one rigid scene
};

/// The groups of images that ties connect, directly or through other images. The largest group
/// comes first; images are in ascending order within a group.
std::vector<std::vector<int>> JoinedImages(int images, const std::vector<ImageTie>& ties);

/// Whether the photographs were taken from viewpoints too far apart to be joined: some sides were
/// photographed many times, and nothing between them. That is so when at least 70 % of them have a
/// strong tie to another one, so texture and focus are good enough, but there are four groups or
/// more, each of fewer than eight photographs and at most a third of the set. Two other cases
/// differ from this: separate rings form larger groups, and figures with few features have few
/// strong ties. Sets of fewer than twenty photographs give false, because trying them costs little.
/// @param strong_matches  the number of matches from which a tie is strong
bool FallsApart(int images, const std::vector<ImageTie>& ties, int strong_matches);

}  // namespace keypose
