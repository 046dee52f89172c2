// Detects photographs whose colours on the surface differ from the others': a hand in front of the
// figure, another object, another lamp.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

struct ConsensusOptions {
  int samples = 20000;  ///< evenly distributed points on the surface
  double hue = 0.12;  ///< angle between colours (square roots of linear light) that two photographs
                      ///< of one paint do not exceed [rad]
  double brightness = 0.5;  ///< the same for the logarithm of brightness (square root), after
                            ///< correction for the view's lamp
  /// and at least this many times the median difference of all views at the point
  double spread = 3;
  /// side of the squares that are hidden as a whole, over the picture's longer side
  double block = 0.035;
  /// least share of a square's points that are outliers, for a hidden square
  double contrary_block = 0.6;
  /// least share of a view's points in connected hidden squares; smaller regions are ignored
  double least_hidden = 0.012;
  double told_hidden = 0.02;  ///< least share for a warning: smaller regions are as often a
                              ///< highlight or lit fur as a hand
  /// share of outlier points above which an entire view is left out
  double most_contrary = 0.4;
  double light = 0.3;  ///< least change of log brightness per unit of the normal's x or y that
                       ///< indicates another lamp
  double other_light_weight = 0.15;  ///< weight of views under another lamp
};

/// Comparison of one photograph's colours with the others'.
struct ViewColors {
  int places = 0;           ///< number of samples that it and at least three others see
  double contrary = 0;      ///< share of these whose colour is an outlier
  bool distrusted = false;  ///< outlier share above most_contrary: it shows another object
  Image8 hidden;  ///< one pixel per square: 255 where another object occludes the figure; empty:
                  ///< nowhere
  double block_px = 0;      ///< side of a square
  double hidden_share = 0;  ///< share of its points that are hidden
  bool told = false;        ///< the hidden part is large enough for a warning
  /// gradient of log brightness with respect to the normal's components to the right and down
  Eigen::Vector2d light = Eigen::Vector2d::Zero();
  bool other_light = false;  ///< its lamp is elsewhere than in most views
};

/// Compares each photograph with the median of all at points on the surface. Hue and brightness are
/// compared separately, since shading moves with the table and hue does not. A view's own lamp (a
/// linear function of the normal in the camera's frame) is fitted first.
/// @param gains  of the views
/// @param used   one per view: views with 0 are ignored
/// Deterministic; the same bits for any thread count.
std::vector<ViewColors> JudgeColors(const Mesh& mesh, const std::vector<BakeView>& views,
                                    const std::vector<Eigen::Vector3f>& gains,
                                    const std::vector<char>& used,
                                    const ConsensusOptions& options = {});

}  // namespace keypose::texture
