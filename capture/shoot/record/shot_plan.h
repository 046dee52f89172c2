// Which photographs a pose needs: flips of the figure, rings of the camera, angles of the table.
#pragma once

#include <compare>
#include <optional>
#include <string>
#include <vector>

namespace keypose::capture::shoot {

struct ShotPlan {
  std::vector<double> rings_deg = {12, 40};  ///< elevation of the camera above the table, by ring
  int angles = 24;                           ///< of a ring, evenly round the circle
  int flips = 0;        ///< further placements of the figure on the table: on its side, ...
  int focus_stack = 1;  ///< photographs of each angle
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
  bool operator==(const ShotPlan&) const = default;
};

/// One photograph of the plan. In the order in which they are shot.
struct Shot {
  int flip = 0;   ///< 0 upright
  int ring = 1;   ///< from 1
  int index = 0;  ///< of the angle
  auto operator<=>(const Shot&) const = default;
};

std::vector<Shot> AllShots(const ShotPlan& plan);
/// In [0, 360).
double AngleOf(const ShotPlan& plan, const Shot& shot);
double TiltOf(const ShotPlan& plan, const Shot& shot);

/// "r1_a045"; "lying_r1_a045" and "lying2_r1_a045" on its sides. The angle is rounded.
std::string NameOf(const ShotPlan& plan, const Shot& shot);
/// The plan's shot of this name.
std::optional<Shot> ShotNamed(const ShotPlan& plan, const std::string& name);
/// The plan's shot nearest to an angle, if it is within half a degree.
std::optional<Shot> ShotAt(const ShotPlan& plan, int flip, int ring, double angle_deg);

/// "45", "22.5": without zeros at the end.
std::string DegreesText(double angle_deg);

}  // namespace keypose::capture::shoot
