// How well photographs agree with a limb, drawn in colour before the rest of the figure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// A view reduced for drawing many poses: its colours and its mask.
struct SmallPicture {
  View view;      ///< of the reduced picture, in the mesh's frame
  ImageF colors;  ///< RGB, 0..255
  Image8 mask;    ///< 1 inside
};
/// @param camera_from_world  in the mesh's frame
/// @param radius_px          the size that a length of 1 at the world's origin is to have at most
SmallPicture MakeSmallPicture(const PreparedView& view, const Rigid3& camera_from_world,
                              double radius_px);

/// Colours of the vertices, V x 3, RGB 0..255: the mean of the texture around each.
/// @param mesh  with UVs
Eigen::MatrixX3f VertexColors(const Mesh& mesh, const Image8& texture);

/// How far the pictures disagree with a limb. A pixel counts 1 where mask and figure differ, and
/// less where colours do [px].
struct LimbCost {
  double all = 0;      ///< of all pixels, also of the rest of the figure
  double pixels = 0;   ///< that show the limb
  double wrong = 0;    ///< of these
  double missing = 0;  ///< pixels near the limb that are in the mask, but show nothing
};

/// One limb in all views, everything else drawn once.
class LimbPictures {
 public:
  /// Pictures and colours must outlive it.
  /// @param points  V x 3, of the whole figure
  /// @param limb    V: 1 for the limb's vertices
  LimbPictures(const std::vector<SmallPicture>& pictures, const FacesX3& faces,
               const Eigen::MatrixX3f& colors, const PointsX3& points,
               const std::vector<char>& limb);

  /// @param points  V x 3; only those of the limb's faces are used
  LimbCost Of(const PointsX3& points) const;

 private:
  struct Still {
    ImageF depth;  ///< infinite where nothing is
    ImageF cost;
    double sum = 0;
    Eigen::Array3f gain = Eigen::Array3f::Ones();  ///< photograph over texture
  };
  Still DrawRest(const SmallPicture& picture, const PointsX3& points, const FacesX3& faces) const;
  float CostOf(const SmallPicture& picture, const Still& still, std::size_t pixel,
               const Eigen::Array3f& color) const;
  void AddPicture(int picture, const PointsX3& points, LimbCost& cost) const;

  const std::vector<SmallPicture>& pictures_;
  const Eigen::MatrixX3f& colors_;
  std::vector<int> vertices_;  // of the limb's faces
  FacesX3 faces_;              // of the limb, into vertices_
  Eigen::MatrixX3f limb_colors_;
  std::vector<Still> still_;
};

}  // namespace keypose::fit
