// One photograph prepared for baking: visible surface of the mesh, distances from edges, and
// colours at any scale.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "core/pictures/render.h"
#include "core/pictures/srgb.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/image16.h"
#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose::texture {

/// Pixels of one view, as read from disk.
struct Photograph {
  Image8 image;          ///< 3 channels, of the view's camera size
  Image16 deep;          ///< in place of `image`, where the file has more than 8 bits a channel
  Image8 mask;           ///< 1 channel, above 127 is object; empty: everything is object
  double sharpness = 0;  ///< any unit, comparable between the views; 0 when unknown
};

struct BakeViewOptions {
  double edge_guard_px = 2;     ///< pixels closer to a mask, depth or image edge are not used
  double edge_feather_px = 10;  ///< width beyond the guard over which the trust rises from 0 to 1
  /// the stored photograph is halved while it has more pixels per texel than this
  double pixels_per_texel = 4;
  double texels = 1e6;      ///< number of texels of the atlas that one view may fill
  int depth_rays = 200000;  ///< approximate limit of rays for the depth map
};

/// A colour in linear light with the share of object pixels under it.
struct Sample {
  Eigen::Vector3f color = Eigen::Vector3f::Zero();  ///< linear RGB in [0,1]
  float alpha = 0;                                  ///< 0: no object pixel there
};

/// The projection of a surface point into a camera.
struct Sighting {
  Eigen::Vector2d pixel;  ///< of the original photograph
  double depth = 0;       ///< z in the camera's frame
  float trust = 0;        ///< in [0,1]; 0: occluded, outside the mask, or on an edge
};

/// All queries are thread-safe; Hide and Weigh must come before them.
class BakeView {
 public:
  /// @throws InputError  the photograph or its mask is not of the camera's size
  BakeView(const View& view, const Photograph& photograph, const Mesh& mesh, const RayScene& scene,
           const BakeViewOptions& options);

  const View& view() const { return view_; }
  const Eigen::Vector3d& center() const { return center_; }
  double sharpness() const { return sharpness_; }
  bool sees_nothing() const { return box_.empty(); }

  /// Hides the squares with 255 in a picture of squares; each is `side_px` pixels of the photograph
  /// wide.
  void Hide(const Image8& squares, double side_px);
  /// Sets this view's weight relative to the others; 1 initially.
  void Weigh(float weight) { weight_ = weight; }
  float weight() const { return weight_; }

  /// Projection and visibility of a point of the mesh, from the depth map, the mask, and the
  /// distance to their edges.
  Sighting See(const Eigen::Vector3d& x_in_world) const;
  /// Colour at a pixel of the photograph, averaged over about 2^level of its pixels in each
  /// direction. Background is never included.
  Sample ColorAt(const Eigen::Vector2f& pixel, float level) const;
  /// Trust in a surface point that projects to `pixel` at `depth`; 0 where it is occluded.
  float TrustAt(const Eigen::Vector2f& pixel, float depth) const;

  /// The photograph's detail finer than 8 pixels of a stored level and coarser than one: luma,
  /// square root of linear light, 1 channel. NaN where the mask leaves nothing.
  ImageF Detail(int level) const;
  /// The same point in the picture of a stored level, whose pixels have `scale` times the
  /// resolution of the photograph's (at most 1).
  struct Stored {
    Eigen::Vector2d pixel;
    double scale;
  };
  Stored StoredAt(int level, const Eigen::Vector2d& pixel) const {
    const double scale = 1.0 / (1 << (base_level_ + level));
    return {scale * (pixel - Eigen::Vector2d(box_.x0, box_.y0)), scale};
  }

  /// The grid of depth rays over the mesh's area: its size, a ray's pixel in the photograph, its
  /// direction (z = 1 in the camera's frame), the face that it meets, whether that point is inside
  /// the mask and beyond the guard along edges, and the pyramid's level on which a ray is one
  /// pixel.
  int rays_wide() const { return depth_.width; }
  int rays_high() const { return depth_.height; }
  Eigen::Vector2d RayPixel(int x, int y) const {
    return {(cell_x0_ + x + 0.5) * cell_px_, (cell_y0_ + y + 0.5) * cell_px_};
  }
  Eigen::Vector3d RayInWorld(int x, int y) const;
  int RayFace(int x, int y) const { return *ray_face_.at(x, y); }
  bool RayIsGood(int x, int y) const { return *trust_.at(x, y) > 0; }
  float RayLevel() const;

 private:
  void BuildPyramid(const Photograph& photograph, const BakeViewOptions& options);
  template <class T>
  std::vector<ImageT<T>> Pyramid(const ImageT<T>& image, const Image8& mask,
                                 const BakeViewOptions& options);
  void BuildDepth(const Photograph& photograph, const RayScene& scene,
                  const BakeViewOptions& options);
  void MarkEdges(const Photograph& photograph, const BakeViewOptions& options);
  Sample Bilinear(int level, const Eigen::Vector2f& pixel) const;
  template <class T>
  Sample BilinearOf(const ImageT<T>& image, float scale, const Eigen::Vector2f& pixel,
                    const float* linear) const;
  template <class T>
  ImageF DetailOf(const ImageT<T>& fine, int level, const float* linear) const;
  float Trust(float cell_x, float cell_y) const;

