// Tracks by the photographs' own grey values: where each point's patch of surface lies in every
// photograph that shows it, to a small part of a pixel.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/progress.h"
#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

struct PatchOptions {
  int radius_px = 6;  ///< half the patch's side, at the size of PatchImages
  /// standard deviation of the filter before: less noise, and less bias between pixels
  double smoothing_px = 0.8;
  double widest_deg = 50;  ///< between the lines of sight of the photograph that the patch is taken
                           ///< from and another
  double most_slanted_deg = 65;  ///< between a line of sight and the surface's normal
  int most_views = 12;           ///< photographs looked at for one patch, the nearest by direction
  double least_ncc = 0.7;        ///< correlation that a place needs
  double most_shift_px = 3;      ///< between where the cameras expect a patch and where it is found
  double most_sigma_px = 0.5;    ///< standard deviation that a place may have, by the patch's
                                 ///< gradients and what does not fit
};

/// A photograph as patches are compared in it.
struct PatchImage {
  ImageF grey;       ///< smoothed; empty where there is none
  double scale = 1;  ///< of its pixels over the photograph's: 0.5 is half the photograph's size
  Image8 mask;       ///< of grey's size; empty where there is none
  /// where its corner lies in the shrunk photograph [its px]
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
};
/// @param picture  grey, the photograph shrunk by `scale`
/// @param mask     of the picture's size: what lies farther than a patch from its box is cut off;
/// empty: nothing is
PatchImage MakePatchImage(const Image8& picture, const Image8& mask, double scale,
                          const PatchOptions& options);

struct PatchTracks {
  Scene scene;  ///< the views that were given, and points that at least two views show
  std::vector<Observation> observations;
  std::vector<int> source;     ///< of each point: which of the points given it was
  int searched = 0;            ///< places looked for
  double mean_ncc = 0;         ///< of those found
  double median_shift_px = 0;  ///< in the photographs' pixels
};

/// Each point's patch is cut from the photograph that sees the point least slanted, carried over to
/// all others that should show it by the tangent plane (normal from the points around), and moved
/// until it fits: two unknowns, brightness and contrast aside, by Gauss-Newton steps. Points
/// thereby get places in photographs in which no feature was found.
///
/// @param images  by view
/// Cost: some thousand samples a place.
/// Same bits for any thread count.
/// Source: Furukawa & Ponce, "Accurate camera calibration from multi-view stereo and bundle
/// adjustment", IJCV 2009; the inverse compositional step is Baker & Matthews', IJCV 2004.
PatchTracks TrackPatches(const Scene& scene, const std::vector<PatchImage>& images,
                         const PatchOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
