// The space that the masks of a set share: voxels with the number of their contradictions.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "capture/agreement/space_options.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

/// The value of one mask at a point in space.
enum class MaskSample : std::uint8_t { kUnseen, kContradicted, kConsistent };

/// Samples one mask at points in space.
struct MaskSampler {
  const View* view = nullptr;
  bool inlier = true;  ///< its contradictions count
  /// 1 where the picture is outside of the mask by more than the margin, 2 where something else
  /// hides what is behind it
  Image8 contradicted;

  /// @param pixel  set to the point's pixel and depth, if the view sees it
  MaskSample At(const Eigen::Vector3d& x_in_world, Eigen::Vector3d* pixel) const;
};

/// One per view; the views must outlive the samplers.
/// @param inlier  one per view, 0 where its contradictions do not count; empty: all count
std::vector<MaskSampler> MaskSamplersOf(const std::vector<View>& views,
                                        const std::vector<Image8>& masks,
                                        const SpaceOptions& options,
                                        const std::vector<char>& inlier = {});

/// Voxels, each with the number of masks that contradict it.
struct Grid {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  double cell = 0;
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  /// x fastest; larger numbers are stored as the limit plus one
  std::vector<std::uint8_t> contradictions;

  std::size_t At(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size.y() + y) * size.x() + x;
  }
  Eigen::Vector3d Center(int x, int y, int z) const {
    return low + cell * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
  }
};

/// The space around the figure. A point that too few of the views see (SpaceOptions::least_seen)
/// counts as contradicted by all.
/// @param told_apart  largest number of contradictions that is counted exactly. With a small number
/// most voxels are decided early; 1 is enough for the hull without one view's own sample
/// @throws InputError  the masks have no common space
Grid SharedSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const std::vector<MaskSampler>& samplers, const SpaceOptions& options,
                 int told_apart);

/// Lowest and highest voxels with fewer contradictions; the highest is -1 if there are none.
std::pair<Eigen::Vector3i, Eigen::Vector3i> BoundsOf(const Grid& grid, int contradictions);

/// Number of voxels along the longest side of the part without contradictions, at least 1.
int LongestSide(const Grid& grid);

/// Length of the part of a pixel's ray without contradictions, in voxels; with `others_only` the
/// pixel's own view is ignored.
int ChordOf(const MaskSampler& sampler, int x, int y, const Grid& grid, bool others_only);

}  // namespace keypose::capture
