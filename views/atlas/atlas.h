// The atlas as a grid of surface points, and operations on its colours where no photograph shows
// the surface.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

/// A face's corners in texel units, y down.
struct TexelTriangle {
  Eigen::Vector2d p[3];
  double twice_area = 0;

  Eigen::Vector3d Barycentric(const Eigen::Vector2d& q) const;
  /// Barycentric weights of the point of the triangle's outline closest to q; also returns the
  /// squared distance to it.
  Eigen::Vector3d ClosestOnOutline(const Eigen::Vector2d& q, double& squared_distance) const;
};

/// The surface point of each texel. Texel (x, y), top row first, has its centre at u = (x + .5) /
/// size, v = 1 - (y + .5) / size.
struct Atlas {
  int size = 0;
  std::vector<int> face;     ///< size^2; -1: no surface
  std::vector<char> inside;  ///< size^2; 1: the texel's centre is in a triangle; 0: at most a texel
                             ///< outside (a chart's border), or no surface
  std::vector<TexelTriangle> triangles;  ///< one per face
  std::int64_t texels = 0;               ///< with centres in a triangle

  /// Barycentric weights of the texel's point on face[texel]; only valid where there is surface.
  /// Not stored, because they would need most of the memory.
  Eigen::Vector3f Weights(std::size_t texel) const;
};

/// @throws InputError  no UVs, a UV index out of range, a UV outside [0,1]
void CheckUvs(const Mesh& mesh);

/// Where triangles overlap, the lowest face is used. Border texels have the closest point of the
/// closest triangle.
/// @throws InputError  as CheckUvs, or no texel centre is covered
Atlas RasterizeAtlas(const Mesh& mesh, int size);

/// The box of a face's texels, border included; x1, y1 are one beyond the last.
struct TexelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
TexelBox TexelsAround(const Atlas& atlas, int face);

/// Colours of an atlas in linear light during painting.
struct Painting {
  ImageF color;                    ///< RGB
  std::vector<std::uint8_t> sure;  ///< size^2; confidence of the photographs' colour, at most 255;
                                   ///< 0: not from photographs

  explicit Painting(int size = 0)
      : color(size, size, 3), sure(static_cast<std::size_t>(size) * size, 0) {}
  Eigen::Map<Eigen::Vector3f> At(std::size_t texel) {
    return Eigen::Map<Eigen::Vector3f>(color.data.data() + 3 * texel);
  }
  Eigen::Map<const Eigen::Vector3f> At(std::size_t texel) const {
    return Eigen::Map<const Eigen::Vector3f>(color.data.data() + 3 * texel);
  }
};

/// Colours of the mesh's vertices in linear light, where known.
struct VertexColors {
  std::vector<Eigen::Vector3f> color;
  std::vector<float> sure;  ///< in [0, 1]
};
/// Means over the painted texels around each vertex, across the seams of charts.
VertexColors ReadVertices(const Mesh& mesh, const Atlas& atlas, const Painting& painting);

/// Paints surface texels that no photograph shows. Confident colours spread over the surface (not
/// over the atlas) by heat diffusion, through the seams of charts but hardly between different
/// hues. The fine detail at the border of the seen part fades out over a few texels. Painted texels
/// stay; texels with little confidence are mixed with the colours around.
void InpaintUnseen(const Mesh& mesh, const Atlas& atlas, Painting& painting);

/// The picture in linear light, RGB: `gutter` texels around each chart continue its colours; all
/// other texels have the mean colour. The painting's memory is reused.
ImageF FinishTexture(const Atlas& atlas, Painting&& painting, int gutter);

/// As 8-bit sRGB.
Image8 SrgbImage(const ImageF& linear);

}  // namespace keypose
