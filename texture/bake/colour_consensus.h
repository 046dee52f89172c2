// Detects photographs whose colours on the surface differ from the others': a hand in front of the
// figure, another object, another lamp.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "core/values/mesh.h"
#include "core/values/tuned.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

/// Tuned on the demo's mesh with its own photographs and with `keypose synth photos --lamp-fall 0.6
/// --hand 2`: both hands and the lamp's fall are found, and nothing else.
struct ConsensusTuning {
  /// rad: angle between colours (square roots of linear light) that two photographs of one paint do
  /// not exceed
  KEYPOSE_TUNED(double, kHue, 0.12);
  /// logarithm of brightness (square root): the same, after correction for the view's lamp
  KEYPOSE_TUNED(double, kBrightness, 0.5);
  /// median differences of all views at the point that an outlier exceeds as well
  KEYPOSE_TUNED(double, kSpread, 3);
  /// of the picture's longer side: side of the squares that are hidden as a whole
  KEYPOSE_TUNED(double, kBlock, 0.035);
  /// least share of a square's points that are outliers, for a hidden square
  KEYPOSE_TUNED(double, kContraryBlock, 0.6);
  /// least share of a view's points in connected hidden squares; smaller regions are ignored
  KEYPOSE_TUNED(double, kLeastHidden, 0.012);
  /// least such share for a warning: smaller regions are as often a highlight or lit fur as a hand
  KEYPOSE_TUNED(double, kToldHidden, 0.02);
  /// share of outlier points above which an entire view is left out
  KEYPOSE_TUNED(double, kMostContrary, 0.4);
  /// least change of log brightness per unit of the normal's x or y that indicates another lamp
  KEYPOSE_TUNED(double, kLight, 0.3);
  /// factor of the weight of views under that lamp
  KEYPOSE_TUNED(double, kOtherLightWeight, 0.15);
};

/// Comparison of one photograph's colours with the others'.
struct ViewColors {
  int places = 0;           ///< number of samples that it and at least three others see
  double contrary = 0;      ///< share of these whose colour is an outlier
  bool distrusted = false;  ///< outlier share above kMostContrary: it shows another object
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
                                    const std::vector<char>& used);

}  // namespace keypose::texture
