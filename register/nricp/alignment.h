// The similarity transform that aligns the source to the target before it is bent.
#pragma once

#include <string>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::registration {

struct Alignment {
  Similarity3 target_from_source;
  std::string method;   ///< "procrustes", "icp", or "icp with landmarks"
  int starts = 1;       ///< number of orientations that were tried
  double residual = 0;  ///< root mean square over landmarks (procrustes) or over the closest 80 %
                        ///< of samples (icp), over the target's diagonal
  /// Dimension spanned by the landmarks, the lower of source and target: 0 a point or none, 1 a
  /// line, 2 a plane, 3 space
  int rank = 0;
};

/// Dimension that the points span about their mean, 0 to 3. An axis counts when its singular value
/// is at least 0.05 of the largest.
int SpreadRank(const PointsX3& points);

/// Aligns the source to the target by a similarity transform (never a reflection).
///
/// With three or more landmarks that are not on a line: Procrustes on the landmarks.
///
/// Otherwise (the paper needs landmarks; this is our addition): similarity ICP between area
/// samples, matched in both directions, with the closest 80 % of the pairs. It starts from 24 turns
/// about z and from the 24 axis rotations. The given orientation is kept unless another is 5 %
/// better. One or two landmarks, or landmarks on a line, join every fit; together they have the
/// weight of all samples.
/// @param source_marks, target_marks  L x 3, may be empty
/// @throws InputError  the source has no extent
/// Deterministic.
Alignment AlignGlobally(const Mesh& source, const Mesh& target, const PointsX3& source_marks,
                        const PointsX3& target_marks);

}  // namespace keypose::registration
