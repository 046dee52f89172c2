// One picture of a shot: the character over the clean plate.
#pragma once

#include "composite/composing/lessons.h"

namespace keypose::composite {

struct ComposeOptions {
  int along = 4;           ///< rays along each side of a pixel
  double shutter_deg = 0;  ///< 0: no motion blur; 180: half of a picture's time
  bool shadow = true, grain = true;
};

struct ComposedPicture {
  ImageF light;     ///< RGB, linear, with exposure; without grain but of a scene-linear film
  ImageF picture;   ///< RGB, stored levels of 255 (sRGB), with grain, not rounded; of a
                    ///< scene-linear film to look at
  ImageF alpha;     ///< 1 channel, 0 to 1: of the picture, where the film was keyed; else empty
  ImageF layer;     ///< RGBA, linear, premultiplied: the character and its shadow (black) alone
  ImageF coverage;  ///< 1 channel: of the character, after props
  MovingPlate moving_plate;  ///< of a moving camera: the plate that was used
  ImageF shadow;  ///< 1 channel, of a scene-linear film, else empty: the share of light it takes
  ImageF depth;   ///< 1 channel, likewise: of the character, as DepthLayer has it
};

/// @param time      in frames of the animation
/// @param exposure  factors on the plate's light
/// @param grain_seed  the same gives the same grain
/// Same bits for any thread count.
ComposedPicture Compose(const ShotGeometry& geometry, const Looks& looks, const Film& film,
                        const FilmLessons& lessons, double time, const Eigen::Vector3d& exposure,
                        const ComposeOptions& options, std::uint64_t grain_seed);

}  // namespace keypose::composite
