// The similarity that brings the source onto the target before any bending.
#pragma once

#include <string>

#include "core/camera.h"
#include "core/mesh.h"

namespace keypose::registration {

struct Alignment {
  Similarity3 target_from_source;
  std::string method;   ///< "procrustes", "icp", or "icp with landmarks"
  int starts = 1;       ///< orientations that were tried
  double residual = 0;  ///< root mean square over landmarks (procrustes) or over the closest 80 %
                        ///< of samples (icp), over the target's diagonal
  /// of the source landmarks' spread: 0 a point or none, 1 a line, 2 a plane, 3 space
  int rank = 0;
};

/// Rank of the spread of points about their mean; an axis counts when its singular value is at
/// least 0.05 of the largest.
int SpreadRank(const PointsX3& points);

/// Procrustes on the landmarks where there are three or more that do not lie on a line (rotation
/// always proper).
///
/// Else (the paper needs landmarks; this is our addition) similarity ICP between area samples,
/// matched both ways, trimmed to the closest 80 %, from 24 turns about z and from the 24 axis
/// rotations; the pose as given is kept unless another is 5 % better. One or two landmarks, or a
/// line of them, join every fit with the weight of all samples together.
/// @param source_marks, target_marks  L x 3, may be empty
/// @throws InputError  the source has no extent
/// Deterministic.
Alignment AlignGlobally(const Mesh& source, const Mesh& target, const PointsX3& source_marks,
                        const PointsX3& target_marks);

}  // namespace keypose::registration
