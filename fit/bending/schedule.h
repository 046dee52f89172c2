// The rounds in which a template is bent: what takes part in each, and how strongly.
#pragma once

#include <vector>

namespace keypose::fit {

struct Round {
  int level;                              ///< 0 fine, 1 middle, 2 coarse
  double stiffness;                       ///< of the shape
  double features, outlines, appearance;  ///< factors of their weights; 0: not used
  double marks;        ///< weight of a pick, in cells of the coarse level that hold features
  double scale;        ///< robust distance of features and outlines [half diagonals]
  int pyramid;         ///< level of the views
  int turns;           ///< of positions and maps
  int repeats;         ///< of the whole round
  double rematch = 0;  ///< before it, features are matched within this distance [half diagonals]
  double limbs = 0;    ///< weight of a turned limb's places, over a vertex's share of the shape's
};

/// Where the first rounds end that use grey values: before, all is far.
/// @param cameras_known  false: rounds come first in which cameras find each other while the shape
/// is stiff. A soft shape would bend to make up for wrong cameras.
std::vector<Round> FarRounds(bool cameras_known);
/// Grey values from coarse to fine.
std::vector<Round> NearRounds();

/// Instead of these where there is no texture: outlines and picks, on the coarser levels. Outlines
/// say nothing of single vertices, so the finest level only takes over what its neighbours do.
std::vector<Round> UntexturedRounds();

/// Distance at which a pick has a quarter of its weight [half diagonals].
double MarkScale(const Round& round);

}  // namespace keypose::fit
