// Carries the colours of a scan, whose texture or vertices have them, into the atlas of another
// mesh of the same shape.
#pragma once

#include <cstdint>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::texture {

struct ScanBakeOptions {
  int texture_size = 0;  ///< [px]; 0: the advised size
  int gutter = 12;       ///< [px]
  double reach = 0.01;   ///< how far from the mesh the scan may lie [diagonal of the mesh]
};

struct ScanBake {
  ImageF linear;   ///< RGB in linear light, square
  Image8 texture;  ///< the same as 8-bit sRGB
  /// 1 channel: 255 where the scan lies beside the texel, less as it is farther; 0: inpainted, or
  /// no surface
  Image8 confidence;
  int advised_size = 0;          ///< about one texel per texel of the scan's texture
  std::int64_t texels = 0;       ///< of the surface
  std::int64_t seen_texels = 0;  ///< that the scan has a colour for
};

/// For each texel the colour of the closest point of the scan that faces the same way, as the mean
/// over the texel where the scan's texture is finer. Where the scan has a hole or lies too far
/// away, colours are continued from around.
///
/// @param mesh     with UVs in [0,1], in the scan's frame
/// @param scan     with UVs and a texture, or with vertex colours
/// @param texture  RGB, sRGB; empty: the vertex colours
/// @return a texture of one grey, with confidence 0, if the scan has no colours or lies nowhere
/// near
/// @throws InputError  a mesh without UVs, a texture for a scan without UVs
/// Cost: one closest point per texel. Same bits for any thread count.
ScanBake BakeScan(const Mesh& mesh, const Mesh& scan, const Image8& texture,
                  const ScanBakeOptions& options, Progress* progress = nullptr);

}  // namespace keypose::texture
