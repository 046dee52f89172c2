#include "composite/locating/outline/outline_matches.h"

#include <cmath>

#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

void MatchToMatte(const std::vector<SilhouettePoint>& silhouette, const MatteOutline& outline,
                  double reach_px, OutlineMatches& result) {
  for (const SilhouettePoint& point : silhouette) {
    if (point.inner || outline.Cut(point.pixel)) continue;
    result.length_px += point.length_px;
    const int i = outline.Nearest(point.pixel, point.normal, reach_px);
    if (i < 0) {
      result.unmatched_px += point.length_px;
      continue;
    }
    const OutlinePoint& near = outline.points()[i];
    result.matches.push_back({point.position, point.pixel, near.normal,
                              near.normal.dot(near.pixel - point.pixel), point.length_px});
  }
}

void MatchFromMatte(const std::vector<SilhouettePoint>& silhouette, const MatteOutline& outline,
                    double reach_px, OutlineMatches& result) {
  std::vector<int> outer;
  for (int i = 0; i < SizeOf(silhouette); ++i)
    if (!silhouette[i].inner) outer.push_back(i);
  result.length_px += SizeOf(outline.points());
  if (outer.empty()) {
    result.unmatched_px += SizeOf(outline.points());
    return;
  }
  PointsX3 flat(SizeOf(outer), 3);
  for (int k = 0; k < SizeOf(outer); ++k)
    flat.row(k) << silhouette[outer[k]].pixel.x(), silhouette[outer[k]].pixel.y(), 0;
  const KdTree tree(flat);
  for (const OutlinePoint& point : outline.points()) {
    bool found = false;
    const Eigen::Vector3d at(point.pixel.x(), point.pixel.y(), 0);
    for (const KdTree::Neighbor& near : tree.Nearest(at, kTriedNeighbours)) {
      if (near.squared_distance > reach_px * reach_px) break;
      const SilhouettePoint& partner = silhouette[outer[near.index]];
      if (partner.normal.dot(point.normal) < kLeastAgreement) continue;
      result.matches.push_back({partner.position, partner.pixel, point.normal,
                                point.normal.dot(point.pixel - partner.pixel), 1.0});
      found = true;
      break;
    }
    if (!found) result.unmatched_px += 1;
  }
}

}  // namespace

double OutlineMatches::Mean(double reach_px) const {
  double sum = reach_px * unmatched_px;
  for (const OutlineMatch& match : matches) sum += match.length_px * std::abs(match.distance_px);
  return length_px > 0 ? sum / length_px : reach_px;
}

double OutlineMatches::MeanMatched() const {
  double sum = 0, length = 0;
  for (const OutlineMatch& match : matches) {
    sum += match.length_px * std::abs(match.distance_px);
    length += match.length_px;
  }
  return length > 0 ? sum / length : 0;
}

OutlineMatches MatchOutlines(const std::vector<SilhouettePoint>& silhouette,
                             const MatteOutline& outline, double reach_px) {
  OutlineMatches result;
  MatchToMatte(silhouette, outline, reach_px, result);
  MatchFromMatte(silhouette, outline, reach_px, result);
  return result;
}

}  // namespace keypose::composite
