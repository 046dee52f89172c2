// Corners and edges of the set that are followed from picture to picture of a moving camera.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::composite {

struct SetPicture {
  const Image8* picture = nullptr;  ///< RGB or grey
  /// Same size, > 127 where the character is; null or empty: the set alone.
  const Image8* figure = nullptr;
};

/// One place of the set in one picture.
struct SetSighting {
  int picture = 0;
  Eigen::Vector2d pixel;  ///< centres at .5
  /// How well it is known: the inverse of its covariance [1/px^2]. On an edge it is known across
  /// only, and may have slid along.
  Eigen::Matrix2d information = Eigen::Matrix2d::Identity();
};
/// The same place, or edge, in consecutive pictures, ascending.
using SetTrack = std::vector<SetSighting>;

/// Corners and edges in all parts of the picture, followed until they are lost, each there and back
/// again.
///
/// @param pictures  of one size, in the order of time, in one light
/// @return tracks of two pictures or more
/// Same bits for any thread count.
/// Sources: Shi, Tomasi, CVPR 1994; Bouguet's pyramidal Lucas and Kanade (OpenCV).
std::vector<SetTrack> FindSetTracks(const std::vector<SetPicture>& pictures,
                                    Progress* progress = nullptr);

}  // namespace keypose::composite
