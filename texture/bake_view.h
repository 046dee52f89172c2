// One photograph made ready for baking: what the camera sees of the mesh, how far that is from an edge, and colours at any scale.
#pragma once

#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/ray_scene.h"
#include "core/render.h"

namespace keypose::texture {

/// Pixels of one view as they come from the disk.
struct Photograph {
  Image8 image;          ///< 3 channels, of the view's camera size
  Image8 mask;           ///< 1 channel, above 127 is object; empty: everything is object
  double sharpness = 0;  ///< any unit, comparable between the views; 0 when unknown
};

struct BakeViewOptions {
  double edge_guard_px = 2;     ///< nearer than this to a mask, depth or image edge nothing is seen
  double edge_feather_px = 10;  ///< over this width beyond the guard the trust rises from 0 to 1
  double pixels_per_texel = 4;  ///< the stored photograph is halved while it has more pixels a texel than this
  double texels = 1e6;          ///< texels of the atlas that one view may fill
  int depth_rays = 200000;      ///< at most about this many rays for the depth map
};

/// A colour in linear light with the share of object pixels under it.
struct Sample {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  ///< linear RGB in [0,1]
  float alpha = 0;                                  ///< 0: no object pixel there
};

/// Where a camera sees a point of the surface.
struct Sighting {
  Eigen::Vector2d pixel;  ///< of the original photograph
  double depth = 0;       ///< z in the camera's frame
  float trust = 0;        ///< in [0,1]; 0 means hidden, outside the mask, or on an edge
};

/// Immutable once built; all queries are safe from many threads.
class BakeView {
 public:
  /// @throws InputError  the photograph or its mask is not of the camera's size
  BakeView(const View& view, const Photograph& photograph, const Mesh& mesh, const RayScene& scene, const BakeViewOptions& options);

  const View& view() const { return view_; }
  const Eigen::Vector3d& center() const { return center_; }
  double sharpness() const { return sharpness_; }
  bool sees_nothing() const { return box_.empty(); }

  /// Whether and where the camera sees a point of the mesh: by the depth map, the mask, and the distance to their edges.
  Sighting See(const Eigen::Vector3d& x_in_world) const;
  /// Colour at a pixel of the photograph, averaged over about 2^level of the photograph's pixels each way. Background never bleeds in.
  Sample ColorAt(const Eigen::Vector2d& pixel, double level) const;
  /// Trust in a place of the surface that projects to `pixel` at `depth`; 0 where something is in front of it.
  float TrustAt(const Eigen::Vector2d& pixel, double depth) const;

  /// What the photograph shows finer than 8 pixels of a stored level and coarser than one: luma, square root of linear light, 1 channel.
  /// Not a number where the mask leaves nothing.
  ImageF Detail(int level) const;
  /// The same place in the picture of a stored level, whose pixels are `scale` of the photograph's (at most 1).
  struct Stored {
    Eigen::Vector2d pixel;
    double scale;
  };
  Stored StoredAt(int level, const Eigen::Vector2d& pixel) const {
    const double scale = 1.0 / (1 << (base_level_ + level));
    return {scale * (pixel - Eigen::Vector2d(box_.x0, box_.y0)), scale};
  }

  /// The grid of depth rays over what the mesh covers: its size, the pixel (of the photograph) of a ray, whether the ray meets the mesh
  /// inside the mask beyond the guard along edges, and the pyramid's level on which a ray is a pixel.
  int rays_wide() const { return depth_.width; }
  int rays_high() const { return depth_.height; }
  Eigen::Vector2d RayPixel(int x, int y) const { return {(cell_x0_ + x + 0.5) * cell_px_, (cell_y0_ + y + 0.5) * cell_px_}; }
  bool RayIsGood(int x, int y) const { return *trust_.at(x, y) > 0; }
  double RayLevel() const;

 private:
  void BuildPyramid(const Photograph& photograph, const BakeViewOptions& options);
  void BuildDepth(const Photograph& photograph, const RayScene& scene, const BakeViewOptions& options);
  void MarkEdges(const Photograph& photograph, const BakeViewOptions& options);
  Sample Bilinear(int level, const Eigen::Vector2d& pixel) const;
  float Trust(const Eigen::Vector2d& cell) const;

  View view_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d center_;
  double sharpness_ = 0;
  PixelBox box_;                ///< of the photograph: what is stored
  int base_level_ = 0;          ///< levels dropped at the fine end
  std::vector<Image8> levels_;  ///< 4 channels: sRGB and alpha; level i is of 2^(base_level + i) pixels
  double cell_px_ = 1;          ///< photograph pixels a depth ray, each way
  double cells_per_px_ = 1;     ///< its inverse
  double depth_step_ = 0;       ///< what lies further behind the depth map than this part of its depth is hidden
  int cell_x0_ = 0, cell_y0_ = 0;
  ImageF depth_;
  ImageF trust_;
};

/// Linear light in [0,1] of an 8-bit sRGB value, and back.
float LinearOf(std::uint8_t srgb);
std::uint8_t SrgbOf(float linear);

}  // namespace keypose::texture
