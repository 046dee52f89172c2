// One motion of the figure on the rig, and the matches that agree with it.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "fit/cameras/find_cameras.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// Which of the rig's cameras took each photograph, and how the figure was moved on the rig.
struct RigMotion {
  bool clear = false;         ///< most photographs agree, with most of their matches
  Rigid3 rig_from_template;   ///< from the template's place to the pose's
  std::vector<int> rig_view;  ///< one a photograph; -1: none of the rig's cameras
  std::vector<int> inliers;   ///< one a photograph: matches that agree with its rig camera
  int agreeing = 0;           ///< photographs with a rig camera
};

/// The matches of one photograph, ready for counting.
struct Sightings {
  Pinhole camera;
  PointsX3 places;  ///< on the template
  std::vector<Eigen::Vector2d> pixels;
  double within = 0;  ///< error of an inlier, pixels

  int Inliers(const Rigid3& camera_from_template, std::vector<int>* indices = nullptr) const;
};

/// One a photograph, of features and picks.
std::vector<Sightings> SightingsOf(const Mesh& mesh, const std::vector<FoundCamera>& cameras,
                                   const std::vector<PreparedView>& views);

constexpr int kLeastOnRig = 12;  ///< matches with which a photograph agrees

/// Finds the best rig camera of each photograph under the motion.
/// @return inliers of all photographs
int Assign(const std::vector<Sightings>& sightings, const std::vector<View>& rig,
           RigMotion& motion);

/// The figure's motion improved on the inliers of all photographs.
Rigid3 Improved(const std::vector<Sightings>& sightings, const std::vector<View>& rig,
                const RigMotion& motion);

}  // namespace keypose::fit
