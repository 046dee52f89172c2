// Landmark suggestions and a dense map between two poses, from intrinsic geometry: distances along
// the surface.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "register/landmarks/landmarks.h"

namespace keypose::registration {

struct SuggestOptions {
  int count = 12;               ///< most pairs to suggest; known pairs do not count
  int proxy_vertices = 1000;    ///< size of the decimated copies that are compared
  int samples = 250;            ///< points of each proxy at which candidate maps are compared
  int functions = 80;           ///< Laplace-Beltrami eigenfunctions at the end of the refinement
  int candidates = 64;          ///< number of assignments of limb tips that are tried
  double min_confidence = 0.4;  ///< pairs with a lower confidence are not suggested

  /// One sentence per fault, naming field, value and range; empty when valid.
  std::vector<std::string> Problems() const;
};

/// A suggested pair, which a person should confirm.
struct SuggestedPair {
  PickedPair pick;        ///< name, face and barycentric coordinates on both meshes
  double confidence = 0;  ///< 0 to 1
  std::string origin;     ///< "tip" (end of a limb), "intrinsic" (anywhere else)
};

struct Suggestion {
  std::vector<SuggestedPair> pairs;  ///< ends of limbs first; empty when nothing is sure enough
  std::vector<int> dense;  ///< for each source vertex a target vertex, or -1 where nothing is known
  Eigen::VectorXd confidence;  ///< for each source vertex, 0 to 1; 0 where dense is -1
  double distortion = 1;   ///< mean change of distances along the surface between samples, over the
                           ///< square root of the area
  double orientation = 0;  ///< share of the mapped area that keeps its orientation; lower for a
                           ///< mirror image
  double margin = 0;  ///< how much worse the next different map scores, over the score; below 0.05
                      ///< the choice between the two is not reliable
  std::string explanation;  ///< what was found and chosen, for the report
};

/// Finds which point of the target belongs to which point of the source, without any alignment.
///
/// 1. Ends of limbs are assigned by branch and bound on distances along the surface.
/// 2. Each good assignment becomes a map. It is refined in the Laplace-Beltrami eigenfunctions of
///    both proxies.
/// 3. The best map changes distances little, keeps orientation (a mirror image of a symmetric body
///    does not) and covers the target.
///
/// Vertex colours are used where both meshes have them.
/// @param known  pairs given by a person; they are kept, and a few decide between left and right
/// @throws InputError  unusable mesh or options
/// @throws Cancelled
/// Cost: decimation, near-linear; then independent of the input's size. Deterministic, same bits
/// for any thread count.
/// Source: Ren et al., Discrete optimization for ... maps, 2018 and 2020; Melzi et al., ZoomOut,
/// 2019 (see docs/stages/landmarks.md).
Suggestion SuggestLandmarks(const Mesh& source, const Mesh& target,
                            const std::vector<LandmarkGoal>& known, const SuggestOptions& options,
                            Progress* progress = nullptr);

}  // namespace keypose::registration
