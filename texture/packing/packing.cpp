#include "texture/packing/packing.h"

#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/values/errors.h"
#include "texture/packing/elastic_packing.h"
#include "texture/packing/nesting.h"

namespace keypose::texture {
namespace {

// Vertices along the boundary, surface to the left.
UvsX2 RimOf(const Shape& shape) {
  std::map<std::pair<int, int>, int> edges;
  for (int f = 0; f < static_cast<int>(shape.corners.rows()); ++f)
    for (int k = 0; k < 3; ++k) ++edges[{shape.corners(f, k), shape.corners(f, (k + 1) % 3)}];
  std::map<int, int> next;
  for (const auto& [edge, count] : edges)
    if (!edges.contains({edge.second, edge.first})) next[edge.first] = edge.second;
  UvsX2 rim(std::ssize(next), 2);
  int at = next.begin()->first;
  for (Eigen::Index i = 0; i < rim.rows(); ++i, at = next.at(at)) rim.row(i) = shape.points.row(at);
  return rim;
}

double AreaOf(const Shape& shape) {
  double area = 0;
  for (int f = 0; f < static_cast<int>(shape.corners.rows()); ++f) {
    const Eigen::Vector2d p = shape.points.row(shape.corners(f, 0)),
                          q = shape.points.row(shape.corners(f, 1)),
                          r = shape.points.row(shape.corners(f, 2));
    area += ((q - p).x() * (r - p).y() - (q - p).y() * (r - p).x()) / 2;
  }
  return area;
}

}  // namespace

Packing Pack(const std::vector<Shape>& shapes, const PackingOptions& options) {
  std::vector<UvsX2> rims;
  Packing packing;
  for (const Shape& shape : shapes) {
    rims.push_back(RimOf(shape));
    packing.utilisation += AreaOf(shape);
  }
  const double gap = static_cast<double>(options.gutter_px) / options.texture_size;
  NestingOptions nesting_options;
  nesting_options.gap = gap;
  nesting_options.effort = options.effort;
  std::optional<Nesting> apart;
  // Overlaps of half a cell can usually be resolved; outlines wider by a cell do not overlap at
  // all.
  for (nesting_options.margin = 0; !apart && nesting_options.margin <= 1;
       ++nesting_options.margin) {
    const Nesting nesting = Nested(rims, nesting_options);
    if (nesting.scale > 0) apart = SetApart(rims, nesting, gap);
  }
  if (!apart)
    throw QualityError("unwrap: " + std::to_string(shapes.size()) +
                       " charts do not fit the texture with this gutter; lower --gutter");
  for (std::size_t i = 0; i < shapes.size(); ++i)
    packing.uvs.push_back(Placed(shapes[i].points, apart->scale, apart->places[i]));
  packing.scale = apart->scale;
  packing.utilisation *= apart->scale * apart->scale;
  return packing;
}

}  // namespace keypose::texture
