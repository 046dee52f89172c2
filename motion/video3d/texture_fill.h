// Textures of frames without holes: what no camera sees is filled from the frames around, and what
// none of them shows from one texture for all.
#pragma once

#include <functional>
#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "motion/video3d/level_field.h"
#include "motion/video3d/surface_texels.h"
#include "views/atlas/atlas.h"

namespace keypose::motion {

/// The mean of all frames, made complete: the source of what is never seen near in time.
class MeanTexture {
 public:
  /// Refers to `texels`, which must outlive this.
  explicit MeanTexture(const SurfaceTexels& texels);
  void Add(const TexelColors& frame);
  /// Share of the texels that some frame shows.
  double seen() const;
  /// Unseen texels take the template's texture, in the light of the films; without one, the colours
  /// around them (InpaintUnseen).
  /// @param own_texture  RGB of the atlas's size, or empty
  TexelColors Completed(const Mesh& mesh, const Atlas& atlas, const Image8& own_texture) const;

 private:
  const SurfaceTexels& texels_;
  std::vector<float> sum_;  // N x 4: weighted linear colour, weight
};

struct FillOptions {
  int reach = 8;    ///< frames before and after, from which holes are filled
  int gutter = 12;  ///< texels around each chart that continue its colours
};

struct FilledTexture {
  Image8 texture;         ///< RGB, sRGB
  double own = 0;         ///< share of the surface's texels from this frame's pictures
  double neighbours = 0;  ///< share from other frames; the rest is from the mean
};

/// Fills one frame after the other, in order.
class TextureFiller {
 public:
  /// Refers to all but `mean`; they must outlive this.
  TextureFiller(const Mesh& mesh, const Atlas& atlas, const SurfaceTexels& texels, TexelColors mean,
                const FillOptions& options);

  /// @param frames  the frames within reach, by number
  FilledTexture Fill(int frame, const std::function<const TexelColors*(int frame)>& frames);

 private:
  TexelColors Around(int frame, const std::function<const TexelColors*(int frame)>& frames,
                     std::vector<char>* near) const;

  const FacesX3& faces_;
  const Atlas& atlas_;
  const SurfaceTexels& texels_;
  TexelColors mean_;
  FillOptions options_;
  LevelField level_;
};

}  // namespace keypose::motion
