// What is known of a cleaned mesh: size, angles, distance from its input; and colours carried over
// from it.
#pragma once

#include "cleanup/strategies/cleanup_result.h"

namespace keypose::cleanup {

/// Fills components, genus, area, volume, angles; verifies closedness and that nothing intersects.
/// @throws QualityError  the mesh is not what MakeClosedManifold promises
void Measure(const Mesh& mesh, double diagonal, CleanupResult& result);

/// Fills to_input (result against `input`) and from_input (`kept` against result), all in a frame
/// of diagonal 1.
void MeasureDistances(const Mesh& mesh, const Mesh& input, const Mesh& kept, CleanupResult& result);

/// Smallest angle of any face [deg]; 0 when one has no area.
double LeastAngleDeg(const Mesh& mesh);

/// Share of the area of `from` that lies farther than `distance` from `to`; sampled.
double ShareFartherThan(const Mesh& from, const Mesh& to, double distance);

/// Colour of the closest surface point, interpolated over its face.
/// @param colored has a colour a
/// vertex @return P x 3
ColorsX3 ColorsFrom(const Mesh& colored, const PointsX3& points);

}  // namespace keypose::cleanup
