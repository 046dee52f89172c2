// Packed charts that are moved apart where they touch, as rigid shapes or as elastic sheets
// (elastic packing) that fill the gaps between them.
#pragma once

#include <optional>
#include <vector>

#include "texture/charts/elastic_sheet.h"
#include "texture/packing/nesting.h"

namespace keypose::texture {

/// Points rotated, scaled and moved.
UvsX2 Placed(const UvsX2& points, double scale, const Placement& place);

/// Separates rigid charts whose places may overlap a little.
/// @param outlines  simple polygons; `nesting` belongs to them
/// @return places and scale (that of `nesting` or somewhat smaller) at which all keep `gap`;
/// nothing if more than a third of the scale would be lost
std::optional<Nesting> SetApart(const std::vector<UvsX2>& outlines, Nesting nesting, double gap);

struct ElasticPackingOptions {
  double gap = 0;    ///< [side of the square] between charts; half of it to the border
  int rounds = 200;  ///< rounds of growth, by a thousandth each; cost grows with it
};

/// Charts laid out in the unit square, each as an elastic sheet.
struct Layout {
  std::vector<UvsX2> uvs;  ///< per chart
  double scale = 0;        ///< sides of the square per unit of the surface, without stress
};

/// Elastic packing: the sheets grow under pressure, deform where they touch, and fill the gaps.
/// Nothing is mirrored, no triangle flips.
/// @param layout  all at least `gap` apart
/// @return the layout with the largest covered area among those that keep the gap; `layout` itself
/// if none is better
Layout PackElastically(const Surface& surface, const std::vector<const Chart*>& charts,
                       const Layout& layout, const ElasticPackingOptions& options);

}  // namespace keypose::texture
