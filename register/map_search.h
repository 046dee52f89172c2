// Candidate maps between two poses, each grown from one assignment of limb tips.
#pragma once

#include <vector>

#include "register/functional_map.h"
#include "register/intrinsic_shape.h"

namespace keypose::registration {

/// A map between the samples of both shapes, and what speaks for and against it.
struct MapCandidate {
  std::vector<int> source_tips, target_tips;  ///< indices into the shapes' tips that this started from, in pairs
  PointMaps maps;                             ///< between samples
  double distortion = 1;                      ///< mean change of distances between samples, both ways
  double orientation = 0;                     ///< correlation of the turns between tips, -1 (mirror image) to 1
  double coverage = 0;                        ///< share of samples that are hit, the worse of both ways
  double unfit = 1;                           ///< root mean square distance that the best turn and scale of the whole leaves
  double unlike = 1;                          ///< mean difference of descriptors
  double score = 1;                           ///< of all these, lower is better
};

/// Tries the `tried` best assignments of tips; returns the different maps that they lead to, best first, never empty.
///
/// @param known  the first so many tips of both belong together
/// Deterministic, same bits for any thread count.
std::vector<MapCandidate> SearchMaps(const IntrinsicShape& source, const IntrinsicShape& target, int known, int tried);

/// Judges a map between samples that comes from elsewhere.
MapCandidate JudgeMaps(const IntrinsicShape& source, const IntrinsicShape& target, const std::vector<int>& source_tips,
                       const std::vector<int>& target_tips, const PointMaps& maps);

}  // namespace keypose::registration
