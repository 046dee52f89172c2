// The texels of an atlas that lie on the surface, as a list, and where they are in a pose.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/mesh.h"
#include "views/atlas/atlas.h"

namespace keypose::motion {

struct SurfaceTexels {
  std::vector<int> texel;                ///< index in the atlas, ascending
  std::vector<int> face;                 ///< of the mesh
  std::vector<Eigen::Vector3f> weights;  ///< barycentric

  int count() const { return static_cast<int>(texel.size()); }
};
SurfaceTexels ListTexels(const Atlas& atlas);

/// Colours of the listed texels: what pictures show, and how well.
struct TexelColors {
  std::vector<std::uint8_t> color;  ///< N x 3, sRGB
  std::vector<std::uint8_t> sure;   ///< N; 255: seen well, 0: not seen
};

/// Weighted mean of three vertices' values (rows).
inline Eigen::Vector3f MeanOfCorners(const Eigen::Matrix<float, Eigen::Dynamic, 3>& values,
                                     const FacesX3& faces, int face, const Eigen::Vector3f& w) {
  return (w[0] * values.row(faces(face, 0)) + w[1] * values.row(faces(face, 1)) +
          w[2] * values.row(faces(face, 2)))
      .transpose();
}

}  // namespace keypose::motion
