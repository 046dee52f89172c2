// Which photographs are shown to the network, and what it says of them.
#pragma once

#include <functional>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

/// What of a picture is its one salient object, 0..255, of the picture's size.
/// @param mirrored  the picture's shorter side is continued by its mirror image, for close-ups
using Salience = std::function<Image8(const Image8& rgb, bool mirrored)>;

/// Views from sides as different as possible that look at the middle from not too near, so that
/// they show the figure whole.
/// @param middle  a point on or near the figure
/// @param first   views that must be among them, and come first
/// @return at most `count` indices
std::vector<int> ViewsToAsk(const std::vector<View>& views, const Eigen::Vector3d& middle,
                            int count, const std::vector<int>& first = {});

/// Quarter turns, clockwise, that put a view upright, by the world's z.
int TurnsToUpright(const View& view, const Eigen::Vector3d& middle);

/// The network's opinion of a picture, asked with it turned upright; again mirrored where it sees
/// next to nothing.
/// @param turns  quarter turns, clockwise, that put the picture upright
Image8 AskUpright(const Salience& salience, const Image8& rgb, int turns);

}  // namespace keypose::capture