  View view_;
  Eigen::Matrix3d rotation_;
  Eigen::Vector3d center_;
  double sharpness_ = 0;
  float weight_ = 1;
  PixelBox box_;        ///< stored part of the photograph
  int base_level_ = 0;  ///< number of fine levels that are not stored
  /// 4 channels: sRGB and alpha; level i is of 2^(base_level + i) pixels
  std::vector<Image8> levels_;
  std::vector<Image16> deep_levels_;    ///< in place of `levels_`, of a photograph of 16 bits
  const float* deep_linear_ = nullptr;  ///< LinearTable16
  std::vector<float> scales_;           ///< for each level: its pixels per pixel of the photograph
  double cell_px_ = 1;                  ///< photograph pixels per depth ray, in each direction
  float cells_per_px_ = 1;              ///< its inverse
  /// points behind the depth map by more than this share of its depth are occluded
  float depth_step_ = 0;
  int cell_x0_ = 0, cell_y0_ = 0;
  ImageT<Eigen::Vector3d> rays_;  ///< in world, for every 8th ray in each direction; between them
                                  ///< lens distortion is negligible
  ImageT<int> ray_face_;          ///< -1 where the ray meets nothing
  ImageF depth_;
  Image8 trust_;  ///< 255 is 1
};

// Functions that are called for each texel and view.

inline float BakeView::Trust(float cell_x, float cell_y) const {
  const float x = std::clamp(cell_x - 0.5f, 0.0f, static_cast<float>(trust_.width - 1)),
              y = std::clamp(cell_y - 0.5f, 0.0f, static_cast<float>(trust_.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const int right = x0 + 1 < trust_.width, below = y0 + 1 < trust_.height ? trust_.width : 0;
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::uint8_t* t = trust_.at(x0, y0);
  return ((1 - fy) * ((1 - fx) * t[0] + fx * t[right]) +
          fy * ((1 - fx) * t[below] + fx * t[below + right])) *
         (1 / 255.0f);
}

inline float BakeView::TrustAt(const Eigen::Vector2f& pixel, float depth) const {
  const float x = pixel.x() * cells_per_px_ - static_cast<float>(cell_x0_),
              y = pixel.y() * cells_per_px_ - static_cast<float>(cell_y0_);
  if (!(x >= 0 && y >= 0 && x < static_cast<float>(depth_.width) &&
        y < static_cast<float>(depth_.height)))
    return 0;
  const float surface = *depth_.at(static_cast<int>(x), static_cast<int>(y));
  return depth - surface < depth_step_ * depth ? Trust(x, y) : 0;
}

/// @param linear  light of each stored value
template <class T>
Sample BakeView::BilinearOf(const ImageT<T>& image, float scale, const Eigen::Vector2f& pixel,
                            const float* linear) const {
  const float x = std::clamp((pixel.x() - static_cast<float>(box_.x0)) * scale - 0.5f, 0.0f,
                             static_cast<float>(image.width - 1)),
              y = std::clamp((pixel.y() - static_cast<float>(box_.y0)) * scale - 0.5f, 0.0f,
                             static_cast<float>(image.height - 1));
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const float fx = x - static_cast<float>(x0), fy = y - static_cast<float>(y0);
  const std::ptrdiff_t right = x0 + 1 < image.width ? 4 : 0,
                       below = y0 + 1 < image.height ? 4 * image.width : 0;
  const T* first = image.at(x0, y0);
  const T* p[4] = {first, first + right, first + below, first + below + right};
  const float w[4] = {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
  Sample sample;
  for (int k = 0; k < 4; ++k) {
    const float a = w[k] * p[k][3];
    sample.color += a * Eigen::Vector3f(linear[p[k][0]], linear[p[k][1]], linear[p[k][2]]);
    sample.alpha += a;
  }
  if (sample.alpha > 0) sample.color *= 1 / sample.alpha;
  sample.alpha *= 1 / static_cast<float>(std::numeric_limits<T>::max());
  return sample;
}

inline Sample BakeView::Bilinear(int level, const Eigen::Vector2f& pixel) const {
  return deep_levels_.empty()
             ? BilinearOf(levels_[level], scales_[level], pixel, kLinear.data())
             : BilinearOf(deep_levels_[level], scales_[level], pixel, deep_linear_);
}

inline Sample BakeView::ColorAt(const Eigen::Vector2f& pixel, float level) const {
  const int coarsest = SizeOf(scales_) - 1;
  const float stored =
      std::clamp(level - static_cast<float>(base_level_), 0.0f, static_cast<float>(coarsest));
  const int fine = static_cast<int>(stored);
  const float t = stored - static_cast<float>(fine);
  Sample a = Bilinear(fine, pixel);
  if (t < 0.02f || fine == coarsest) return a;
  const Sample b = Bilinear(fine + 1, pixel);
  const float alpha = (1 - t) * a.alpha + t * b.alpha;
  if (alpha > 0) a.color = ((1 - t) * a.alpha * a.color + t * b.alpha * b.color) / alpha;
  a.alpha = alpha;
  return a;
}

}  // namespace keypose::texture
