// A generated room with a clay figure: what stands still, and what moves with the figure.
#pragma once

#include <memory>
#include <vector>

#include "synth/photographs/light.h"
#include "synth/rooms/furniture.h"
#include "synth/rooms/room_plan.h"
#include "synth/worlds/posed_clay.h"

namespace keypose::synth {

/// A piece of clay in the figure's frame.
struct ClayThing {
  ClayThing(const World& world, const PointsX3& points, Part the_part)
      : clay(world, points, points), part(the_part) {}
  PosedClay clay;
  Part part;
  std::unique_ptr<LightField> light;
};

/// Two frames: the room's, and the figure's, which turns about z with the mat. The figure stands on
/// z = 0 at the origin of both.
struct RoomSet {
  Furniture room;   ///< in the room's frame
  Furniture close;  ///< in the figure's frame: mat, book, things on the table; may be empty
  std::vector<std::unique_ptr<ClayThing>> clay;  ///< in the figure's frame; the figure is the first
  double table_z = 0;                            ///< [m] of the table's top
  double second_gap_m = -1;         ///< from the figure to the second thing; below 0: there is none
  PointsX3 second;                  ///< of the second thing's surface, in the figure's frame
  World world;                      ///< of the figure
  std::unique_ptr<RayScene> casts;  ///< what casts shadows on mat and table near the figure
  std::unique_ptr<TableLight> table;  ///< light on z = 0 that `casts` leaves

  const PosedClay& figure() const { return clay.front()->clay; }
};

/// @throws UsageError  an unknown pose
RoomSet BuildRoom(const RoomPlan& plan);

}  // namespace keypose::synth
