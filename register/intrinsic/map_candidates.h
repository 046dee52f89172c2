// Candidate maps between two poses, each grown from one assignment of limb tips.
#pragma once

#include <memory>
#include <vector>

#include "register/intrinsic/functional_map.h"
#include "register/intrinsic/intrinsic_shape.h"

namespace keypose::registration {

/// A map between the samples of both shapes, and what speaks for and against it.
struct MapCandidate {
  /// indices into the shapes' tips that this started from, in pairs
  std::vector<int> source_tips, target_tips;
  PointMaps maps;          ///< between samples
  double distortion = 1;   ///< mean change of distances between samples, both ways
  double orientation = 0;  ///< correlation of the turns between tips, -1 (mirror image) to 1
  double coverage = 0;     ///< share of samples that are hit, the worse of both ways
  double unfit = 1;  ///< root mean square distance that the best turn and scale of the whole leaves
  double unlike = 1;  ///< mean difference of descriptors
  double score = 1;   ///< of all these, lower is better
};

/// Both shapes must outlive it. Deterministic, same bits for any thread count.
class MapSearch {
 public:
  MapSearch(const IntrinsicShape& source, const IntrinsicShape& target);
  ~MapSearch();

  /// Tries the `tried` best assignments of tips; returns the maps that they lead to, best first,
  /// never empty.
  /// @param known  the first so many tips of both belong together
  std::vector<MapCandidate> Run(int known, int tried) const;
  /// Judges a map between samples that comes from elsewhere.
  MapCandidate Judged(const std::vector<int>& source_tips, const std::vector<int>& target_tips,
                      const PointMaps& maps) const;

 private:
  struct Shared;
  std::unique_ptr<const Shared> shared_;
};

}  // namespace keypose::registration
