// Photographs of a generated room, with exact cameras and masks.
#pragma once

#include <memory>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "synth/rooms/room_plan.h"
#include "synth/rooms/room_set.h"
#include "synth/rooms/room_views.h"

namespace keypose::synth {

struct RoomPhotograph {
  Image8 image;  ///< sRGB
  Image8 mask;   ///< 255 where the figure is seen on at least half of the pixel
  Image8 parts;  ///< values of Part: what is seen at the pixel's middle
};

/// Takes photographs one by one. Take is const and thread-safe. From one tripod, all that stands
/// still has the same light in each photograph, before the sensor's noise, but for the shadow on
/// the table.
class RoomPhotographer {
 public:
  explicit RoomPhotographer(const RoomPlan& plan);
  ~RoomPhotographer();
  RoomPhotographer(RoomPhotographer&&) noexcept;

  const RoomPlan& plan() const;
  const RoomSet& set() const;
  const std::vector<RoomView>& room_views() const;
  /// Whether a hand reaches into the i-th photograph.
  bool HasHand(int i) const;
  /// A pure function of plan and i: same bits for any thread count.
  RoomPhotograph Take(int i) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::synth
