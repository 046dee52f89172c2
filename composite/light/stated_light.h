// A light that a person states, for a shot in which no filmed frame shows the character.
#pragma once

#include "composite/layer/table_shadow.h"
#include "composite/light/shot_light.h"
#include "core/values/camera.h"

namespace keypose::composite {

/// An even sky and one lamp, as seen by the camera.
struct StatedLight {
  double lamp = 0;         ///< share of the light that comes from the lamp, 0 to 1
  double from_deg = -45;   ///< 0: from the camera's side, 90: from the right, 180: from behind
  double height_deg = 50;  ///< above the table
  double size_deg = 15;    ///< of its disk, across
  double brightness = 1;   ///< of the character over its textures
  bool operator==(const StatedLight&) const = default;
};

/// Towards the lamp, unit.
/// @param up  the table's, unit
Eigen::Vector3d LampOf(const StatedLight& light, const View& view, const Eigen::Vector3d& up);

/// Textures hold the light of an even sky; what is plain gets more of it from above, and from below
/// the fifth that the table gives back. The lamp's share l makes a face that is turned to it 1 + l
/// times as bright and one that is turned away 1 - l times, of degree 2 as ShotLight is:
/// brightness * ((1 - l) * sky + 2 l max(0, n . lamp)).
ShotLight LightOf(const StatedLight& light, bool plain, const View& view,
                  const Eigen::Vector3d& up);

/// What the character takes of the table's light under the same sky and lamp. The set's own light
/// that falls back into the shadow is a fifth of the sky's.
ShadowStrength ShadowOf(const StatedLight& light, const View& view, const Eigen::Vector3d& up);

}  // namespace keypose::composite
