#include "capture/room/stroke_marks.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <set>

namespace keypose::capture {
namespace {

using Eigen::Vector3d;

constexpr double kNearStroke = 1.5;  // pixels

/// The nearest voxel that a view shows under each pixel of the strokes.
void AddMarks(const VoxelGrid& grid, const View& view, const std::vector<Eigen::Vector2i>& strokes,
              std::vector<int>& marks) {
  if (strokes.empty()) return;
  struct Front {
    double depth = std::numeric_limits<double>::infinity();
    int voxel = -1;
  };
  std::vector<Front> fronts(strokes.size());
  for (std::size_t i = 0; i < grid.voxels().size(); ++i) {
    if (!grid.voxels()[i].several) continue;
    const Vector3d x = view.camera_from_world * grid.voxels()[i].Point();
    if (x.z() <= 0) continue;
    const Eigen::Vector2d p = view.camera.Project(x);
    const double near = std::max(kNearStroke, 0.6 * grid.side() * view.camera.fx / x.z());
    for (std::size_t s = 0; s < strokes.size(); ++s) {
      const Eigen::Vector2d at = strokes[s].cast<double>() + Eigen::Vector2d(0.5, 0.5);
      if (x.z() < fronts[s].depth && (at - p).lpNorm<Eigen::Infinity>() <= near)
        fronts[s] = {x.z(), static_cast<int>(i)};
    }
  }
  std::set<int> marked;
  for (const Front& front : fronts)
    if (front.voxel >= 0) marked.insert(front.voxel);
  marks.insert(marks.end(), marked.begin(), marked.end());
}

}  // namespace

StrokeMarks MarksOf(const VoxelGrid& grid, const std::vector<View>& views,
                    const std::vector<ViewStrokes>& strokes) {
  StrokeMarks marks;
  for (std::size_t v = 0; v < strokes.size(); ++v) {
    AddMarks(grid, views[v], strokes[v].figure, marks.figure);
    const std::size_t before = marks.other.size();
    AddMarks(grid, views[v], strokes[v].other, marks.other);
    for (std::size_t m = before; m < marks.other.size(); ++m) {
      const Vector3d at = grid.voxels()[static_cast<std::size_t>(marks.other[m])].Point();
      marks.sight += (at - views[v].Center()).normalized();
    }
  }
  if (!marks.other.empty()) marks.sight /= static_cast<double>(marks.other.size());
  return marks;
}

}  // namespace keypose::capture
