// A body without symmetry before a camera: the small world of these rooms' tests.
#pragma once

#include "composite/locating/lens/normal_equations.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::composite {

Mesh Joined(const Mesh& a, const Mesh& b);
Mesh BallAt(double x, double y, double z, double radius);
/// About 0.2 high.
Mesh OddBody();

/// 640 x 480 pixels, focal length 900.
Camera TestCamera();
/// That camera, at a distance from about the odd body's middle.
Placement LookingFrom(double azimuth_deg, double elevation_deg, double distance = 0.55);
/// The place moved by some degrees, and by about twice the shift.
Placement Disturbed(const Placement& at, double degrees, double shift);
double TurnBetween(const Placement& a, const Placement& b);  ///< degrees
/// The largest distance of a vertex between two placements [px].
double ShiftBetween(const Placement& a, const Placement& b, const PointsX3& points);
/// Light where the matte is, else dark.
Image8 GreyPicture(const Image8& matte);

}  // namespace keypose::composite
