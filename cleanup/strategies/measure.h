// Measurements of a cleaned mesh: size, angles, distance from its input. Transfer of colours from
// the input.
#pragma once

#include "cleanup/strategies/cleanup_result.h"

namespace keypose::cleanup {

/// Fills components, genus, area, volume and angles. Checks that the mesh is closed and that no
/// faces intersect.
/// @throws QualityError  the mesh does not satisfy what MakeClosedManifold guarantees
void Measure(const Mesh& mesh, double diagonal, CleanupResult& result);

/// Fills to_input (result against `input`) and from_input (`kept` against result), all in a frame
/// of diagonal 1.
void MeasureDistances(const Mesh& mesh, const Mesh& input, const Mesh& kept, CleanupResult& result);

/// Smallest angle of all faces [deg]; 0 when a face has no area.
double LeastAngleDeg(const Mesh& mesh);

/// Share of the area of `from` that is farther than `distance` from `to`; sampled.
double ShareFartherThan(const Mesh& from, const Mesh& to, double distance);

/// The colour of the closest surface point of `colored`, interpolated over its face.
/// @param colored  has a colour for each vertex
/// @return P x 3
ColorsX3 ColorsFrom(const Mesh& colored, const PointsX3& points);

}  // namespace keypose::cleanup
