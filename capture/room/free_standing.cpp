#include "capture/room/free_standing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace keypose::capture {
namespace {

constexpr double kOfASide = 0.1;  // of a photograph's side: a mask that it cuts goes on beyond
constexpr double kMost = 0.6;     // share of pairs of one depth, from which a figure is attached

struct Seen {
  Eigen::Vector2d pixel;
  double depth = 0;
};

/// The points that one view shows, inside and outside of its mask.
struct SeenPoints {
  std::vector<Seen> inside, outside;
};

std::vector<SeenPoints> PointsOfViews(const Scene& scene, const std::vector<Image8>& masks,
                                      double least_height) {
  std::vector<SeenPoints> seen(scene.views.size());
  for (const SparsePoint& point : scene.points) {
    const bool on_floor = point.position.z() < least_height;
    for (const int v : point.views) {
      const auto view = static_cast<std::size_t>(v);
      const Eigen::Vector2d p = scene.views[view].Project(point.position);
      const int x = static_cast<int>(std::floor(p.x())), y = static_cast<int>(std::floor(p.y()));
      const Image8& mask = masks[view];
      if (x < 0 || y < 0 || x >= mask.width || y >= mask.height) continue;
      const Seen here{p, (scene.views[view].camera_from_world * point.position).z()};
      if (*mask.at(x, y) > 127)
        seen[view].inside.push_back(here);
      else if (!on_floor)
        seen[view].outside.push_back(here);
    }
  }
  return seen;
}

const Seen* Nearest(const std::vector<Seen>& points, const Seen& to, double reach) {
  const Seen* nearest = nullptr;
  for (const Seen& point : points) {
    const double away = (point.pixel - to.pixel).norm();
    if (away >= reach) continue;
    reach = away;
    nearest = &point;
  }
  return nearest;
}

}  // namespace

Attachment FindAttachment(const Scene& scene, const std::vector<Image8>& masks, bool on_floor,
                          const FreeStandingOptions& options) {
  double distance = 0;
  for (const View& view : scene.views)
    distance += view.Center().norm() / static_cast<double>(scene.views.size());
  const double least_height =
      on_floor ? options.floor * distance : -std::numeric_limits<double>::infinity();
  Attachment attachment;
  double level = 0;
  const std::vector<SeenPoints> seen = PointsOfViews(scene, masks, least_height);
  for (std::size_t v = 0; v < seen.size(); ++v) {
    const double reach = options.beside * std::max(masks[v].width, masks[v].height);
    for (const Seen& outside : seen[v].outside) {
      const Seen* inside = Nearest(seen[v].inside, outside, reach);
      if (!inside) continue;
      ++attachment.pairs;
      level += std::abs(outside.depth - inside->depth) < options.level * inside->depth;
    }
  }
  attachment.share = attachment.pairs > 0 ? level / attachment.pairs : 0;
  attachment.attached = attachment.pairs >= options.fewest && attachment.share >= kMost;
  return attachment;
}

double BeyondThePictures(const std::vector<Image8>& masks) {
  double beyond = 0;
  for (const Image8& mask : masks) {
    int left = 0, right = 0, top = 0, bottom = 0;
    for (int y = 0; y < mask.height; ++y) {
      left += *mask.at(0, y) > 127;
      right += *mask.at(mask.width - 1, y) > 127;
    }
    for (int x = 0; x < mask.width; ++x) {
      top += *mask.at(x, 0) > 127;
      bottom += *mask.at(x, mask.height - 1) > 127;
    }
    const int sides = (left > kOfASide * mask.height) + (right > kOfASide * mask.height) +
                      (top > kOfASide * mask.width) + (bottom > kOfASide * mask.width);
    beyond += sides >= 3;
  }
  return masks.empty() ? 0 : beyond / static_cast<double>(masks.size());
}

}  // namespace keypose::capture
