// Paints the photographs of a pose into the atlas of its mesh.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/options.h"
#include "core/values/progress.h"
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
  double scan_reach = 0.01;

  void Describe(OptionVisitor& visit) {
    visit("texture_size", texture_size,
          {"width and height of the texture; 0: about one texel per pixel of the nearest "
           "photographs, "
           "a power of two up to 4096",
           "px", 0, 16384});
    visit(
        "bits", bits,
        {"bits per channel: 8 or 16 for .png and .tif (sRGB), 16 or 32 for .exr (linear light); 0: "
         "16, but 8 for .png where no photograph has more",
         "bits", 0, 32});
    visit("gutter", gutter, {"width by which colours continue around each chart", "px", 0, 256});
    visit(
        "edge_guard", edge_guard,
        {"width of the unused band in a photograph along the edges of the mask, of the object and "
         "of the image",
         "px", 0, 100});
    visit("edge_feather", edge_feather,
          {"width beyond the guard over which a view's weight rises to its full value", "px", 0,
           1000});
    visit("max_angle", max_angle,
          {"largest angle to the surface's normal at which a view is used", "deg", 10, 89});
    visit("common_light", common_light,
          {"large-scale colour is the mean of all views; false: that of the view that paints the "
           "face, matched where views meet",
           ""});
    visit(
        "align", align,
        {"shift the photographs by smooth fields of a few pixels so that they agree on the surface",
         ""});
    visit("detail_step", detail_step,
          {"detail comes from one photograph where it differs from the mean of all by less than "
           "this (square root of linear light), else from the mean; 0: always the mean",
           "", 0, 10});
    visit("strictness", strictness,
          {"how fast the weight of outlier colours decreases (lamps, wrong masks); 0: all colours "
           "have full weight",
           "", 0, 20});
    visit("harmonize", harmonize,
          {"estimate one gain per view and channel, so that exposure and white balance agree", ""});
    visit("consensus", consensus,
          {"leave out photographs, or parts of them, whose colours are outliers (a hand, another "
           "object)",
           ""});
    visit("hold_out", hold_out,
          {"report how well every n-th photograph is predicted by a texture of the others (with 12 "
           "photographs or more); 0: no report",
           "photographs", 0, 1000});
    visit("leave_out", leave_out,
          {"leave those photographs out of the final texture too, for comparison with other "
           "programs",
           ""});
    visit(
        "scan_reach", scan_reach,
        {"how far from the mesh a scan may lie for its colours to count, over the mesh's diagonal",
         "", 1e-5, 1});
  }
  std::vector<std::string> Problems() const;
};

/// Agreement of a rendered textured mesh with one photograph (texture_quality.h).
struct ViewQuality {
  bool used = false;      ///< it contributed detail to at least one texel
  bool held_out = false;  ///< the values held_out_* are valid
  int pixels = 0;         ///< number of compared pixels, inside the mask
  double psnr_db = 0;     ///< against the unchanged photograph; 0 without pixels, at most 99
  /// with one factor per channel that gives the rendering the photograph's mean
  double psnr_gain_db = 0;
  double ssim = 0;
  double held_out_psnr_db = 0, held_out_psnr_gain_db = 0,
         held_out_ssim = 0;  ///< the same for a texture made without this photograph
};

struct BakeResult {
  ImageF linear;   ///< RGB in linear light, 1 is the photographs' white; texture_size square
  Image8 texture;  ///< the same as 8-bit sRGB
  /// 1 channel: how well photographs show each texel; 0: inpainted, or no surface
  Image8 confidence;
  int advised_size = 0;                ///< the size that texture_size 0 selects
  std::int64_t texels = 0;             ///< of the surface
  std::int64_t seen_texels = 0;        ///< painted from photographs; the rest is inpainted
  double mean_views_per_texel = 0;     ///< number of views that see a texel, over the seen texels
  std::vector<Eigen::Vector3f> gains;  ///< one per view: factors of its linear colours
  std::vector<ViewQuality> quality;    ///< one per view
  std::vector<ViewColors> colors;      ///< one per view: agreement with the others

  std::int64_t unseen_texels() const { return texels - seen_texels; }
};

/// The texture of a mesh from photographs with known cameras.
///
/// A view is used where it sees the surface, according to depth maps (rays by Embree), the mask,
/// and a guard band along every edge of both. Each face is painted from one view. A graph cut
/// chooses it by resolution, angle, sharpness and agreement with the others. Smooth shifts match
/// the views where they meet, and move the large-scale colour (wider than a ring of faces) to the
/// robust mean of all views. In that mean, outlier colours (a lamp's highlight, background behind a
/// wrong mask) have little weight. Faces larger than some pixels are split first. Surface that no
/// photograph shows is inpainted and counted. Before all this, photographs or parts of them with
/// inconsistent colours are removed, and photographs under another lamp get a low weight
/// (colour_consensus.h).
/// A second, smaller texture of the other photographs measures how well held-out photographs are
/// predicted.
///
/// @param mesh   with UVs in [0,1]; faces counter-clockwise from outside
/// @param views  V >= 1 cameras
/// @param load   photograph of view i; called once per view, from several threads
/// @return texture, counts and per-view quality
/// @throws InputError  no UVs, a photograph of another size than its camera, or no texel is seen by
/// any view
/// Cost: one ray per depth pixel, then four points per face and facing view, and one or two samples
/// per texel.
/// Same bits for any thread count.
/// Sources: Lempitsky, Ivanov, CVPR 2007 (labels, levelling); Waechter et al., ECCV 2014 (weights,
/// gains, outliers).
BakeResult Bake(const Mesh& mesh, const std::vector<View>& views,
                const std::function<Photograph(int)>& load, const BakeOptions& options,
                Progress* progress = nullptr);

/// The power of two in [256, 4096] at which half the surface has at least one texel per pixel of
/// the view that shows it largest (up to a tenth less). Only views in front of a face are used;
/// occlusion is ignored.
int AdviseTextureSize(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::texture
