// Space that the masks of a set share, as voxels that know how many masks deny them.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "capture/agreement/space_options.h"
#include "core/camera.h"
#include "core/image.h"

namespace keypose::capture {

/// What one mask says of a place in space.
enum class MaskSample : std::uint8_t { kUnseen, kDenied, kUpheld };

/// Samples one mask at places in space.
struct MaskSampler {
  const View* view = nullptr;
  bool inlier = true;  ///< its denials count
  Image8 denied;       ///< 1 where a place that is seen there is outside

  /// @param pixel  gets the place's pixel and depth, where it is seen
  MaskSample At(const Eigen::Vector3d& x_in_world, Eigen::Vector3d* pixel) const;
};

/// One for each view; the views must outlive them.
/// @param margin_px  a mask denies what it shows outside of itself by more than this
/// @param inlier     one a view, 0 where its denials do not count; empty: all count
std::vector<MaskSampler> MaskSamplersOf(const std::vector<View>& views,
                                        const std::vector<Image8>& masks, double margin_px,
                                        const std::vector<char>& inlier = {});

/// Voxels, each with the number of masks that deny it.
struct Grid {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  double cell = 0;
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  /// x fastest; more than are told apart count as one more than these
  std::vector<std::uint8_t> denials;

  std::size_t At(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size.y() + y) * size.x() + x;
  }
  Eigen::Vector3d Center(int x, int y, int z) const {
    return low + cell * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
  }
};

/// The space round the figure. A place that less than a third of the views see counts as denied by
/// all.
/// @param told_apart  how many denials are told apart in the voxels: the fewer, the sooner most
/// voxels are
///                    decided. 1 is enough for the hull, with one view's own sample aside
/// @throws InputError  the masks have no common space
Grid SharedSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const std::vector<MaskSampler>& samplers, const SpaceOptions& options,
                 int told_apart);

/// Lowest and highest voxels with fewer denials; the highest is -1 where there are none.
std::pair<Eigen::Vector3i, Eigen::Vector3i> BoundsOf(const Grid& grid, int denials);

/// Voxels along the longest side of what nobody denies, at least 1.
int LongestSide(const Grid& grid);

/// How many voxels' lengths of a pixel's ray nobody denies, the pixel's own view aside where
/// `others_only`.
int ChordOf(const MaskSampler& sampler, int x, int y, const Grid& grid, bool others_only);

}  // namespace keypose::capture
