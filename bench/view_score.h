// How well a coloured mesh reproduces a photograph: compares its silhouette with the mask and its
// render with the pixels.
#pragma once

#include "bench/textured_mesh.h"
#include "core/pictures/image_quality.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::bench {

/// Compares the pixels of a mask with the pixels whose centre ray meets the mesh. A ratio with
/// denominator 0 is 1 if both sets are empty, else 0.
struct Silhouette {
  long both = 0, mask_only = 0, mesh_only = 0;
  double Iou() const;
  double Precision() const;  ///< share of the mesh's pixels that are in the mask
  double Recall() const;     ///< share of the mask's pixels that the mesh covers
};

/// @param mask     1 channel, object where >= 128
/// @param covered  1 channel, mesh where not 0
/// @throws InputError  sizes differ
Silhouette CompareSilhouettes(const Image8& mask, const Image8& covered);

/// 255 where the ray through a pixel's centre meets the mesh. Applies the lens distortion.
Image8 CoveredPixels(const TexturedMesh& mesh, const RayScene& scene, const View& view);

/// An unlit render of the mesh.
struct ColorRender {
  ImageF
      /// 3 channels, sRGB 0..255: sum over the samples that meet the mesh / number of all samples
      color;
  ImageF covered;  ///< 1 channel, share of the samples that meet the mesh
};
/// @param samples  rays per pixel and axis @pre mesh.colored()
ColorRender RenderColors(const TexturedMesh& mesh, const RayScene& scene, const View& view,
                         int samples);

/// Differences inside the mask of the photograph, 8-bit sRGB. Pixels that the mesh does not fill
/// show the background: the median colour of the photograph outside its mask, per channel (black if
/// the mask fills the picture).
struct ColorScore {
  long pixels = 0;             ///< in the mask
  double psnr_db = 0;          ///< over pixels and channels, at most 99
  double ssim = 0;             ///< of the luma, see Ssim
  double gain[3] = {1, 1, 1};  ///< factor on the render's sRGB values, least squares over masked
                               ///< pixels that the mesh fills
  double gained_psnr_db = 0;   ///< after the gain, with values clipped at 255
  double gained_ssim = 0;
  /// as gained_psnr_db, but only over masked pixels that the mesh fills: the error of the texture
  /// alone
  double filled_psnr_db = 0;
};
/// @throws InputError  sizes differ
ColorScore CompareColors(const Image8& photograph, const Image8& mask, const ColorRender& render);

/// The render over `background`, rounded. `gain` is a factor on each channel of the mesh's colours.
Image8 Composed(const ColorRender& render, const Eigen::Vector3d& background,
                const Eigen::Vector3d& gain = Eigen::Vector3d::Ones());
Eigen::Vector3d BackgroundColor(const Image8& photograph, const Image8& mask);

/// Mean structural similarity (core/pictures/image_quality.h) of two RGB images' luma over the
/// masked pixels.
/// @return 1 for an empty mask @throws InputError sizes differ
double Ssim(const Image8& a, const Image8& b, const Image8& mask);

}  // namespace keypose::bench
