// A start for registration from curve skeletons: for limbs that curl so far that closest points
// mislead.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/landmark_goal.h"
#include "core/mesh.h"
#include "core/progress.h"

namespace keypose::registration {

struct SkeletonOptions {
  int proxy_faces = 1600;  ///< both meshes are decimated to this before they are contracted
  int max_tips = 8;        ///< refuse skeletons with more ends than this
};

/// Positions that lay the source's limbs along the target's.
struct SkeletonStart {
  PointsX3 points;         ///< V x 3 in the target's frame; no rows when refused
  std::string words;       ///< what was matched, or why it was refused and what would help
  int branches = 0;        ///< matched
  bool ambiguous = false;  ///< another matching of the limbs fits nearly as well
  double seconds = 0;      ///< of processor time
  bool usable() const { return points.rows() > 0; }
};

/// Contracts both meshes to curve skeletons, matches their branches (tips by path lengths,
/// thickness profiles and landmarks; the rest of the tree must agree), and gives each source vertex
/// the motion of its place on the skeleton: position by equal normalised arc length, orientation by
/// parallel transport from the thickest place, turned about the branch by what landmarks say, else
/// not at all.
///
/// @param source, target      meshes without handles; loose parts (parts.h) are left out and
/// follow; holes are capped
/// @param landmarks           may be empty
/// @param target_from_source  a coarse alignment; decides between limbs that look the same and the
/// turn of the root Refuses (see `words`) meshes that are no manifold or have handles or several
/// large parts, and skeletons whose branches differ; never throws for those.
/// @throws InputError  unusable mesh
/// Cost: 0.12 s of processor time at 3,500 faces, 0.3 s at 15,000, most of it for the contraction
/// of the proxies.
/// Same bits for any thread count.
/// Source: Tagliasacchi et al., Mean Curvature Skeletons, SGP 2012 (CGAL's implementation), Wang et
/// al., rotation minimizing frames, 2008.
SkeletonStart StartFromSkeletons(const Mesh& source, const Mesh& target,
                                 const std::vector<LandmarkGoal>& landmarks,
                                 const Similarity3& target_from_source = {},
                                 const SkeletonOptions& options = {}, Progress* progress = nullptr);

}  // namespace keypose::registration
