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
#include "texture/bake/bake_view.h"
#include "texture/bake/colour_consensus.h"

namespace keypose::texture {

struct BakeOptions {
  int texture_size = 2048;
  int bits = 0;
  int gutter = 12;
  double edge_guard = 2;
  double edge_feather = 10;
  double max_angle = 75;
  bool common_light = true;
  bool align = true;
  double detail_step = 0.03;
  double strictness = 3;
  bool harmonize = true;
  bool consensus = true;
  int hold_out = 6;
  bool leave_out = false;

  void Describe(OptionVisitor& visit) {
    visit("texture_size", texture_size,
          {"width and height of the texture; 0: a texel for each pixel of the nearest photographs, "
           "a power of two up to 4096",
           "px", 0, 16384});
    visit("bits", bits,
          {"a channel: 8 or 16 for .png and .tif (sRGB), 16 or 32 for .exr (linear light); 0: 8 "
           "for .png, 16 for others",
           "bits", 0, 32});
    visit("gutter", gutter, {"how far colours continue around each chart", "px", 0, 256});
    visit("edge_guard", edge_guard,
          {"nothing is taken from a photograph nearer than this to an edge of the mask, of the "
           "object or of the image",
           "px", 0, 100});
    visit("edge_feather", edge_feather,
          {"width beyond the guard over which a view gains its full weight", "px", 0, 1000});
    visit("max_angle", max_angle,
          {"views that see the surface at a larger angle than this do not count", "deg", 10, 89});
    visit("common_light", common_light,
          {"large-scale colour is the mean of all views; false: that of the view that paints the "
           "place, matched where views meet",
           ""});
    visit(
        "align", align,
        {"shift the photographs by smooth fields of some pixels so that they agree on the surface",
         ""});
    visit("detail_step", detail_step,
          {"detail comes from one photograph where that differs from the mean of all by less than "
           "this (square root of linear light), else from the mean; 0: always the mean",
           "", 0, 10});
    visit("strictness", strictness,
          {"how fast a colour loses weight that few other views support (lamps, wrong masks); 0 "
           "trusts all",
           "", 0, 20});
    visit("harmonize", harmonize,
          {"estimate one gain a view and channel, so that exposure and white balance agree", ""});
    visit("consensus", consensus,
          {"leave out photographs, or parts of them, whose colours contradict the others (a hand, "
           "something else)",
           ""});
    visit("hold_out", hold_out,
          {"report how well every n-th photograph is predicted by a texture of the others (of 12 "
           "or more); 0: do not",
           "photographs", 0, 1000});
    visit("leave_out", leave_out,
          {"leave those photographs out of the texture itself too, to compare it with other "
           "programs'",
           ""});
  }
  std::vector<std::string> Problems() const;
};

/// How well a textured mesh repeats one photograph (quality.h).
struct ViewQuality {
  bool used = false;      ///< at least one texel took detail from it
  bool held_out = false;  ///< held_out_* are known
  int pixels = 0;         ///< compared, inside the mask
  double psnr_db = 0;     ///< against the photograph as it is; 0 without pixels, at most 99
  /// with the factor a channel that gives the rendering the photograph's mean
  double psnr_gain_db = 0;
  double ssim = 0;
  double held_out_psnr_db = 0, held_out_psnr_gain_db = 0,
         held_out_ssim = 0;  ///< the same for a texture made without this photograph
};

struct BakeResult {
  ImageF linear;      ///< RGB in linear light, 1 is the photographs' white; texture_size square
  Image8 texture;     ///< the same as 8-bit sRGB
  Image8 confidence;  ///< 1 channel: how far each texel is what photographs show; 0: inpainted, or
                      ///< no surface
  int advised_size = 0;                ///< what texture_size 0 gives
  std::int64_t texels = 0;             ///< of the surface
  std::int64_t seen_texels = 0;        ///< painted from photographs; the rest is inpainted
  double mean_views_per_texel = 0;     ///< that see it, over the seen texels
  std::vector<Eigen::Vector3f> gains;  ///< one a view: what its linear colours were multiplied by
  std::vector<ViewQuality> quality;    ///< one a view
  std::vector<ViewColors> colors;      ///< one a view: how it goes with the others

  std::int64_t unseen_texels() const { return texels - seen_texels; }
};

/// The texture of a mesh from photographs with known cameras.
///
/// A view counts where it sees the surface: by depth maps (rays by Embree), the mask, and a guard
/// band along every edge of both. Each face is painted from one view, chosen by a graph cut on
/// resolution, angle, sharpness and agreement with the others. Smooth shifts match the views where
/// they meet and bring the large-scale colour (wider than a ring of faces) to the robust mean of
/// all views, in which colours that the others contradict (a lamp's highlight, background behind a
/// wrong mask) lose their weight. Faces larger than some pixels are split for this. What no
/// photograph shows is inpainted over the surface and counted. Before that, photographs or parts of
/// them that contradict the others are left out, and those under another lamp weigh little
/// (colour_consensus.h).
/// How well photographs are predicted is measured by a second, smaller texture of the others.
///
/// @param mesh   with UVs in [0,1]; faces counter-clockwise from outside
/// @param views  V >= 1 cameras
/// @param load   photograph of view i; called once a view, from several threads
/// @return texture, counts and per-view quality
/// @throws InputError  no UVs, photograph of another size than its camera, or not one texel is seen
/// by any view Cost: one ray a depth pixel, then four points a face x facing views, and one sample
/// or two a texel.
/// Same bits for any thread count. Sources: Lempitsky, Ivanov, CVPR 2007 (labels, levelling);
/// Waechter et al., ECCV 2014 (weights, gains, outliers).
BakeResult Bake(const Mesh& mesh, const std::vector<View>& views,
                const std::function<Photograph(int)>& load, const BakeOptions& options,
                Progress* progress = nullptr);

/// The power of two in [256, 4096] at which half the surface has at least one texel for each pixel
/// of the view that shows it largest (up to a tenth less). Views behind it are not looked at,
/// occlusion is not.
int AdviseTextureSize(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::texture
