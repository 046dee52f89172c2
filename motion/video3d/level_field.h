// A smooth field over a surface that brings one texture's brightness to another's.
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "core/values/mesh.h"
#include "motion/video3d/surface_texels.h"

namespace keypose::motion {

/// Factors of linear colours: as logarithms, one row per vertex.
using LevelFactors = Eigen::Matrix<float, Eigen::Dynamic, 3>;

/// Linear light that is added before logarithms, because black consists of noise only.
inline constexpr float kLevelDark = 0.01f;

/// A colour with the factors applied.
Eigen::Vector3f Levelled(const Eigen::Vector3f& linear, const Eigen::Vector3f& log_factors);

/// Finds the factors for one frame after the other; each search begins with the last one's.
class LevelField {
 public:
  /// Refers to `texels`, which must outlive this.
  LevelField(int vertex_count, const FacesX3& faces, const SurfaceTexels& texels);

  /// The factors that bring `other` to `own`, measured at texels where both are sure, and continued
  /// smoothly (harmonically, over the surface) to where they are not. Vertices that differ from
  /// their surroundings by more than light can (another content) have little weight.
  /// @param own, other  N x 3 and N, as TexelColors, of the same texels
  const LevelFactors& Match(const TexelColors& own, const TexelColors& other);

 private:
  struct Ratios;
  Ratios Measure(const TexelColors& own, const TexelColors& other) const;
  void Smooth(const Ratios& ratios);

  FacesX3 faces_;
  const SurfaceTexels& texels_;
  std::vector<std::pair<int, int>> edges_;
  Eigen::VectorXf degree_;
  LevelFactors factors_;
  bool first_ = true;
};

}  // namespace keypose::motion
