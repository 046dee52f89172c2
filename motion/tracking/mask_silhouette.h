// What a camera shows of the actor in one frame: a reduced mask without lens distortion, the signed
// distance to its outline, and points on the outline.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "views/hull/mask_field.h"

namespace keypose::motion {

/// A camera that does not move, prepared for many frames.
class SilhouetteCamera {
 public:
  /// @param view   in metres; its size is that of the masks
  /// @param scale  of the reduced picture over the mask, in (0, 1]
  SilhouetteCamera(const View& view, double scale);

  const View& view() const { return view_; }
  const Pinhole& pinhole() const { return pinhole_; }  ///< of the reduced, whole picture
  /// The mask in the reduced picture: 1 inside, 0 outside.
  /// @throws InputError  a mask of another size; names the camera
  Image8 Reduced(const Image8& mask) const;

 private:
  View view_;
  Pinhole pinhole_;
  /// Pixels of the mask that a reduced pixel looks at, four each; -1: none.
  std::vector<int> source_;
  struct Range {
    int low = 1 << 30, high = -1;
  };
  std::vector<Range> rows_, columns_;  ///< of the mask, that a reduced row or column looks at
};

/// One frame of one camera. Pixels are those of a crop of the reduced picture.
struct Silhouette {
  struct Point {
    Eigen::Vector2d pixel, normal;  ///< on the outline; unit, outwards
  };
  int camera = 0;
  Pinhole pinhole;           ///< of the crop
  Rigid3 camera_from_world;  ///< metres
  Eigen::Vector3d center;    ///< of the camera
  MaskField field;           ///< of the crop
  std::vector<Point> outline;
  double outline_step = 1;  ///< length of the outline that a point stands for [px]
  std::int64_t pixels = 0;  ///< in the mask

  bool empty() const { return pixels == 0; }
  /// Signed distance [px], positive outside, and its gradient. Beyond the crop the way to it is
  /// added.
  double Distance(const Eigen::Vector2d& pixel, Eigen::Vector2d* gradient = nullptr) const;
  /// Whether the pixel is near a side of the picture that the mask touches: the outline is cut
  /// there.
  bool Cut(const Eigen::Vector2d& pixel) const;
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_world) const {
    return pinhole.Project(camera_from_world * x_in_world);
  }
  /// w with w^T dX = n^T d(pixel) for a point X in the world.
  Eigen::Vector3d Pull(const Eigen::Vector3d& x_in_world, const Eigen::Vector2d& n) const;
};

/// @param reduced  of SilhouetteCamera::Reduced; may hold nothing
/// @param points   about so many on the outline
Silhouette MakeSilhouette(const SilhouetteCamera& camera, int index, const Image8& reduced,
                          int points);

}  // namespace keypose::motion
