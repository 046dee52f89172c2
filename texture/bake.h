// Paints the photographs of a pose into the atlas of its mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"
#include "core/options.h"
#include "core/progress.h"
#include "texture/bake_view.h"

namespace keypose::texture {

struct BakeOptions {
  int texture_size = 2048;
  int gutter = 12;
  double edge_guard = 2;
  double edge_feather = 10;
  double max_angle = 75;
  double detail_exponent = 6;
  double strictness = 3;
  bool harmonize = true;
  int hold_out = 0;

  void Describe(OptionVisitor& visit) {
    visit("texture_size", texture_size, {"width and height of the texture", "px", 16, 16384});
    visit("gutter", gutter, {"how far colours continue around each chart", "px", 0, 256});
    visit("edge_guard", edge_guard,
          {"nothing is taken from a photograph nearer than this to an edge of the mask, of the object or of the image", "px", 0, 100});
    visit("edge_feather", edge_feather, {"width beyond the guard over which a view gains its full weight", "px", 0, 1000});
    visit("max_angle", max_angle, {"views that see the surface more aslant than this do not count", "deg", 10, 89});
    visit("detail_exponent", detail_exponent,
          {"how much the best view rules in fine detail; 1 blends detail as softly as large-scale colour", "", 1, 50});
    visit("strictness", strictness,
          {"how fast a colour loses weight that few other views support (lamps, wrong masks); 0 trusts all", "", 0, 20});
    visit("harmonize", harmonize, {"estimate one gain a view and channel, so that exposure and white balance agree", ""});
    visit("hold_out", hold_out,
          {"leave every n-th photograph out of the texture and report how well it is predicted; 0 uses all", "photographs", 0, 1000});
  }
};

/// How well the textured mesh repeats one photograph.
struct ViewQuality {
  bool used = false;  ///< at least one texel took colour from it
  bool held_out = false;
  int pixels = 0;           ///< compared, well inside the mask
  double psnr_db = 0;       ///< against the photograph as it is; 0 without pixels, at most 99
  double psnr_gain_db = 0;  ///< with the view's gain applied to the rendering
};

struct BakeResult {
  Image8 texture;                      ///< RGB, texture_size square
  std::int64_t texels = 0;             ///< of the surface
  std::int64_t seen_texels = 0;        ///< painted from photographs; the rest is inpainted
  double mean_views_per_texel = 0;     ///< that see it, over the seen texels
  std::vector<Eigen::Vector3f> gains;  ///< one a view: what its linear colours were multiplied by
  std::vector<ViewQuality> quality;    ///< one a view

  std::int64_t unseen_texels() const { return texels - seen_texels; }
};

/// The texture of a mesh from photographs with known cameras.
///
/// A view counts where it sees the surface: by depth maps (rays by Embree), the mask, and a guard band along every edge of both.
/// Large-scale colour (wider than 8 pixels of the photograph) is the mean of all good views, weighted by resolution and angle; detail comes
/// from the best view or two, cross-faded. Per texel, colours that the other views contradict (a lamp's highlight, background behind a
/// wrong mask) lose their weight. What no photograph shows is inpainted over the surface and counted.
///
/// @param mesh   with UVs in [0,1]; faces counter-clockwise from outside
/// @param views  V >= 1 cameras
/// @param load   photograph of view i; called once a view, from several threads
/// @return texture, counts and per-view quality
/// @throws InputError  no UVs, photograph of another size than its camera, or not one texel is seen by any view
/// Cost: one ray a depth pixel, then texels x facing views. Same bits for any thread count.
/// Sources: Waechter et al., ECCV 2014 (weights, gains, outliers); Baumberg, BMVC 2002 (two-band blending).
BakeResult Bake(const Mesh& mesh, const std::vector<View>& views, const std::function<Photograph(int)>& load, const BakeOptions& options,
                Progress* progress = nullptr);

}  // namespace keypose::texture
