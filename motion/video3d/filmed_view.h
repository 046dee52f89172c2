// One camera's picture in one frame, ready to be asked what it shows of the moving mesh.
#pragma once

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "motion/video3d/depth_view.h"

namespace keypose::motion {

struct FilmedViewOptions {
  double erosion_px = 2;  ///< pixels closer to an edge of mesh, mask or depth are not used
  double feather_px = 6;  ///< over which trust then rises to 1
};

/// What a camera shows at a point of the surface.
struct Sighting {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  ///< linear light, RGB in [0, 1]
  float trust = 0;   ///< 0: hidden, outside of the mask, or at an edge; 1: far from edges
  float facing = 0;  ///< cosine between the surface's normal and the way to the camera, or 0
};

class FilmedView {
 public:
  /// @param picture  RGB, of the camera's size; empty: the camera has no such frame, it sees
  /// nothing
  /// @param mask     1 channel of the same size, over 127 is the actor; empty: all is
  /// @param points   the mesh in this frame, in world
  FilmedView(const View& view, const Image8& picture, const Image8& mask, const PointsX3& points,
             const FacesX3& faces, const FilmedViewOptions& options);

  /// Thread-safe.
  Sighting See(const Eigen::Vector3f& x_in_world, const Eigen::Vector3f& normal) const;

  bool sees_nothing() const { return color_.empty(); }
  /// Of the pixels that the mesh covers: the share that the mask has too; 1 without mask.
  double covered_by_mask() const { return covered_; }
  int pixels() const { return pixels_; }  ///< that the mesh covers

 private:
  void CropPicture(const Image8& picture);
  void MeasureTrust(const Image8& mask, const FilmedViewOptions& options);
  Eigen::Vector3f Color(const Eigen::Vector2d& at) const;

  View view_;
  Eigen::Vector3d center_;
  DepthView depth_;
  ImageF color_;  // 3 channels, of depth_.box
  ImageF trust_;  // 1 channel, of depth_.box
  double covered_ = 1;
  int pixels_ = 0;
};

/// Distance in pixels from each pixel that is not an edge to the nearest one that is, at most
/// `most` (two passes with steps 1 and sqrt 2); what lies outside of the picture is no edge.
ImageF DistanceToEdges(const Image8& edges, float most);

}  // namespace keypose::motion
