// Renders meshes, for reports, previews and tests. Also depth and face maps of a
// view.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "core/pictures/fit_view.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

/// The first hit of each pixel's centre ray.
struct Raster {
  ImageT<int> face;  ///< 1 channel; -1 where nothing is hit
  ImageF depth;      ///< 1 channel; z in the camera's frame, +inf where nothing is hit
};
/// Respects the camera's distortion. Rays are only cast within the projected bounds of the mesh.
Raster Rasterize(const Mesh& mesh, const RayScene& scene, const View& view);

enum class ColorMap { kViridis, kHeat, kDiverging };
/// @param t  clamped to [0,1]; NaN gives grey
Eigen::Matrix<std::uint8_t, 3, 1> MapColor(double t, ColorMap map = ColorMap::kViridis);
/// One colour for each value: `lowest` becomes t = 0, `highest` t = 1.
ColorsX3 MapColors(const Eigen::VectorXd& values, double lowest, double highest,
                   ColorMap map = ColorMap::kViridis);

struct RenderOptions {
  const Image8* texture = nullptr;  ///< used when the mesh has UVs; replaces colours
  ColorsX3 vertex_colors;           ///< V x 3; when empty the mesh's own colours
  ColorsX3 face_colors;             ///< F x 3; replaces vertex colours
  bool plain = false;               ///< clay grey; colours are ignored
  bool smooth = true;               ///< interpolated normals, else one per face
  double shading = 1;  ///< 0: colours as they are; 1: fully lit by two lamps beside the camera
  bool wireframe = false;
  int samples = 3;  ///< rays per pixel along each axis
  Eigen::Matrix<std::uint8_t, 3, 1> background = {246, 247, 249};
};

/// A picture of the mesh with the size of the camera's image.
/// Same bits for any thread count.
///
/// @param scene  built from mesh.points and mesh.faces
/// @throws InputError  the number of colours is not that of the vertices or faces
Image8 Render(const Mesh& mesh, const RayScene& scene, const View& view,
              const RenderOptions& options = {});
Image8 Render(const Mesh& mesh, const View& view, const RenderOptions& options = {});

/// The mesh without a background: 4 channels, straight alpha, which is the share of the pixel that
/// the mesh covers; all zero where it covers nothing. Pixels on an outline, also of a part in front
/// of another, are sampled 32 times, others options.samples^2 times. options.background is unused.
/// Same bits for any thread count. Throws like Render.
Image8 RenderCutout(const Mesh& mesh, const RayScene& scene, const View& view,
                    const RenderOptions& options = {});

/// Bilinear colour of a texture at (u right, v up). Coordinates outside [0,1] are clamped. The
/// texture has 1 or 3 channels.
Eigen::Vector3d SampleTexture(const Image8& texture, const Eigen::Vector2d& uv);

/// A contact sheet: images in rows of `columns` cells on `background`. All cells have the size of
/// the largest image. RGB; grey images become RGB.
/// @throws InputError  no images, or columns < 1
Image8 TileImages(const std::vector<Image8>& images, int columns, int gap = 4,
                  Eigen::Matrix<std::uint8_t, 3, 1> background = {255, 255, 255});

}  // namespace keypose
