// Two scans of one clay figure in two poses, and the true position of every vertex of the first in
// the second.
#pragma once

#include <string>
#include <vector>

#include "core/io/project/landmarks_io.h"
#include "core/values/mesh.h"
#include "synth/worlds/limbed_shapes.h"

namespace keypose::synth {

struct ClayPairOptions {
  LimbedShapeOptions shape;  ///< shape.places landmarks
  int vertices = 1738;       ///< approximate number in the source
  double ratio = 1;          ///< target faces per source face, 0.1 to 40
  /// of the target's vertices: standard deviation per axis / diagonal of the target
  double noise = 0;
  /// the same for picks on the target, before they snap to the surface; below 0: four times `noise`
  double landmark_noise = -1;
  int holes = 0;            ///< round holes in the target; none on a landmark
  double hole_area = 0.02;  ///< share of the area of all holes together
  double turn_deg = 0;      ///< rotation of the whole target about a random axis
  double scale = 1;         ///< scale of the whole target

  std::vector<std::string> Problems() const;
};

/// A registration problem with its exact solution.
struct ClayPair {
  Mesh source;     ///< rest pose [m]
  Mesh target;     ///< another tessellation of the posed solid, with noise and holes
  PointsX3 truth;  ///< row i: exact position of source vertex i in the target's pose
  std::vector<LandmarkPair> picks;  ///< on source: a vertex; on target: anywhere on a face
  std::vector<Place> places;        ///< the places that the picks mark
  double diagonal = 0;              ///< of the target before noise and holes
};

/// Same bits for the same options and for any thread count. The source depends only on seed, shape
/// and vertices, so pairs that differ in bend, noise or landmarks share it.
///
/// @throws UsageError  an option out of range @throws InputError  as MakeLimbedShape and Tessellate
ClayPair MakeClayPair(const ClayPairOptions& options);

}  // namespace keypose::synth
