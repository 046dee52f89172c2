// A textured mesh compared with a picture, grey value by grey value.
#pragma once

#include <vector>

#include "composite/locating/lens/normal_equations.h"
#include "composite/locating/outline/mesh_silhouette.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::composite {

/// Brightness of a texture at halved resolutions.
class GreyTexture {
 public:
  /// @param mesh     with UVs in [0,1]; must outlive this object
  /// @param texture  RGB or grey
  /// @throws InputError  no UVs
  GreyTexture(const Mesh& mesh, const Image8& texture);
  float At(int face, double u, double v, int level) const;
  /// The level whose texels are about as large as a pixel on a surface of this area.
  /// @param footprint  of a pixel on the surface, in the unit of the area's root
  int LevelFor(double area, double footprint) const;

 private:
  const Mesh& mesh_;
  std::vector<ImageF> levels_;
  double uv_area_ = 0;
};

/// Brightness of a picture, 0 to 255.
ImageF LumaOf(const Image8& picture);

/// How well grey values agree, and where they ask the mesh to move.
struct GreyMatches {
  struct Match {
    Eigen::Vector3d position;  ///< on the mesh
    Eigen::Vector2d gradient;  ///< of the normalised picture, per pixel
    double difference = 0;     ///< that its move should make up
  };
  std::vector<Match> matches;
  double correlation = 0;  ///< of the normalised pictures, -1 to 1; 0 when nothing is seen
  double deviation = 0;    ///< of their difference, robust
};

/// Draws the mesh and compares it with the picture where both are surely inside of the figure. Both
/// are normalised by mean and deviation of windows of 15 pixels, which removes light and shade.
///
/// @param luma  of the camera's size
/// @param matte  where the figure is, or empty: everywhere
/// Same bits for any thread count.
GreyMatches MatchGreys(const Figure& figure, const GreyTexture& texture, const ImageF& luma,
                       const Image8& matte, const Placement& at);

}  // namespace keypose::composite
