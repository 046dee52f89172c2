// Two scans of one clay thing in two poses, and where every vertex of the first really is in the
// second.
#pragma once

#include <string>
#include <vector>

#include "core/io/landmarks_io.h"
#include "core/mesh.h"
#include "synth/limbed_shapes.h"

namespace keypose::synth {

struct ClayPairOptions {
  LimbedShapeOptions shape;  ///< shape.places landmarks
  int vertices = 1738;       ///< of the source, about
  double ratio = 1;          ///< target faces for one source face, 0.1 to 40
  /// of the target's vertices, standard deviation for each axis over the target's diagonal
  double noise = 0;
  /// of the picks on the target before they snap to it; below 0: four times `noise`
  double landmark_noise = -1;
  int holes = 0;            ///< round holes in the target; none on a landmark
  double hole_area = 0.02;  ///< share of the area that they take in all
  double turn_deg = 0;      ///< the target as a whole, about an axis of the seed's
  double scale = 1;         ///< the target as a whole

  std::vector<std::string> Problems() const;
};

/// A registration problem with its exact answer.
struct ClayPair {
  Mesh source;     ///< rest pose [m]
  Mesh target;     ///< another tessellation of the posed solid, then noise and holes
  PointsX3 truth;  ///< row i: the place of source vertex i in the target's pose, exactly
  std::vector<LandmarkPair> picks;  ///< on source: a vertex; on target: anywhere on a face
  std::vector<Place> places;        ///< what the picks stand for
  double diagonal = 0;              ///< of the target before noise and holes
};

/// Same bits for the same options and for any thread count. The source depends on seed, shape and
/// vertices only; so pairs that differ in bend, noise or landmarks share it.
///
/// @throws UsageError  an option out of range @throws InputError  as MakeLimbedShape and Tessellate
ClayPair MakeClayPair(const ClayPairOptions& options);

}  // namespace keypose::synth
