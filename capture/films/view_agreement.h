// What the other cameras' masks say of each pixel of a camera, once the cameras are calibrated.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

inline constexpr std::uint8_t kMostDenials = 3;

class ViewAgreement {
 public:
  /// Fills the space in which the masks of all frames can meet with places.
  /// @param views   three cameras or more, for pictures of the masks' size
  /// @param unions  for each camera 255 where any frame's mask is
  ViewAgreement(const std::vector<View>& views, const std::vector<Image8>& unions);

  /// Whether the masks meet anywhere; if not, the calibration is of other cameras.
  bool meets() const { return places_ > 0; }

  /// For each camera and pixel the least number of other cameras that deny the figure's presence,
  /// over all places along the pixel's ray, up to kMostDenials. A camera denies a place that it
  /// sees outside of its mask by more than a few pixels.
  /// @param masks  of one moment, one for each camera
  std::vector<Image8> LeastDenials(const std::vector<Image8>& masks) const;

 private:
  std::vector<View> views_;            // for masks of half the size
  std::vector<int> widths_, heights_;  // of the masks
  std::size_t places_ = 0;
  std::vector<std::vector<std::int32_t>> pixels_;  // for each camera the pixel of each place; -1
  std::vector<std::vector<std::uint8_t>> reach_;   // for each camera half a place's width [px]
};

/// What each number of denials says: ln p(number | actor) / p(number | set), as a camera's own
/// masks have it, within +-limit. One denial says hardly anything against the actor: a camera alone
/// may have lost a limb.
/// @param masks, denials  of one camera, frame by frame, of one size
/// @param area            255 where the actor may be
std::vector<float> OddsOfDenials(const std::vector<Image8>& masks,
                                 const std::vector<Image8>& denials, const Image8& area,
                                 double limit);

}  // namespace keypose::capture
