// What the outlines say of points of stereo: which are wrong, by how much the others should move, and how far depths err.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "reconstruct/silhouettes.h"

namespace keypose::reconstruct {

/// A footprint is the world length of a pixel; the extent is the hull's longest side.
struct OutlineEvidenceOptions {
  double site = 0.01;   ///< of the extent, but at least 3 footprints: points of one cell of this size that face alike are judged together
  double reach = 0.05;  ///< of the extent; rim points farther off say nothing
  double least_limit = 1.5;  ///< footprints; a miss up to this contradicts nothing
  double errors = 2.5;       ///< a miss of more errors than this contradicts
};

constexpr int kErrorClasses = 8;
constexpr float kOutlineConfidence = 0.4f;

struct OutlineEvidence {
  PointCloud cloud;      ///< what is left of the points, moved; those that were put where the outlines say have at most kOutlineConfidence
  int contradicted = 0;  ///< rim points around, or around its neighbours, lie above or below: put on their surface, or on the hull
  int dropped = 0;       ///< contradicted, and the hull is far
  std::array<double, kErrorClasses> errors{};  ///< footprints; typical error of points of confidence k/8 to (k+1)/8, as outlines measure it
};

/// Rim points, tangents included, give a surface around them: a quadric fitted to them with a known error. Points of stereo that miss it
/// are put on it. How far those of each confidence miss it tells how far all such points err, and by this error and the quadric's the
/// others are moved to where both meet best. Where texture is weak stereo errs by several footprints and outlines lead; where it is rich
/// nearly nothing moves.
///
/// @param cloud  points of stereo, with outward normals and confidence
/// Cost: points are judged by sites, some dozen points each, with a 6 x 6 system a site. Same bits for any thread count.
OutlineEvidence HearOutlines(PointCloud cloud, const PointCloud& rims, const Silhouettes& silhouettes, double footprint, double extent,
                             const OutlineEvidenceOptions& options);

}  // namespace keypose::reconstruct
