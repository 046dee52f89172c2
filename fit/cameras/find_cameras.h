// Where the photographs of a pose were taken from.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "views/placement/surface_features.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

struct FoundCamera {
  bool found = false;
  Rigid3 camera_from_world;            ///< the world is the template's frame
  int inliers = 0;                     ///< matches that agree with it
  double rms_px = 0;                   ///< of these
  std::vector<FeatureMatch> matches;   ///< all matches of the photograph, also on moved limbs
  std::vector<FeatureMatch> agreeing;  ///< of these, those that one rigid part can explain
  std::vector<FeatureMatch> picks;     ///< what a person picked in it
};

/// Its picks, as often as they count beside features.
std::vector<FeatureMatch> CountedPicks(const FoundCamera& camera);

/// Features and picks of a photograph, the picks as often as they count.
std::vector<FeatureMatch> AllMatches(const FoundCamera& camera);

/// Each photograph by itself: the pose of the camera that agrees with most matches between the
/// photograph and the textured template. The part of the figure that moved least with respect to
/// the others decides; moved limbs are outliers.
///
/// @param mesh      the template
/// @param features  null: the template has no texture, and picks alone find cameras
/// @param views     prepared photographs; their poses are not used
/// @param picks  of each photograph, what a person picked; each counts as several features
/// Same bits for any thread count.
std::vector<FoundCamera> FindCameras(const Mesh& mesh, const SurfaceFeatures* features,
                                     const std::vector<PreparedView>& views,
                                     const std::vector<std::vector<FeatureMatch>>& picks,
                                     Progress* progress = nullptr);

/// Marks cameras as not found that few matches agree with, if three or more are sure.
/// They may be those of another part of the figure, which bent away.
/// @return whether there were such cameras
bool KeepSureCameras(std::vector<FoundCamera>& cameras);

}  // namespace keypose::fit
