// A pose's texture, completed from the other poses' textures in the same layout where its own
// photographs do not show the surface.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/image.h"
#include "core/values/image16.h"
#include "core/values/mesh.h"

namespace keypose::texture {

/// A baked texture, and how well photographs show each of its texels.
struct PoseTexture {
  Image8 texture;     ///< RGB, sRGB, square; empty where there is `deep`
  Image8 confidence;  ///< 1 channel of the same size: 255 seen well, 0 not seen (the texel is then
                      ///< inpainted)
  Image16 deep = {};  ///< in place of `texture`: the same with 16 bits
};

struct Completed {
  ImageF linear;                    ///< RGB in linear light
  Image8 texture;                   ///< the same as 8-bit sRGB
  std::int64_t texels = 0;          ///< of the surface
  std::int64_t own_texels = 0;      ///< seen in the pose's own photographs
  std::int64_t filled_texels = 0;   ///< copied from other poses
  std::vector<std::int64_t> taken;  ///< from each of the others, of filled_texels
  std::int64_t unseen_texels() const {
    return texels - own_texels - filled_texels;
  }  ///< seen in no pose: inpainted
};

/// Where the pose's own photographs show nothing, the texture of the pose with the highest
/// confidence is used. The choice is made per vertex from the confidence around it, with
/// transitions within faces. Before that the other pose's colours are adapted to the own pose's
/// light, by one factor per channel. The factor is estimated where both are seen, and continued
/// smoothly (by heat diffusion over the surface, through the seams of charts) to where only the
/// other one is seen, so that no edge is visible between the two. Places where the two differ in
/// content (a shadow, a wrong registration) have a low weight in this estimate. Where the own
/// confidence fades, both are mixed. Surface that no pose shows is inpainted.
///
/// @param mesh    with UVs in [0,1]: the layout of all textures, and the shape of this pose
/// @param own     this pose
/// @param others  a texture with the own pixels is ignored
/// @param gutter  texels around each chart that continue its colours
/// @throws InputError  no UVs; textures of other sizes, not square, or without a texel of the mesh
/// Same bits for any thread count.
/// Sources: Perez, Gangnet, Blake, SIGGRAPH 2003 (membrane between images), here for a factor and
/// with robust weights (Cauchy).
Completed CompleteTexture(const Mesh& mesh, const PoseTexture& own,
                          const std::vector<PoseTexture>& others, int gutter);

}  // namespace keypose::texture
