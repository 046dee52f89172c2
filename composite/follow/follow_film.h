// Bends the character in the picture's plane until its render lies on a filmed frame.
//
// An animation passes beside what was filmed: a limb was turned otherwise, a head swings on another
// way. Filmed frames between the keys show where the character truly was. Each vertex gets a shift
// in the plane of the picture: Gauss-Newton on the grey levels (as Lucas & Kanade, IJCAI 1981, with
// the mesh instead of windows), coarse to fine, with neighbours held together by a membrane.
#pragma once

#include "composite/layer/character_layer.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// What is compared.
struct FollowedFrame {
  const ImageF& filmed;   ///< RGB, linear light, in the exposure of `behind`
  const ImageF& behind;   ///< RGB, linear light: what is seen beside the character
  const Image8& holdout;  ///< 1 channel: > 0 where a prop stands before it; empty: nowhere
  const Character& character;
  const PointsX3& gains;  ///< of the vertices
  const View& view;
  const PixelRays& rays;
  const Ground* table;              ///< hides what is below it; may be null
  double blur_px;                   ///< of the lens
  const RayScene* props = nullptr;  ///< of the set, which hide it too
};

struct Followed {
  PointsX3 shifts;                  ///< V x 3, in world, along the picture's plane
  double mean_px = 0, most_px = 0;  ///< over the vertices that are seen
  double before = 0, after = 0;     ///< root mean square difference on the character [levels]
};

/// @param points  V x 3, in world, less than some five pixels beside what was filmed
/// Without a visible pixel, all shifts are 0. Same bits for any thread count.
Followed FollowFilm(const FollowedFrame& frame, const PointsX3& points);

}  // namespace keypose::composite
