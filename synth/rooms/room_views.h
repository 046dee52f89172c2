// Where the camera stands for each photograph of a room, and how the mat is turned.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "synth/rooms/room_plan.h"

namespace keypose::synth {

struct RoomView {
  View view;            ///< in the room's frame: the figure stands at the origin, z up [m]
  double turn_rad = 0;  ///< of the figure and all that moves with it, about z
  int tripod = -1;      ///< photographs of one number are from one place; -1: by hand
  int lens = 0;
  std::string part = "ring";  ///< ring | close | walk
  double gain = 1;            ///< of the exposure

  /// The same view in the frame that turns with the figure.
  View OfFigure() const;
};

/// @param figure  points of its surface in its own frame
/// @return named IMG_0001.jpg, ... in the order in which they were taken
std::vector<RoomView> PlaceRoomViews(const RoomPlan& plan, const PointsX3& figure);

/// The camera of a picture that is turned by a quarter, clockwise.
Camera TurnedClockwise(const Camera& camera);

}  // namespace keypose::synth
