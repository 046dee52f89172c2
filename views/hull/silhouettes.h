// All masks combined into one distance in space: how far outside of the figure's outlines a point
// is, more accurate than any grid.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"
#include "views/hull/mask_field.h"
#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

class Silhouettes {
 public:
  /// @param outside_votes  as in VisualHullOptions: a point is outside when at least this many
  /// views see it outside
  Silhouettes(const std::vector<PreparedView>& views, int outside_votes);

  /// The projection of a point into a view.
  struct Sighting {
    bool seen = false;     ///< in front of the camera and within the photograph
    double distance = 0;   ///< to the mask's border, pixels of level 0; positive outside; exact
                           ///< within a few pixels of the border
    double footprint = 0;  ///< size of a pixel at the point, in world units
  };
  Sighting See(int view, const Eigen::Vector3d& x) const;

  /// The outside_votes-th largest distance over the views [px]: positive outside of the hull, zero
  /// on it, and continuous. Points that fewer than two views see are far outside. A view `without`
  /// >= 0 is ignored.
  double Outside(const Eigen::Vector3d& x, int without = -1) const;
  /// Outside(x) <= limit_px, with fewer projections.
  bool Within(const Eigen::Vector3d& x, double limit_px) const;

  /// The unit normal, pointing outwards, of the plane through the camera and the mask's outline
  /// nearest to the projection of x; zero where the outline has no direction.
  Eigen::Vector3d OutlineNormal(int view, const Eigen::Vector3d& x) const;

  int views() const { return SizeOf(fields_); }
  const MaskField& field(int view) const { return fields_[view]; }
  int outside_votes() const { return votes_; }

 private:
  double DistanceAt(int view, double x, double y) const;

  std::vector<MaskField> fields_;
  int votes_ = 1;
};

/// Size of a pixel of level 0 at the hull's centre in world units, the median over the views.
double MiddleFootprint(const VisualHull& hull, const Silhouettes& silhouettes);

/// Points of the hull's surface, one per surface voxel, moved to where Outside is zero, with
/// outward normals.
/// @param hull  carved from the same views with a margin, so that it contains the exact hull
PointCloud ExactHullSurface(const VisualHull& hull, const Silhouettes& silhouettes);

/// Agreement of each mask with the visual hull of all masks.
struct HullCheck {
  std::vector<double> iou;  ///< for each view, the mask against the reprojected hull
  /// names of the views below `least_iou` and below the median view by 0.005
  std::vector<std::string> disagreeing;
  double mean = 0;
};

/// Overlap of each mask with the projected hull. It reveals wrong cameras (principal point, a
/// rotated photograph) and wrong masks that the reprojection error of features does not reveal.
///
/// @param hull  carved from the same views with a margin, so that it contains the exact hull
/// Cost: about 5,000 rays per view, each up to its first point inside. The rays are exact: the grid
/// only bounds them.
HullCheck CheckAgainstHull(const std::vector<PreparedView>& views, const VisualHull& hull,
                           const Silhouettes& silhouettes, double least_iou = 0.985);

}  // namespace keypose
