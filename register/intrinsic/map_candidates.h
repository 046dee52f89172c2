// Candidate maps between two poses, each computed from one assignment of limb tips.
#pragma once

#include <memory>
#include <vector>

#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/intrinsic_shape.h"

namespace keypose::registration {

/// A map between the samples of both shapes, and its quality.
struct MapCandidate {
  /// The assigned tips: source_tips[i] belongs to target_tips[i]; indices into the shapes' tips
  std::vector<int> source_tips, target_tips;
  PointMaps maps;          ///< between samples
  double distortion = 1;   ///< mean change of distances between samples, both ways
  double orientation = 0;  ///< correlation of the turns between directions to samples, -1 (mirror
                           ///< image) to 1
  double coverage = 0;     ///< share of samples that are hit, by area, the worse of both ways
  double unfit = 1;        ///< root mean square distance after the best similarity transform
  double unlike = 1;       ///< mean difference of descriptors
  double score = 1;        ///< from all of these and the missed landmarks; lower is better
};

/// Finds and scores candidate maps. Both shapes must outlive it.
/// Deterministic, same bits for any thread count.
class MapSearch {
 public:
  MapSearch(const IntrinsicShape& source, const IntrinsicShape& target);
  ~MapSearch();

  /// Computes a map from each of the best assignments of tips.
  /// @param known  the first `known` tips of both shapes belong together
  /// @param tried  number of assignments to try
  /// @return the maps that were refined to the end, best first, never empty
  std::vector<MapCandidate> Run(int known, int tried) const;
  /// Scores a given map between samples.
  MapCandidate Scored(const std::vector<int>& source_tips, const std::vector<int>& target_tips,
                      const PointMaps& maps) const;

 private:
  struct Shared;
  std::unique_ptr<const Shared> shared_;
};

}  // namespace keypose::registration
