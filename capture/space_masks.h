// Masks that agree with each other in space, once the cameras are known.
#pragma once

#include <vector>

#include "capture/masking.h"
#include "capture/view_standing.h"
#include "core/camera.h"
#include "core/image.h"
#include "core/progress.h"

namespace keypose::capture {

struct SpaceOptions {
  int resolution = 128;  ///< voxels along the longest side of the space that the masks share
  int most_denials = 8;  ///< views against a place that are told apart, fewer in sets below 48; more count as this many
  double margin_px = 1;  ///< a mask denies a place that it shows outside of itself by more than this
  double weight = 2;     ///< of what the others say against what the photograph shows
  StandingOptions standing{};
  ColorOptions colors{};
};

/// For each mask a picture of how many of the other masks deny all places along a pixel's ray: the least number over the places. Pixels
/// that look past the space of the figure have the most that is told apart. A place that less than a third of the views see is outside.
/// @param views  with cameras of the masks' size
/// @param say    one a view: the masks of those with 0 deny nothing; empty: all are heard
/// @throws InputError  fewer than 3 masks with anything in them, or they have no common space
/// Same bits for any thread count.
std::vector<Image8> DenialsByOthers(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& say = {});

/// How many denials are told apart in a set of so many views that are heard.
int DenialsToldApart(std::size_t views, const SpaceOptions& options);

/// For each pixel of a mask how much of its ray lies in the hull of all masks: per cent of the hull's longest side.
/// @param say  as above
/// @throws InputError  the masks have no common space
/// Same bits for any thread count.
std::vector<Image8> ThicknessOfHull(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options,
                                    const std::vector<char>& say = {});

/// The surface of what no view that is heard denies: points with outward normals, one near each voxel.
struct SpaceSurface {
  PointCloud points;
  double cell = 0;  ///< side of a voxel
};

/// @throws InputError  as DenialsByOthers
SpaceSurface SurfaceOfSpace(const std::vector<View>& views, const std::vector<Image8>& masks, const SpaceOptions& options,
                            const std::vector<char>& say);

struct RefinedMasks {
  std::vector<Image8> masks;
  std::vector<Backdrop> backdrops;                  ///< to open narrow gaps by at full size
  std::vector<double> agreement_before, agreement;  ///< of each, see AgreementInSpace; at half the size
  Standing standing_before, standing;               ///< of the views: which contradict the others, by the first masks and by the last
};

/// IoU of each mask with the silhouette of the visual hull of the others: places that fewer than two deny.
std::vector<double> AgreementInSpace(const std::vector<Image8>& masks, const std::vector<Image8>& denials);

/// Segments the set again with what the other views say of each pixel's ray as a further witness: how much its say weighs is measured from
/// how it goes with the masks. A part of the set that only some views took for the figure is denied by those that see past it; a part of
/// the figure that one view missed is upheld by all others.
///
/// A view whose first mask, or whose colours, contradict the others is not heard, and nobody leans its own: its next masks are what its
/// photograph shows by itself, with what the others taught of colours. If these contradict too, and still when the others' word leans them
/// (a dark side before a dark set gives way to it, a place where the photograph clearly shows the set does not), it has no say in the end;
/// else it is heard again.
/// @param images  RGB at working size
/// @param masks   of the same size
/// @param views   with cameras of that size
/// @param boards  what the printed plate tells of each image; empty, or one for each, empty where there is none
/// Source: Campbell, Vogiatzis, Hernandez & Cipolla, "Automatic 3D object segmentation in multiple views using volumetric graph-cuts", IVC
/// 2010, which cuts the voxels; here the images are cut, which keeps the outline as fine as they are.
RefinedMasks RefineInSpace(const std::vector<Image8>& images, const std::vector<Image8>& masks, const std::vector<View>& views,
                           const std::vector<BoardOdds>& boards, const MaskOptions& masking, const SpaceOptions& options,
                           Progress* progress = nullptr);

}  // namespace keypose::capture
