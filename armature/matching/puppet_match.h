// The computer's skeleton posed after the armature: all chains, of which only those that moved are
// matched again.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "armature/description/armature.h"
#include "armature/matching/chain_match.h"
#include "armature/matching/joint_skeleton.h"
#include "core/values/camera.h"

namespace keypose::armature {

struct PuppetOptions {
  bool greedy = false;  ///< the paper's method; else both ends are exact
  MatchOptions match;
};

/// What became of a chain in the last pose.
struct ChainState {
  std::string name;
  ChainMatch match;         ///< in the skeleton's world
  double chain_length = 0;  ///< of its rods
};

/// Holds the pose of the moment before, from which the next match starts.
class PuppetMatcher {
 public:
  /// @param world_from_armature  from the armature's world to that of the skeleton
  /// @throws InputError  a chain names a joint that the skeleton does not have, its joints do not
  /// follow each other, an exact chain has not as many rods as the armature
  PuppetMatcher(const Armature& armature, const ChainPlan& plan, const Skeleton& skeleton,
                const Similarity3& world_from_armature, const PuppetOptions& options);
  ~PuppetMatcher();
  PuppetMatcher(PuppetMatcher&&) noexcept;

  /// Poses the skeleton. The first call matches all chains.
  /// @param values  of the armature's joints [rad, m]
  /// @throws InputError  not one finite value for each joint
  const SkeletonPose& Update(const std::vector<double>& values);

  const SkeletonPose& pose() const;
  const std::vector<ChainState>& chains() const;
  /// Chains that the last call matched.
  int matched() const;
  /// Whether any bone moved in the last call.
  bool moved() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Where the armature stands in the skeleton's world, if nothing else is known: the lengths of all
/// chains agree in sum, and the first chain's near anchor in the zero position is where its joint
/// is at rest.
/// @param y_up  whether the armature's y axis points up, as z does in the world; else its z axis
/// @throws InputError  a chain's joint is missing, or chains have no length
Similarity3 PlacementOf(const Armature& armature, const ChainPlan& plan, const Skeleton& skeleton,
                        bool y_up);

}  // namespace keypose::armature
