// The face that each sample of a picture sees, found face by face instead of ray by ray: many times
// faster where faces are small and samples many.
#pragma once

#include <optional>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose {

/// A mesh projected for scan conversion. Refers to the faces, which must outlive it.
///
/// Every pixel has the same pattern of samples. Both sides of a face are seen, and a sample on an
/// edge sees one of the edge's faces, so that a closed surface has no holes. Same bits for any
/// thread count.
class ScanConversion {
 public:
  /// @param pattern  where in a pixel its samples lie, in [0, 1)
  /// @return  nothing where only rays can tell: the camera is distorted, or a vertex is beside or
  /// behind it or not finite
  static std::optional<ScanConversion> Of(const PointsX3& points, const FacesX3& faces,
                                          const View& view, std::vector<Eigen::Vector2d> pattern);

  /// What the samples of some pixels hit.
  ///
  /// @param places  by pixel of the box, row by row: its place in `hits`, 0 to the number of wanted
  ///                pixels less one; below 0: not wanted. Empty: all are, in their order
  /// @param hits    by place and by sample; the distance is z in the camera's frame. Where samples
  ///                tie, the first face is hit
  void Fill(const PixelBox& box, const std::vector<int>& places,
            std::vector<RayScene::Hit>& hits) const;

 private:
  struct Corner {
    double x = 0, y = 0, inverse_depth = 0;  ///< px, px, 1 over the unit of the points
  };
  struct Face;
  class Filling;

  explicit ScanConversion(const FacesX3& faces) : faces_(&faces) {}
  void FillBands();

  const FacesX3* faces_;
  std::vector<Eigen::Vector2d> pattern_;
  std::vector<Corner> corners_;          ///< one per vertex
  std::vector<std::vector<int>> bands_;  ///< faces by the band of rows that they reach, ascending
  int width_ = 0, height_ = 0;           ///< px
};

}  // namespace keypose
