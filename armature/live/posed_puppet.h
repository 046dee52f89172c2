// From an armature's values to the posed character: skeleton, and mesh.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armature/matching/puppet_match.h"
#include "armature/skinning/skin.h"
#include "core/values/mesh.h"

namespace keypose::armature {

/// Everything that a puppet is made of.
struct PuppetParts {
  Armature armature;
  ChainPlan plan;
  Skeleton skeleton;
  Similarity3 world_from_armature;  ///< to the world of skeleton and mesh
  PuppetOptions options;
  Mesh mesh;            ///< at rest
  SkinWeights weights;  ///< of the skeleton's bones
};

class PosedPuppet {
 public:
  /// @throws InputError  as PuppetMatcher and Skin
  explicit PosedPuppet(const PuppetParts& parts);

  /// Poses skeleton and mesh; does nothing when no value has changed.
  /// @throws InputError  not one finite value for each of the armature's joints
  void Update(const std::vector<double>& values);

  const PuppetMatcher& matcher() const { return matcher_; }
  const PointsX3& points() const { return points_; }
  double match_s() const { return match_s_; }  ///< that the last update took for the skeleton
  double skin_s() const { return skin_s_; }    ///< ... and for the mesh

 private:
  std::vector<char> MovedBones(const std::vector<Rigid3>& bones) const;

  PuppetMatcher matcher_;
  Skin skin_;
  PointsX3 points_;
  std::vector<Rigid3> last_bones_;  ///< of points_
  double match_s_ = 0, skin_s_ = 0;
};

/// The skeleton's bones for the mesh, one for each joint; a root's is a point.
std::vector<SkinBone> SkinBonesOf(const Skeleton& skeleton);

/// The bone that turns with each joint: that to its child; of several children that of the longest
/// row of joints; its own for a joint without a child.
std::vector<int> LeadingBones(const Skeleton& skeleton);

}  // namespace keypose::armature
