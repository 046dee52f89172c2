#include "core/pictures/sight_lines.h"

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// [px] from the rim of a mask's hole; masks are accurate to a pixel or two
constexpr int kMargin = 3;
constexpr int kLinesAHole = 64;  // approximate upper limit

enum : int { kFigure = -1, kFree = -2, kOutside = -3 };  // labels of pixels; holes count from 0

void Flood(ImageT<int>& label, int x, int y, int from, int to,
           std::vector<std::pair<int, int>>* found) {
  std::vector<std::pair<int, int>> stack = {{x, y}};
  *label.at(x, y) = to;
  while (!stack.empty()) {
    const auto [px, py] = stack.back();
    stack.pop_back();
    if (found) found->emplace_back(px, py);
    const std::pair<int, int> next[4] = {{px + 1, py}, {px - 1, py}, {px, py + 1}, {px, py - 1}};
    for (const auto& [qx, qy] : next) {
      if (qx < 0 || qy < 0 || qx >= label.width || qy >= label.height || *label.at(qx, qy) != from)
        continue;
      *label.at(qx, qy) = to;
      stack.emplace_back(qx, qy);
    }
  }
}

using Pixels = std::vector<std::pair<int, int>>;

/// The background pixels that are not connected to the image's border, hole by hole.
std::vector<Pixels> HolesOf(const Image8& mask) {
  ImageT<int> label(mask.width, mask.height, 1, kFree);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*mask.at(x, y) > 127) *label.at(x, y) = kFigure;
  const auto from_border = [&](int x, int y) {
    if (*label.at(x, y) == kFree) Flood(label, x, y, kFree, kOutside, nullptr);
  };
  for (int x = 0; x < mask.width; ++x) {
    from_border(x, 0);
    from_border(x, mask.height - 1);
  }
  for (int y = 0; y < mask.height; ++y) {
    from_border(0, y);
    from_border(mask.width - 1, y);
  }
  std::vector<Pixels> holes;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (*label.at(x, y) == kFree) Flood(label, x, y, kFree, SizeOf(holes), &holes.emplace_back());
  return holes;
}

/// The pixels of a hole with no pixel of the figure within the margin, reduced to a few.
Pixels Inner(const Image8& mask, const Pixels& hole) {
  Pixels inner;
  for (const auto& [x, y] : hole) {
    bool clear = true;
    for (int dy = -kMargin; dy <= kMargin && clear; ++dy)
      for (int dx = -kMargin; dx <= kMargin && clear; ++dx) {
        if (dx * dx + dy * dy >= kMargin * kMargin) continue;
        const int px = std::clamp(x + dx, 0, mask.width - 1),
                  py = std::clamp(y + dy, 0, mask.height - 1);
        clear = *mask.at(px, py) <= 127;
      }
    if (clear) inner.emplace_back(x, y);
  }
  std::sort(inner.begin(), inner.end());
  Pixels few;
  const std::size_t step = inner.size() / kLinesAHole + 1;
  for (std::size_t i = step / 2; i < inner.size(); i += step) few.push_back(inner[i]);
  return few;
}

}  // namespace

std::vector<SightLine> LinesThroughHoles(const std::vector<View>& views,
                                         const std::vector<Image8>& masks) {
  std::vector<SightLine> lines;
  int hole_count = 0;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const Image8& mask = masks[v];
    if (mask.empty()) continue;
    const Rigid3 world_from_camera = views[v].camera_from_world.Inverse();
    const double across = static_cast<double>(views[v].camera.width) / mask.width,
                 down = static_cast<double>(views[v].camera.height) / mask.height;
    for (const Pixels& hole : HolesOf(mask)) {
      const Pixels inner = Inner(mask, hole);
      for (const auto& [x, y] : inner) {
        const Vector3d ray =
            views[v].camera.Unproject(Vector2d((x + 0.5) * across, (y + 0.5) * down));
        lines.push_back({world_from_camera.translation, world_from_camera.rotation * ray,
                         static_cast<int>(v), hole_count});
      }
      hole_count += !inner.empty();
    }
  }
  return lines;
}

std::vector<int> ClosedHoles(const Mesh& surface, const std::vector<SightLine>& lines) {
  if (lines.empty()) return {};
  const RayScene scene(surface.points, surface.faces);
  std::map<int, bool> open;
  for (const SightLine& line : lines)
    open[line.hole] = open[line.hole] || !scene.Occluded(line.origin, line.direction, 0,
                                                         std::numeric_limits<double>::infinity());
  std::vector<int> holes;
  for (const auto& [hole, is_open] : open)
    if (!is_open) holes.push_back(hole);
  return holes;
}

std::vector<int> ViewsWithClosedWindow(const Mesh& surface, const std::vector<SightLine>& lines) {
  const std::vector<int> holes = ClosedHoles(surface, lines);
  std::set<int> views;
  for (const SightLine& line : lines)
    if (std::binary_search(holes.begin(), holes.end(), line.hole)) views.insert(line.view);
  return {views.begin(), views.end()};
}

}  // namespace keypose
