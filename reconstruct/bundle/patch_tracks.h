// Tracks from the photographs' grey values: the position of each point's surface patch in every
// photograph that shows it, with subpixel accuracy.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/progress.h"
#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

struct PatchOptions {
  int radius_px = 6;  ///< half the patch's side, at the size of PatchImages
  /// standard deviation of the Gaussian filter: reduces noise, and bias at fractional pixels
  double smoothing_px = 0.8;
  double widest_deg = 50;  ///< largest angle between the viewing directions of the patch's source
                           ///< photograph and another
  /// largest angle between a viewing direction and the surface's normal
  double most_slanted_deg = 65;
  /// largest number of photographs searched for a patch, the nearest by direction
  int most_views = 12;
  double least_ncc = 0.7;      ///< least correlation of a match
  double most_shift_px = 3;    ///< largest distance between predicted and matched position
  double most_sigma_px = 0.5;  ///< largest standard deviation of a position, from the patch's
                               ///< gradients and the residual
};

/// A photograph prepared for the comparison of patches.
struct PatchImage {
  ImageF grey;       ///< smoothed; empty where there is none
  double scale = 1;  ///< its pixels over the photograph's: 0.5 is half the photograph's size
  Image8 mask;       ///< of grey's size; empty where there is none
  /// position of its corner in the reduced photograph [its px]
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
};
/// @param picture  grey, the photograph reduced by `scale`
/// @param mask     of the picture's size: parts farther than a patch from its box are cut off;
/// empty: no crop
PatchImage MakePatchImage(const Image8& picture, const Image8& mask, double scale,
                          const PatchOptions& options);

struct PatchTracks {
  Scene scene;  ///< the given views, and the points that at least two views show
  std::vector<Observation> observations;
  std::vector<int> source;     ///< for each point: its index among the given points
  int searched = 0;            ///< number of searched positions
  double mean_ncc = 0;         ///< of the matches
  double median_shift_px = 0;  ///< in the photographs' pixels
};

/// Each point's patch is cut from the photograph that sees the point most frontally, transferred to
/// all other photographs that should show it by the tangent plane (normal from the points around),
/// and moved to the best match: two unknowns besides brightness and contrast, by Gauss-Newton
/// steps. So points get positions also in photographs in which no feature was found.
///
/// @param images  by view
/// Cost: some thousand samples per position.
/// Same bits for any thread count.
/// Source: Furukawa & Ponce, "Accurate camera calibration from multi-view stereo and bundle
/// adjustment", IJCV 2009; the inverse compositional step is Baker & Matthews', IJCV 2004.
PatchTracks TrackPatches(const Scene& scene, const std::vector<PatchImage>& images,
                         const PatchOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
