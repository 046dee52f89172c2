// A pose's texture, with what its own photographs do not show taken from the other poses' textures
// in the same layout.
#pragma once

#include <cstdint>
#include <vector>

#include "core/image.h"
#include "core/mesh.h"

namespace keypose::texture {

/// A baked texture and how far each of its texels is what photographs show.
struct PoseTexture {
  Image8 texture;     ///< RGB, sRGB, square
  Image8 confidence;  ///< 1 channel of the same size: 255 shown well, 0 not at all (then the
                      ///< texture holds a guess)
};

struct Completed {
  Image8 texture;
  std::int64_t texels = 0;          ///< of the surface
  std::int64_t own_texels = 0;      ///< that the pose's own photographs show
  std::int64_t filled_texels = 0;   ///< that come from other poses
  std::vector<std::int64_t> taken;  ///< from each of the others, of filled_texels
  std::int64_t unseen_texels() const {
    return texels - own_texels - filled_texels;
  }  ///< that no pose shows: inpainted
};

/// Where the own photographs show nothing, each place takes the texture of the pose that shows it
/// best: the choice is made a vertex at a time by confidence around it, and goes over within a
/// face. Before that the other pose's light is brought to the own one's: by a factor a channel that
/// is found where both are seen and goes on smoothly (as heat spreads over the surface, through the
/// seams of charts) into what only the other one shows, so that both meet without an edge. Spots
/// where the two show different things (a shadow, a slipped registration) lose their weight in it.
/// Over the width in which the own confidence fades, both are mixed. What no pose shows is
/// inpainted.
///
/// @param mesh    with UVs in [0,1]: the layout of all textures, and the shape of this pose
/// @param own     this pose
/// @param others  one with the own pixels is passed over
/// @param gutter  texels around each chart that continue its colours
/// @throws InputError  no UVs; textures of other sizes, not square, or without a texel of the mesh
/// Same bits for any thread count. Sources: Perez, Gangnet, Blake, SIGGRAPH 2003 (membrane between
/// images), here of a factor and with robust weights (Cauchy).
Completed CompleteTexture(const Mesh& mesh, const PoseTexture& own,
                          const std::vector<PoseTexture>& others, int gutter);

}  // namespace keypose::texture
