// Queries along each pixel's ray in the space that all masks share: contradictions, thickness,
// agreement.
#pragma once

#include <vector>

#include "capture/agreement/space_options.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::capture {

/// For each mask a picture with, for each pixel, the smallest number of contradictions by other
/// masks among the points of its ray. Pixels whose rays miss the figure's space have the largest
/// number that is counted. A point that less than a third of the views see is outside.
/// @param views  with cameras of the masks' size
/// @param inlier one per view: masks with 0 contradict nothing; empty: all are inliers
/// @throws InputError  fewer than 3 masks that are not empty, or no common space
/// Same bits for any thread count.
std::vector<Image8> ContradictionsByOthers(const std::vector<View>& views,
                                           const std::vector<Image8>& masks,
                                           const SpaceOptions& options,
                                           const std::vector<char>& inlier = {});

/// Largest number of contradictions that is counted exactly, for a given number of inliers.
int MostContradictionsCounted(std::size_t views, const SpaceOptions& options);

/// For each pixel of a mask, the length of its ray inside the hull of all masks: per cent of the
/// hull's longest side.
/// @param inlier  as above
/// @throws InputError  the masks have no common space
/// Same bits for any thread count.
std::vector<Image8> ThicknessOfHull(const std::vector<View>& views,
                                    const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& inlier = {});

/// The surface of the space without contradictions by inliers: points with outward normals, one per
/// surface voxel.
struct SpaceSurface {
  PointCloud points;
  double cell = 0;  ///< side of a voxel
};

/// @throws InputError  as ContradictionsByOthers
SpaceSurface SurfaceOfSpace(const std::vector<View>& views, const std::vector<Image8>& masks,
                            const SpaceOptions& options, const std::vector<char>& inlier);

/// IoU of each mask with the silhouette of the visual hull of the others: points with fewer than
/// two contradictions.
std::vector<double> AgreementInSpace(const std::vector<Image8>& masks,
                                     const std::vector<Image8>& contradictions);

}  // namespace keypose::capture
