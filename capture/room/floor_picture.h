// What the plane under the figure looks like, from all photographs that show it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "capture/room/coarse_depths.h"
#include "capture/room/standing_figure.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct FloorPictureOptions {
  double cell = 0.003;  ///< of the cameras' distance
  double reach = 0.35;  ///< of that distance: half of the picture's side
  int fewest = 3;       ///< photographs that show a cell
};

/// The plane's picture, seen from above.
class FloorPicture {
 public:
  /// Each cell has the median colour of the photographs in which a depth lies on the plane there.
  /// @param images  RGB, by view, of the size that the views' cameras have
  FloorPicture(const std::vector<Image8>& images, const std::vector<View>& views,
               const CoarseDepths& depths, const StandingFigure& figure,
               const FloorPictureOptions& options = {});

  /// What a photograph would show if nothing stood on the plane.
  /// @return RGB; black where the plane's picture is unknown
  Image8 SeenBy(const View& view) const;

 private:
  struct Place {
    double x = 0, y = 0;  ///< in cells
    bool known = false;
  };
  Place PlaceOf(const View& view, double x, double y) const;

  Support support_;
  Eigen::Vector3d origin_, along_x_, along_y_;  ///< of cell (0, 0); steps of one cell
  Image8 colours_, known_;
};

enum Likeness : std::uint8_t { kNotFloor, kPerhapsFloor, kSurelyFloor };

/// How like the plane's picture a photograph is, pixel by pixel, in light or in shadow: windows of
/// one pattern, or of one colour where there is no pattern.
/// @return Likeness, kNotFloor where it is unknown
Image8 LikeFloor(const Image8& image, const Image8& floor);

}  // namespace keypose::capture
