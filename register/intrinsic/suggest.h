// Landmark suggestions and a dense map between two poses, from intrinsic geometry: how far apart
// things are along the surface.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "register/landmarks/landmarks.h"

namespace keypose::registration {

struct SuggestOptions {
  int count = 12;  ///< pairs to suggest at most (fewer where few are sure), known ones not counted
  int proxy_vertices = 1000;  ///< work happens on decimated copies of about so many vertices
  int samples = 250;    ///< farthest points of each proxy for which candidate maps are compared
  int functions = 80;   ///< Laplace-Beltrami eigenfunctions at the end of the refinement
  int candidates = 64;  ///< assignments of limb tips that are tried
  double min_confidence = 0.4;  ///< pairs below are not suggested

  /// One sentence per fault, naming field, value and range; empty when valid.
  std::vector<std::string> Problems() const;
};

/// A guess that a person should confirm.
struct SuggestedPair {
  PickedPair pick;        ///< name, face and barycentric coordinates on both meshes
  double confidence = 0;  ///< 0 to 1
  std::string origin;     ///< "tip" (end of a limb), "intrinsic" (anywhere else)
};

struct Suggestion {
  std::vector<SuggestedPair> pairs;  ///< best spread first; empty when nothing is sure enough
  std::vector<int> dense;  ///< for each source vertex a target vertex, or -1 (parts that nothing
                           ///< could be said about)
  Eigen::VectorXd confidence;  ///< for each source vertex, 0 to 1; 0 where dense is -1
  double distortion = 1;   ///< mean change of distances along the surface between samples, over the
                           ///< square root of the area
  double orientation = 0;  ///< share of the proxy's area whose image keeps its orientation; near 0
                           ///< would be a mirror image
  double margin = 0;  ///< how much worse the next different map scores, over the score; below 0.05
                      ///< is a coin toss
  std::string explanation;  ///< what was found and chosen, for the report; several sentences
};

/// Which point of the target belongs to which of the source, with no alignment and no start given.
///
/// The ends of limbs are assigned by branch and bound on distances along the surface; each good
/// assignment becomes a map that is refined in the bases of the Laplace-Beltrami eigenfunctions of
/// both proxies; the one that changes distances least, keeps orientation (a mirror image of a
/// symmetric body does not) and covers the target wins. Known pairs are taken as they are.
///
/// Vertex colours count as well where both meshes have them.
/// @param known  pairs that a person gave; they anchor the map (a few settle left and right)
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
