#include "capture/room/lined_thing.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "capture/room/piece_split.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector3d, Eigen::Vector3i;

constexpr double kUpperEnd = 0.85;  // of the figure's height
constexpr double kLine = 4;         // voxels: marks as long as this are a line
// How wide another thing is, in lengths of the line over it; which fits is seen by the border that
// it leaves. In such widths: how far behind the line its middle is, how far from that it goes
// likely, surely, and surely not; and what heights above and below the line count, as things stand,
// and are often taller than wide.
constexpr double kWidths[] = {0.8, 1.1, 1.5};
constexpr double kBehind = 0.45, kThing = 0.75, kInThing = 0.4, kBeyondThing = 1.6;
constexpr double kAboveLine = 0.6, kBelowLine = 0.2;

/// Where the thing is likely that a line was drawn over.
struct LinedThing {
  Vector3d middle = Vector3d::Zero();
  double width = 0;  ///< 0: there is no line

  /// From the middle, in widths.
  double From(const Vector3d& x, const Vector3d& up) const {
    const Vector3d apart = x - middle;
    const double higher = apart.dot(up);
    return (apart - (1 - (higher > 0 ? kAboveLine : kBelowLine)) * higher * up).norm() / width;
  }
};

/// The longest level line between marks, without its width's factor; its middle is on the line.
LinedThing LineOver(const VoxelGrid& grid, const std::vector<int>& marks, const Vector3d& up) {
  LinedThing thing;
  for (const int a : marks)
    for (const int b : marks) {
      const Vector3d from = grid.voxels()[static_cast<std::size_t>(a)].Point(),
                     to = grid.voxels()[static_cast<std::size_t>(b)].Point();
      const Vector3d apart = to - from;
      const double width = (apart - apart.dot(up) * up).norm();
      if (width > thing.width) thing = {0.5 * (from + to), width};
    }
  return thing.width < kLine * grid.side() ? LinedThing{} : thing;
}

/// The figure's piece, as a surface of its own.
struct Members {
  std::vector<int> voxels;
  ColouredSurface surface;
  std::vector<int> figure, other;  ///< marked, as indices into voxels
};

Members MembersOf(const VoxelGrid& grid, const std::vector<int>& piece, const StrokeMarks& marks,
                  const Support& support, double height) {
  Members members;
  members.voxels = piece;
  std::vector<int> local(grid.voxels().size(), -1);
  for (std::size_t l = 0; l < piece.size(); ++l)
    local[static_cast<std::size_t>(piece[l])] = static_cast<int>(l);
  for (const int v : members.voxels) {
    const Voxel& voxel = grid.voxels()[static_cast<std::size_t>(v)];
    members.surface.colours.push_back(voxel.colour / static_cast<float>(voxel.count));
    members.surface.neighbours.emplace_back();
    for (int k = 0; k < 27; ++k) {
      const int n = grid.FindAt(voxel.at + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      if (n >= 0 && local[static_cast<std::size_t>(n)] >= 0)
        members.surface.neighbours.back().push_back(local[static_cast<std::size_t>(n)]);
    }
  }
  const auto add = [&local](const std::vector<int>& voxels, std::vector<int>& to) {
    for (const int voxel : voxels)
      if (const int l = local[static_cast<std::size_t>(voxel)]; l >= 0) to.push_back(l);
  };
  add(marks.figure, members.figure);
  add(marks.other, members.other);
  // Where nothing of the figure is marked, its upper end is the figure.
  for (int l = 0; marks.figure.empty() && l < SizeOf(members.voxels); ++l) {
    const Voxel& voxel = grid.voxels()[static_cast<std::size_t>(members.voxels[l])];
    if (support.Above(voxel.Point()) > kUpperEnd * height) members.figure.push_back(l);
  }
  return members;
}

/// What places say of members, if the thing is where it is said to be. A thing with little texture
/// has gaps, so that the line may lie on a piece of its own: then what is surely in the thing is
/// marked.
void LeanTowards(const LinedThing& thing, const VoxelGrid& grid, const Vector3d& up,
                 Members& members) {
  const bool elsewhere = members.other.empty();
  for (int l = 0; l < SizeOf(members.voxels); ++l) {
    const double from =
        thing.From(grid.voxels()[static_cast<std::size_t>(members.voxels[l])].Point(), up);
    members.surface.lean.push_back(
        static_cast<float>(std::clamp((kThing - from) / (kThing - kInThing), -1.0, 1.0)));
    if (from > kBeyondThing) members.figure.push_back(l);
    if (elsewhere && from < kInThing) members.other.push_back(l);
  }
}

}  // namespace

std::vector<char> OtherThingIn(const VoxelGrid& grid, const std::vector<int>& piece,
                               const StrokeMarks& marks, const Support& support, double height) {
  const Members members = MembersOf(grid, piece, marks, support, height);
  const Vector3d& up = support.up;
  const LinedThing line = LineOver(grid, marks.other, up);
  const auto split = [](const Members& marked) {
    return marked.other.empty() || marked.figure.empty()
               ? std::vector<char>{}
               : OtherPart(marked.surface, marked.figure, marked.other);
  };
  if (line.width == 0) return split(members);
  std::vector<char> best;
  double least = std::numeric_limits<double>::infinity();
  for (const double factor : kWidths) {
    LinedThing thing = line;
    thing.width *= factor;
    thing.middle += kBehind * thing.width * (marks.sight - marks.sight.dot(up) * up);
    Members leaning = members;
    LeanTowards(thing, grid, up, leaning);
    std::vector<char> is_other = split(leaning);
    const double cost = BorderOf(members.surface, is_other);
    if (cost >= least) continue;
    least = cost;
    best = std::move(is_other);
  }
  return best;
}

}  // namespace keypose::capture
