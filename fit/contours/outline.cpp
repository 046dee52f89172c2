#include "fit/contours/outline.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/numbers/kd_tree.h"
#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr double kLeastAgreement = 0.5;  // cosine between normals
constexpr double kStep = 2.5;            // of a difference [px]
constexpr int kNeighbours = 12;          // contour points that are tried for one outline point
constexpr double kSide = 6;  // this near to the picture's side the outline is unknown [px]

}  // namespace

double Outline::Distance(const Eigen::Vector2d& pixel) const {
  const double x = std::clamp(pixel.x(), 0.0, field.width - 1.001),
               y = std::clamp(pixel.y(), 0.0, field.height - 1.001);
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double u = x - x0, v = y - y0;
  const double inside = (1 - v) * ((1 - u) * field.At(x0, y0) + u * field.At(x0 + 1, y0)) +
                        v * ((1 - u) * field.At(x0, y0 + 1) + u * field.At(x0 + 1, y0 + 1));
  return inside + (pixel - Eigen::Vector2d(x, y)).norm();
}

Eigen::Vector2d Outline::Gradient(const Eigen::Vector2d& pixel) const {
  // Over several pixels, because the outline is a staircase of them.
  const Eigen::Vector2d dx(kStep, 0), dy(0, kStep);
  const Eigen::Vector2d g(Distance(pixel + dx) - Distance(pixel - dx),
                          Distance(pixel + dy) - Distance(pixel - dy));
  const double length = g.norm();
  return length > 0.2 * kStep ? Eigen::Vector2d(g / length) : Eigen::Vector2d::Zero();
}

bool Outline::Cut(const Eigen::Vector2d& pixel) const {
  return (field.edges[0] && pixel.x() < kSide) ||
         (field.edges[1] && pixel.x() > field.width - 1 - kSide) ||
         (field.edges[2] && pixel.y() < kSide) ||
         (field.edges[3] && pixel.y() > field.height - 1 - kSide);
}

Outline MakeOutline(const PreparedView& view, int level) {
  Outline outline{MakeMaskField(view, level), {}};
  const MaskField& field = outline.field;
  for (int y = 1; y + 1 < field.height; ++y)
    for (int x = 1; x + 1 < field.width; ++x) {
      const float d = field.At(x, y);
      // the last pixels inside, every second of them
      if (d > 0 || d <= -1 || ((x + y) & 1)) continue;
      const Eigen::Vector2d pixel(x, y), normal = outline.Gradient(pixel);
      if (normal.isZero() || outline.Cut(pixel)) continue;
      outline.points.push_back({pixel - d * normal, normal});
    }
  return outline;
}

std::vector<OutlineMatch> MatchToOutline(const std::vector<ContourPoint>& contour,
                                         const Outline& outline, double reach_px) {
  std::vector<OutlineMatch> matches;
  for (int i = 0; i < SizeOf(contour); ++i) {
    const ContourPoint& point = contour[i];
    const double distance = outline.Distance(point.pixel);
    if (std::abs(distance) > reach_px || outline.Cut(point.pixel)) continue;
    const Eigen::Vector2d gradient = outline.Gradient(point.pixel);
    if (gradient.dot(point.normal) < kLeastAgreement) continue;
    matches.push_back({i, gradient, -distance, point.length_px});
  }
  return matches;
}

std::vector<OutlineMatch> MatchFromOutline(const std::vector<ContourPoint>& contour,
                                           const Outline& outline, double reach_px) {
  std::vector<OutlineMatch> matches;
  if (contour.empty()) return matches;
  PointsX3 flat(SizeOf(contour), 3);
  for (int i = 0; i < SizeOf(contour); ++i)
    flat.row(i) << contour[i].pixel.x(), contour[i].pixel.y(), 0;
  const KdTree tree(flat);
  for (const Outline::Point& point : outline.points) {
    const Eigen::Vector3d at(point.pixel.x(), point.pixel.y(), 0);
    for (const KdTree::Neighbor& near : tree.Nearest(at, kNeighbours)) {
      if (near.squared_distance > reach_px * reach_px) break;
      const ContourPoint& match = contour[near.index];
      if (match.normal.dot(point.normal) < kLeastAgreement) continue;
      matches.push_back(
          {near.index, point.normal, point.normal.dot(point.pixel - match.pixel), 2.0});
      break;
    }
  }
  return matches;
}

}  // namespace keypose::fit
