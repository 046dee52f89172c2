// Reads the picks that tell `fit` where places of the template are in a pose: in its photographs,
// or in space.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/io/project/carry_log.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::fit {

/// A photograph's pixel that shows a place of the template.
struct PhotoPick {
  std::string name;
  SurfacePoint point;                               ///< on the template
  int image = -1;                                   ///< of the image set
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the photograph; (0, 0) is its corner
};

struct PosePicks {
  std::vector<PhotoPick> pixels;
  std::vector<LandmarkGoal> places;   ///< in the frame of the pose's cameras
  std::vector<std::string> unpaired;  ///< names that only one of two files has
  /// "'ear' in a.jpg": picked in another photograph of that name; in a photograph that is gone
  std::vector<std::string> of_another, of_none;
};

/// Reads picks of one pose (docs/file-formats.md). One file: `pixels` and `landmarks` each say
/// their place on the template. Two files: picks of the template (all kinds that ReadPicks takes),
/// and those of the pose, joined by name. Landmarks that were picked on a scan of the pose are left
/// out with a warning: their places are in the scan's frame. Picks that the studio saved say what
/// photograph they were made in, and are left out where that was replaced or is gone.
///
/// @param log  may be null
/// @throws InputError  malformed; no pick; a photograph that `images` does not have, of a pick that
/// says no more of it than its name; a pixel outside of it; a place that the template does not
/// have; the same name twice in one photograph; two files that share no name. Names file, mark and
/// photograph.
PosePicks ReadPosePicks(const std::vector<std::filesystem::path>& paths, const Mesh& mesh,
                        const ImageSet& images, CarryLog* log);

}  // namespace keypose::fit
