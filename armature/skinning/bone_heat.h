// Skin weights from heat that flows from the bones over the surface.
#pragma once

#include <vector>

#include "armature/skinning/skin.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::armature {

struct BoneHeat {
  SkinWeights weights;
  /// Vertices that see their nearest bone from inside the surface; the others get their weights
  /// from these alone.
  int seeing = 0;
  /// Separate parts of the mesh of which no vertex sees its bone: they are warmed by their nearest
  /// bones through the surface.
  int blind_parts = 0;
};

/// Solves (L + M H) w_b = M H p_b for all bones b at once: L the cotangent Laplacian, M the
/// vertices' areas, H = 1 / d^2 with the distance d of the nearest bone if a vertex sees it and 0
/// else, p_b = 1 where b is nearest. Then the four largest weights of each vertex, divided by their
/// sum.
///
/// @param mesh   in the pose in which the bones were placed; closed surfaces give the best result
/// @param bones  at most 65,535; those of no length are points
/// @throws InputError  an unusable mesh (mesh_checks.h), no bones
/// Cost: one sparse factor, one right-hand side a bone. Same bits for any thread count.
/// Source: Baran & Popovic, SIGGRAPH 2007. Departs: negative cotangents are raised, so that no
/// weight leaves 0 to 1.
BoneHeat HeatWeights(const Mesh& mesh, const std::vector<SkinBone>& bones,
                     Progress* progress = nullptr);

/// The bone nearest to each vertex gets all its weight.
SkinWeights NearestBoneWeights(const PointsX3& points, const std::vector<SkinBone>& bones);

}  // namespace keypose::armature
