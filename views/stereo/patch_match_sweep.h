// One red-black pass of PatchMatch over one view: propagation of planes between pixels, source view
// selection, refinement.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "views/hull/depth_bounds.h"
#include "views/prepared/prepared_view.h"
#include "views/stereo/patch_match_cost.h"
#include "views/stereo/patch_match_warp.h"
#include "views/stereo/plane_map.h"

namespace keypose::stereo {

/// Unit normal towards the camera, in the camera's frame.
Eigen::Vector3d PlaneNormal(const Pinhole& camera, double x, double y,
                            const PlaneHypothesis& plane);

/// The constant inputs of a pass over one view.
struct SweepInputs {
  const PreparedView* reference = nullptr;
  std::vector<const PreparedView*> sources;  ///< at most 16, best first
  std::vector<const SampleImage*> samples;   ///< of each source at this level
  int level = 0;
  const DepthBounds* bounds = nullptr;
  /// of each source at this level, for geometric passes; else empty
  std::vector<const DepthImage*> source_inverse_depths;
  /// of the coarser level: expected inverse depth where texture is weak; may be null
  const DepthImage* prior = nullptr;
  float noise_variance = 0;
  /// windows are narrow where their variance is at least this, grey levels^2
  float narrow_variance = std::numeric_limits<float>::infinity();
  std::uint64_t seed = 0;
};

struct SweepSettings {
  bool select_sources = false;  ///< select sources anew, from all sources' costs of all candidates;
                                ///< else use each pixel's selection
  bool refresh = false;         ///< the planes' costs are unknown: compute them
  bool far_areas = false;       ///< also take candidates from pixels up to 23 pixels away
  int refinements = 3;
  /// after the random changes, move each depth to the minimum of a parabola
  bool parabola = false;
  float depth_step_px = 0.5f;  ///< size of random depth changes, as displacement in the sources
  float slope_step = 0.2f;     ///< size of random tilts, tangent of the slant
  int pass = 0;                ///< seed of the pass's random numbers
};

constexpr int kMaxSources = 16;
constexpr int kSourcesUsed = 4;

/// Displacement in the sources (pixels of the level, mean) per unit of inverse depth at the object.
double PixelsPerInverseDepth(const SweepInputs& inputs);

/// Pixels that a pass visits: in the mask, with bounds.
bool Visited(const SweepInputs& inputs, int x, int y);

/// Improves `map` in place: all pixels of one colour of the checkerboard, then of the other. Each
/// pixel reads only the other colour, so the order within a colour does not matter.
/// @return number of window correlations
/// Source: Galliani, Lasinger & Schindler, ICCV 2015 (red-black); Xu & Tao, CVPR 2019 (eight areas,
/// joint view selection, geometric cost).
/// Departs: planes are stored as inverse depth and its gradient, so that moving a plane to another
/// pixel takes two multiplications.
std::int64_t Sweep(const SweepInputs& inputs, const SweepSettings& settings, PlaneMap* map);

}  // namespace keypose::stereo
