// How much each bone of a skeleton moves each vertex of a mesh.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::armature {

/// A bone as a piece of straight line, at rest.
struct SkinBone {
  std::string name;
  Eigen::Vector3d head = Eigen::Vector3d::Zero(), tail = Eigen::Vector3d::Zero();
};

/// Up to four bones for each vertex, the heaviest first; what is left of four has weight 0.
struct SkinWeights {
  static constexpr int kMost = 4;
  std::vector<std::array<std::uint16_t, kMost>> bones;
  std::vector<std::array<double, kMost>> weights;  ///< of a vertex they sum to 1

  int vertex_count() const { return static_cast<int>(weights.size()); }
};

/// The four heaviest weights of each vertex, divided by their sum. Weights below 0 count as 0; a
/// vertex without weight gets the first bone.
/// @param dense  V x B
SkinWeights Pruned(const Eigen::MatrixXd& dense);

/// Moves a mesh with its bones by dual quaternions: a blend of rigid motions that is rigid again,
/// so that joints neither shrink nor twist shut.
///
/// Source: Kavan et al., TOG 2008, "Geometric Skinning with Approximate Dual Quaternion Blending".
class Skin {
 public:
  /// @param rest     V x 3
  /// @throws InputError  as many weights as vertices, bones and finite positions are not given
  Skin(const PointsX3& rest, SkinWeights weights, int bone_count);

  /// @param bones  of each: x_now = bones[b] * x_at_rest
  /// @param points  V x 3; resized when it has another size
  /// @param moved   for each bone whether it moved since `points` were posed: other vertices stay;
  ///                empty: all
  /// @pre as many bones as the constructor got
  /// Cost: linear. On the calling thread alone: a live pose must not wait for threads that draw its
  /// pictures.
  void Pose(const std::vector<Rigid3>& bones, PointsX3* points,
            const std::vector<char>& moved = {}) const;

  int vertex_count() const { return static_cast<int>(rest_.rows()); }

 private:
  PointsX3 rest_;
  SkinWeights weights_;
  int bone_count_;
};

}  // namespace keypose::armature
