// All masks together as one measure of space: how far outside of the object's outlines a place
// lies, finer than any grid.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "views/hull/mask_field.h"
#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

class Silhouettes {
 public:
  /// @param outside_votes  as of VisualHullOptions: so many views have to see a place outside for
  /// it to count as outside
  Silhouettes(const std::vector<PreparedView>& views, int outside_votes);

  /// Where a view sees a place.
  struct Sighting {
    bool seen = false;     ///< before the camera and within the photograph
    double distance = 0;   ///< to the mask's rim, pixels of level 0; positive outside; exact within
                           ///< a few pixels of the rim
    double footprint = 0;  ///< world length of a pixel there
  };
  Sighting See(int view, const Eigen::Vector3d& x) const;

  /// The outside_votes-th largest distance over the views [px]: positive outside of the hull, zero
  /// on it, and continuous. Places that fewer than two views see are far outside. With `without` >=
  /// 0 that view is not asked.
  double Outside(const Eigen::Vector3d& x, int without = -1) const;
  /// Outside(x) <= limit_px, with fewer questions.
  bool Within(const Eigen::Vector3d& x, double limit_px) const;

  /// The unit normal, pointing outside, of the plane through the camera and the mask's outline
  /// nearest to where the view sees x; zero where the outline has no direction.
  Eigen::Vector3d OutlineNormal(int view, const Eigen::Vector3d& x) const;

  int views() const { return static_cast<int>(fields_.size()); }
  const MaskField& field(int view) const { return fields_[view]; }
  int outside_votes() const { return votes_; }

 private:
  double DistanceAt(int view, double x, double y) const;

  std::vector<MaskField> fields_;
  int votes_ = 1;
};

/// World length of a pixel of level 0 at the hull's middle, the median over the views.
double MiddleFootprint(const VisualHull& hull, const Silhouettes& silhouettes);

/// Points of the hull's surface, one near each surface voxel, put exactly where Outside is zero,
/// with outward normals.
/// @param hull  carved from the same views with a margin, so that it holds the exact hull
PointCloud ExactHullSurface(const VisualHull& hull, const Silhouettes& silhouettes);

/// How well each mask agrees with the object that all masks together allow.
struct HullCheck {
  std::vector<double> iou;  ///< for each view, the mask against the reprojected hull
  /// names of the views below `least_iou` and below the median view by 0.005
  std::vector<std::string> disagreeing;
  double mean = 0;
};

/// Overlap of each mask with the picture of the hull; a wrong camera (principal point, a rotated
/// photograph) or a wrong mask shows here, where the reprojection error of features does not see
/// it.
///
/// @param hull  carved from the same views with a margin, so that it holds the exact hull
/// Cost: about 5,000 rays a view, each until its first place inside. The rays are exact: the grid
/// only bounds them.
HullCheck CheckAgainstHull(const std::vector<PreparedView>& views, const VisualHull& hull,
                           const Silhouettes& silhouettes, double least_iou = 0.985);

}  // namespace keypose
