// Options of keypose-sfm.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/values/options.h"
#include "core/values/size_of.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/evidence/camera_evidence.h"
#include "reconstruct/matching/descriptor_matching.h"
#include "reconstruct/matching/pair_list.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

struct SfmOptions {
  /// auto tries board, features, ring, silhouettes in this order
  std::string method = "auto";
  std::string rings = "auto";  ///< sizes of the rings in the order of names, such as 18+18
  int max_image_size = 2000;   ///< longer side at which features are found
  /// whether the whole photographs place the cameras: what stands still with the figure
  std::string surroundings = "auto";
  int whole_px = 1200;      ///< longer side at which features of whole photographs are found
  int max_features = 8192;  ///< per image
  /// COLMAP's default of 0.0067 finds few features on clay, plush and paint
  double peak_threshold = 0.002;
  std::string detail = "auto";  ///< size of the smallest features
  bool affine_shape = true;
  bool domain_size_pooling = false;
  int mask_margin_px = 4;
  int all_pairs_limit = PairListOptions{}.all_pairs_limit;
  int neighbors = PairListOptions{}.neighbors;
  int similar = PairListOptions{}.similar;
  double max_ratio = MatchOptions{}.max_ratio;
  bool guided_matching = true;
  int min_inliers = 15;
  double min_triangulation_deg = 1.5;
  bool refine_principal_point = BundleOptions{}.refine_principal_point;
  bool refine_distortion = BundleOptions{}.refine_distortion;
  bool patches = true;         ///< track points by grey values, and adjust the cameras to them
  int adjusted_points = 6000;  ///< points in the bundle adjustments, spread over the figure
  double min_placed = 0.6;
  /// of masks and their hull under the estimated cameras
  double min_hull_overlap = CameraEvidenceTuning::kLeastHullOverlap;
  bool level = true;
  bool board = true;          ///< use the printed calibration board if photographs show it
  int min_board_corners = 8;  ///< corners that a photograph must show to be placed by the board
  bool refine_poses = false;  ///< adjust given poses; else they stay as given

  PairListOptions PairList() const {
    PairListOptions pairs;
    pairs.all_pairs_limit = all_pairs_limit;
    pairs.neighbors = neighbors;
    pairs.similar = similar;
    return pairs;
  }

  /// Errors of features are allowed in pixels of ordinary photographs. Places in larger ones, in
  /// which features are found at `max_image_size`, err by as many times more.
  double PixelsOf(int longer_side_px) const {
    return std::max(1.0, longer_side_px / static_cast<double>(max_image_size));
  }

  /// The possible assignments of photographs to rings.
  /// @throws InputError  the given sizes do not add up to the number of photographs
  std::vector<RingLayout> Layouts(const std::vector<std::string>& names) const {
    const std::vector<int> sizes = RingSizes();
    return sizes.empty() ? LikelyLayouts(names)
                         : std::vector<RingLayout>{LayoutOfSizes(SizeOf(names), sizes)};
  }

  std::vector<std::string> Problems() const {
    if (rings == "auto" || !RingSizes().empty()) return {};
    return {"rings must be auto or sizes joined by +, each 3 or more, such as 18+18, but is '" +
            rings + "'"};
  }

  void Describe(OptionVisitor& visit) {
    visit(
        "method", method,
        {"how cameras are found; auto tries one strategy after the other and reports the one that "
         "it uses",
         "",
         0,
         0,
         {"auto", "board", "features", "ring", "silhouettes"}});
    visit("rings", rings,
          {"sizes of the turntable's rings in the order of names, such as 18+18; auto tries equal "
           "ones",
           "",
           0,
           0,
           {}});
    visit("max_image_size", max_image_size,
          {"longer side at which features are found", "px", 320, 20000, {}});
    visit(
        "surroundings", surroundings,
        {"place cameras by all that stands still with the figure (a mat, a table, a room), not by "
         "the figure alone; auto does so where there is enough of it",
         "",
         0,
         0,
         {"auto", "use", "ignore"}});
    visit("max_features", max_features,
          {"largest number of features per image", "", 256, 65536, {}});
    visit("peak_threshold", peak_threshold,
          {"least contrast of a feature; smaller finds more on weak texture", "", 1e-4, 0.1, {}});
    visit("detail", detail,
          {"features at the photographs' own size (coarse), also at twice that size (fine), "
           "or fine only if photographs cannot be placed with coarse ones (auto)",
           "",
           0,
           0,
           {"auto", "coarse", "fine"}});
    visit("affine_shape", affine_shape,
          {"adapt features to slanted surfaces: more matches between distant views", "", 0, 1, {}});
    visit("mask_margin_px", mask_margin_px,
          {"masks grow by this before features are extracted", "px", 0, 100, {}});
    visit("all_pairs_limit", all_pairs_limit,
          {"sets of at most this many images are matched in all pairs", "", 0, 100000, {}});
    visit("neighbors", neighbors,
          {"neighbours in name order, in both directions round the circle, that are always matched",
           "",
           0,
           1000,
           {}});
    visit("similar", similar,
          {"most similar images that each image is matched with", "", 0, 10000, {}});
    visit("max_ratio", max_ratio,
          {"Lowe's ratio: nearest over second nearest descriptor", "", 0.1, 1, {}});
    visit("guided_matching", guided_matching, {"match again along epipolar lines", "", 0, 1, {}});
    visit("refine_principal_point", refine_principal_point,
          {"also solve for the principal point; objects that fill little of the image do not "
           "determine it",
           "",
           0,
           1,
           {}});
    visit("refine_distortion", refine_distortion,
          {"solve for k1, k2, p1, p2 instead of k1 alone; for wide lenses", "", 0, 1, {}});
    visit("patches", patches,
          {"track points by grey values, which is far more accurate than features, and adjust the "
           "cameras to them",
           "",
           0,
           1,
           {}});
    visit("min_placed", min_placed, {"share of images that must be placed", "", 0, 1, {}});
    visit("min_hull_overlap", min_hull_overlap,
          {"least overlap of masks and their hull under the cameras; correct cameras always reach "
           "it, "
           "unless masks are bad; 0 accepts all",
           "",
           0,
           1,
           {}});
    visit("board", board,
          {"place photographs by the printed calibration board where they show it", "", 0, 1, {}});
    visit("refine_poses", refine_poses,
          {"use --poses as a start and adjust them; else they stay as given", "", 0, 1, {}});
    visit("level", level,
          {"turn the model upright, centre it, and scale the mean camera distance to 1",
           "",
           0,
           1,
           {}});
  }

 private:
  /// Empty when `rings` is auto or malformed.
  std::vector<int> RingSizes() const {
    std::vector<int> sizes;
    int value = 0;
    for (const char c : rings + "+") {
      if (c >= '0' && c <= '9' && value < 100000) {
        value = 10 * value + (c - '0');
      } else if (c == '+' && value >= 3) {
        sizes.push_back(value);
        value = 0;
      } else {
        return {};
      }
    }
    return sizes;
  }
};

}  // namespace keypose::reconstruct
