#include "fit/contours/disagreement.h"

#include <cmath>

#include "core/numbers/kd_tree.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

/// Of the silhouette's points, that which is farthest from the outline.
Disagreement FromSilhouette(const std::vector<ContourPoint>& contour, const Outline& outline) {
  Disagreement worst;
  for (const ContourPoint& point : contour) {
    const double distance = outline.Distance(point.pixel);
    // Inside the mask the same gap is seen from the outline, which is what lies beyond.
    if (distance > worst.distance_px && !outline.Cut(point.pixel))
      worst = {point.pixel, distance, false};
  }
  return worst;
}

/// Of the outline's points outside of the silhouette, that which is farthest from it.
Disagreement FromOutline(const std::vector<ContourPoint>& contour, const Outline& outline) {
  PointsX3 flat(SizeOf(contour), 3);
  for (int i = 0; i < SizeOf(contour); ++i)
    flat.row(i) << contour[i].pixel.x(), contour[i].pixel.y(), 0;
  const KdTree tree(flat);
  Disagreement worst;
  for (const Outline::Point& point : outline.points) {
    const KdTree::Neighbor near = tree.Nearest({point.pixel.x(), point.pixel.y(), 0});
    const ContourPoint& other = contour[near.index];
    const double distance = std::sqrt(near.squared_distance);
    if (distance > worst.distance_px && other.normal.dot(point.pixel - other.pixel) > 0)
      worst = {point.pixel, distance, true};
  }
  return worst;
}

}  // namespace

Disagreement WorstDisagreement(const std::vector<ContourPoint>& contour, const Outline& outline) {
  if (contour.empty() || outline.points.empty()) return {};
  const Disagreement silhouette = FromSilhouette(contour, outline),
                     mask = FromOutline(contour, outline);
  return mask.distance_px > silhouette.distance_px ? mask : silhouette;
}

}  // namespace keypose::fit
