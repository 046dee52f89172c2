// How much renders of the painted mesh differ from the pictures of a camera that did not paint it.
#pragma once

#include <array>

#include "core/values/image.h"

namespace keypose::motion {

/// Sums over the frames of one camera. Compared are pixels that mesh and mask both have. The
/// camera's own exposure and white balance are no fault of the texture: each channel of the renders
/// is scaled by the one factor, over all frames, that brings it nearest to the pictures.
class PictureDifference {
 public:
  /// @param render   RGBA, transparent where the mesh is not
  /// @param picture  RGB of the same size
  /// @param mask     255 where the actor is; empty: wherever the mesh is
  void Add(const Image8& render, const Image8& picture, const Image8& mask);

  /// Peak signal-to-noise ratio [dB] in 8 bit values; 0 when nothing was compared.
  double Psnr() const;

  /// Share of the masks' pixels that the mesh covers; 0 when there are none.
  double Covered() const;

 private:
  struct Channel {
    double rr = 0, rp = 0, pp = 0;  // sums of products of render and picture
  };
  std::array<Channel, 3> channels_;
  double compared_ = 0, masked_ = 0;
};

}  // namespace keypose::motion
