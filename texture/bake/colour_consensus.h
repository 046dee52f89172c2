// Which photographs show other colours on the surface than the others do: a hand before the figure,
// something else, another lamp.
#pragma once

#include <vector>

#include "core/image.h"
#include "core/mesh.h"
#include "texture/bake/bake_view.h"

namespace keypose::texture {

struct ConsensusOptions {
  int samples = 20000;  ///< places on the surface, evenly
  double hue = 0.12;  ///< angle between colours (square roots of linear light) that two photographs
                      ///< of one paint do not reach [rad]
  double brightness = 0.5;  ///< the same of the logarithm of brightness (square root), beyond what
                            ///< the view's lamp explains
  double spread = 3;        ///< and so many times the median difference of all views at the place
  /// side of the squares that are hidden together, over the picture's longer side
  double block = 0.035;
  double contrary_block = 0.6;  ///< share of a square's places that contradict the others, from
                                ///< which on it shows something else
  /// share of a view's places that hidden squares must hold to be believed
  double least_hidden = 0.012;
  double told_hidden = 0.02;  ///< share from which on a person is told: less is a highlight or fur
                              ///< in the light as often as a hand
  /// share of contrary places, from which on a view is not believed at all
  double most_contrary = 0.4;
  double light = 0.3;  ///< change of log brightness over a unit of the normal's turn, by which a
                       ///< view's lamp stands elsewhere
  double other_light_weight = 0.15;  ///< what views under another lamp weigh
};

/// How one photograph's colours go with the others'.
struct ViewColors {
  int places = 0;           ///< of the samples that it and three others show
  double contrary = 0;      ///< share of these whose colour contradicts what most others show there
  bool distrusted = false;  ///< more than most_contrary: it shows something else
  Image8 hidden;  ///< one pixel a square: 255 where something else is before the figure; empty:
                  ///< nowhere
  double block_px = 0;      ///< side of a square
  double hidden_share = 0;  ///< of its places
  bool told = false;        ///< so much is hidden that a person should look at the photograph
  Eigen::Vector2d light = Eigen::Vector2d::Zero();  ///< growth of log brightness with the normal's
                                                    ///< part to the right and down
  bool other_light = false;  ///< its lamp stands elsewhere than most views' does
};

/// Compares each photograph with the median of all at places on the surface; hue and brightness
/// apart, since shading moves with the table and hue does not. A view's own lamp (a slope over the
/// normal before its camera) is fitted first.
/// @param gains  of the views  @param used  one a view: 0 is not asked
/// Deterministic; the same bits for any thread count.
std::vector<ViewColors> JudgeColors(const Mesh& mesh, const std::vector<BakeView>& views,
                                    const std::vector<Eigen::Vector3f>& gains,
                                    const std::vector<char>& used,
                                    const ConsensusOptions& options = {});

}  // namespace keypose::texture
