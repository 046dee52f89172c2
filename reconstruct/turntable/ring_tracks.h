// Points of a ring model from matches that agree with it.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// A point's features, one per image.
struct Track {
  struct Element {
    int image = 0;
    std::uint32_t feature = 0;
  };
  std::vector<Element> elements;  ///< by image
};

/// Features connected by matches, directly or through other images. If a track has two features of
/// one image, both are dropped.
/// @return tracks of at least two images, in order of their first feature
std::vector<Track> BuildTracks(const std::vector<PairMatches>& matches,
                               const std::vector<Features>& features);

struct TriangulationOptions {
  double min_angle_deg = 1.5;  ///< least angle between some two rays
  double max_error_px = 6;
};

struct Triangulated {
  Scene scene;  ///< the given views and the triangulated points, without colours
  std::vector<Observation> observations;
};

/// Triangulates the rays of each track. Features with larger errors are removed from their track,
/// and tracks of fewer than two are dropped.
///
/// @param scene     views; points are ignored
/// @param view_of_image  index into scene.views, or -1
Triangulated Triangulate(const Scene& scene, const std::vector<int>& view_of_image,
                         const std::vector<Track>& tracks, const std::vector<Features>& features,
                         const TriangulationOptions& options);

}  // namespace keypose::reconstruct
