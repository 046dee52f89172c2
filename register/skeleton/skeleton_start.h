// A start for registration from curve skeletons. It helps with limbs that curl so far that closest
// points mislead.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::registration {

struct SkeletonOptions {
  int proxy_faces = 1600;  ///< faces of the decimated copies that are contracted
  int max_tips = 8;        ///< skeletons with more tips than this are refused
};

/// Positions that place the source's limbs along the target's.
struct SkeletonStart {
  PointsX3 points;         ///< V x 3 in the target's frame; no rows when refused
  std::string words;       ///< what was matched, or why it was refused and what would help
  int branches = 0;        ///< number of matched limbs
  bool ambiguous = false;  ///< another matching of the limbs fits nearly as well
  double seconds = 0;      ///< of processor time
  bool usable() const { return points.rows() > 0; }
};

/// Contracts both meshes to curve skeletons, matches their limbs, and moves each source vertex with
/// its place on the skeleton.
///
/// Tips are matched by path lengths, thickness and landmarks; the rest of the trees must agree.
/// Along a limb, points with the same normalised arc length correspond. The orientation comes from
/// parallel transport, starting at the thickest joint. Landmarks off the axis add a twist about the
/// limb; without them there is none.
///
/// Meshes that are not manifold, have handles or several large parts, and skeletons whose limbs
/// differ, are refused (see `words`) and not an error.
/// @param source, target      meshes without handles; loose parts (parts.h) are left out and follow
///                            afterwards; holes are capped
/// @param landmarks           may be empty
/// @param target_from_source  a coarse alignment; it decides between limbs that look the same, and
///                            sets the orientation of the root
/// @throws InputError  unusable mesh
/// @throws Cancelled
/// Cost: 0.12 s of processor time at 3,500 faces, 0.3 s at 15,000; most of it is the contraction of
/// the proxies.
/// Same bits for any thread count.
/// Source: Tagliasacchi et al., Mean Curvature Skeletons, SGP 2012 (CGAL's implementation), Wang et
/// al., rotation minimizing frames, 2008.
SkeletonStart StartFromSkeletons(const Mesh& source, const Mesh& target,
                                 const std::vector<LandmarkGoal>& landmarks,
                                 const Similarity3& target_from_source = {},
                                 const SkeletonOptions& options = {}, Progress* progress = nullptr);

}  // namespace keypose::registration
