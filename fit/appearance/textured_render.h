// The brightness and the depth of a textured mesh as a view shows it.
#pragma once

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "fit/appearance/grey_pyramid.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// What rays through the pixels' centres meet.
struct TexturedRender {
  ImageT<int> face;  ///< -1 where nothing is hit
  ImageF depth;      ///< z in the camera's frame; infinite where nothing is hit
  ImageF grey;       ///< of the texture; 0 where nothing is hit
};

/// The texture of a mesh, as brightness at several resolutions.
class SurfaceTexture {
 public:
  /// @param mesh     with UVs in [0,1], which must outlive this object; only its faces and UVs are
  ///                 used
  /// @param texture  empty: blank, the same grey everywhere, and no UVs are needed
  SurfaceTexture(const Mesh& mesh, const Image8& texture);
  /// The pyramid level whose texels are nearest to `footprint` in size, for a surface of this area.
  /// @param footprint  size of a pixel on the surface, in the same unit as the area's root
  int LevelFor(double area, double footprint) const;
  bool blank() const { return pyramid_.empty(); }
  float At(int face, double u, double v, int level) const;

 private:
  const Mesh& mesh_;
  GreyPyramid pyramid_;
  double uv_area_ = 0;
};

/// @param points  of the mesh, as `scene` has them
TexturedRender RenderGrey(const PointsX3& points, const FacesX3& faces,
                          const SurfaceTexture& texture, int texture_level, const RayScene& scene,
                          const Pinhole& camera, const Rigid3& camera_from_world);

/// Faces and depth alone; grey stays 0.
TexturedRender RenderShape(const PointsX3& points, const RayScene& scene, const Pinhole& camera,
                           const Rigid3& camera_from_world);

/// Intersection over union of the render's silhouette and a mask of its size.
double Overlap(const TexturedRender& render, const GreyMask& mask);

}  // namespace keypose::fit
