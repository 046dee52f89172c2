// What the space that all masks share says of each pixel's ray: denials, thickness, agreement.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::capture {

/// For each mask a picture of how many of the other masks deny all places along a pixel's ray: the
/// least number over the places. Pixels that look past the space of the figure have the most that
/// is told apart. A place that less than a third of the views see is outside.
/// @param views  with cameras of the masks' size
/// @param inlier one a view: the masks of those with 0 deny nothing; empty: all are inliers
/// @throws InputError  fewer than 3 masks with anything in them, or they have no common space
/// Same bits for any thread count.
std::vector<Image8> DenialsByOthers(const std::vector<View>& views,
                                    const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& inlier = {});

/// How many denials are told apart in a set of so many inliers.
int DenialsToldApart(std::size_t views, const SpaceOptions& options);

/// For each pixel of a mask how much of its ray lies in the hull of all masks: per cent of the
/// hull's longest side.
/// @param inlier  as above
/// @throws InputError  the masks have no common space
/// Same bits for any thread count.
std::vector<Image8> ThicknessOfHull(const std::vector<View>& views,
                                    const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& inlier = {});

/// The surface of what no inlier denies: points with outward normals, one near each voxel.
struct SpaceSurface {
  PointCloud points;
  double cell = 0;  ///< side of a voxel
};

/// @throws InputError  as DenialsByOthers
SpaceSurface SurfaceOfSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                            const SpaceOptions& options, const std::vector<char>& inlier);

/// IoU of each mask with the silhouette of the visual hull of the others: places that fewer than
/// two deny.
std::vector<double> AgreementInSpace(const std::vector<Image8>& masks,
                                     const std::vector<Image8>& denials);

}  // namespace keypose::capture
