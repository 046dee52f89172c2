#include "capture/room/standing_figure.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <set>

#include "capture/room/lined_thing.h"
#include "capture/room/stroke_marks.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector3d, Eigen::Vector3i;

constexpr double kClear = 1.2;  // thicknesses: what is higher is not the plane
constexpr double kEnd = 0.97;   // of the reach: what goes on to here goes on beyond
constexpr int kFewest = 200;    // voxels

/// Connected voxels above a plane.
struct Pieces {
  std::vector<int> piece;  ///< by voxel; -1: none
  int count = 0;
};

Pieces PiecesAbove(const VoxelGrid& grid, const Support& plane, double clearance) {
  const std::vector<Voxel>& voxels = grid.voxels();
  Pieces pieces{std::vector<int>(voxels.size(), -1), 0};
  const auto counts = [&](std::size_t i) {
    return voxels[i].several && plane.Above(voxels[i].Point()) > clearance;
  };
  for (std::size_t seed = 0; seed < voxels.size(); ++seed) {
    if (pieces.piece[seed] >= 0 || !counts(seed)) continue;
    std::deque<std::size_t> open{seed};
    pieces.piece[seed] = pieces.count;
    while (!open.empty()) {
      const std::size_t i = open.front();
      open.pop_front();
      for (int k = 0; k < 27; ++k) {
        const Vector3i at = voxels[i].at + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        const int other = grid.FindAt(at);
        if (other < 0 || pieces.piece[static_cast<std::size_t>(other)] >= 0 ||
            !counts(static_cast<std::size_t>(other)))
          continue;
        pieces.piece[static_cast<std::size_t>(other)] = pieces.count;
        open.push_back(static_cast<std::size_t>(other));
      }
    }
    ++pieces.count;
  }
  return pieces;
}

double FromAxis(const Vector3d& x, const Vector3d& middle, const Vector3d& up) {
  const Vector3d d = x - middle;
  return (d - d.dot(up) * up).norm();
}

/// The piece with most surface near the axis through the middle; -1: none.
int MiddlePiece(const VoxelGrid& grid, const Pieces& pieces, const Vector3d& middle,
                const Support& plane, double spread) {
  std::vector<double> score(static_cast<std::size_t>(pieces.count), 0);
  for (std::size_t i = 0; i < grid.voxels().size(); ++i) {
    if (pieces.piece[i] < 0) continue;
    const double away = FromAxis(grid.voxels()[i].Point(), middle, plane.up) / spread;
    score[static_cast<std::size_t>(pieces.piece[i])] += std::exp(-0.5 * away * away);
  }
  const auto best = std::max_element(score.begin(), score.end());
  return best == score.end() ? -1 : static_cast<int>(best - score.begin());
}

/// The piece with most marks; -1: none is marked.
int MarkedPiece(const Pieces& pieces, const std::vector<int>& marks) {
  std::vector<int> count(static_cast<std::size_t>(pieces.count), 0);
  for (const int voxel : marks)
    if (const int piece = pieces.piece[static_cast<std::size_t>(voxel)]; piece >= 0)
      ++count[static_cast<std::size_t>(piece)];
  const auto best = std::max_element(count.begin(), count.end());
  return best == count.end() || *best == 0 ? -1 : static_cast<int>(best - count.begin());
}

/// How much of a piece there is, and how tall it is.
struct Extent {
  int voxels = 0;
  double top = 0;
};

Extent ExtentOf(const VoxelGrid& grid, const Pieces& pieces, int piece, const Support& plane) {
  Extent extent;
  for (std::size_t i = 0; i < grid.voxels().size(); ++i) {
    if (pieces.piece[i] != piece) continue;
    ++extent.voxels;
    extent.top = std::max(extent.top, plane.Above(grid.voxels()[i].Point()));
  }
  return extent;
}

/// Cells of a plane, of the grid's size.
class Footprint {
 public:
  Footprint(const Support& plane, double side) : side_(side) {
    x_ = plane.up.unitOrthogonal();
    y_ = plane.up.cross(x_);
  }
  void Add(const Vector3d& x) { cells_.insert(Cell(x)); }
  bool Has(const std::pair<int, int>& cell) const { return cells_.count(cell) > 0; }
  const std::set<std::pair<int, int>>& cells() const { return cells_; }
  std::pair<int, int> Cell(const Vector3d& x) const {
    return {static_cast<int>(std::floor(x.dot(x_) / side_)),
            static_cast<int>(std::floor(x.dot(y_) / side_))};
  }

 private:
  double side_;
  Vector3d x_, y_;
  std::set<std::pair<int, int>> cells_;
};

/// The share of the surroundings of a piece's foot that are the plane's surface.
double PlaneAroundFoot(const VoxelGrid& grid, const Pieces& pieces, int piece, const Support& plane,
                       double thickness, double side) {
  Footprint foot(plane, 2 * side), level(plane, 2 * side);
  for (std::size_t i = 0; i < grid.voxels().size(); ++i) {
    const Voxel& voxel = grid.voxels()[i];
    const double above = plane.Above(voxel.Point());
    if (pieces.piece[i] == piece && above < 6 * thickness) foot.Add(voxel.Point());
    if (std::abs(above) < thickness) level.Add(voxel.Point());
  }
  int around = 0, on = 0;
  std::set<std::pair<int, int>> seen;
  for (const auto& [x, y] : foot.cells())
    for (int k = 0; k < 25; ++k) {
      const std::pair<int, int> cell{x + k % 5 - 2, y + k / 5 - 2};
      if (foot.Has(cell) || !seen.insert(cell).second) continue;
      ++around;
      on += level.Has(cell);
    }
  return around > 0 ? static_cast<double>(on) / around : 0;
}

struct Found {
  Support support;
  Pieces pieces;
  int piece = -1;
  double height = 0;
};

std::optional<Found> FindOn(const VoxelGrid& grid, const Support& plane, const Vector3d& middle,
                            const StrokeMarks& marks, double distance, double least_height,
                            const StandingOptions& options) {
  const double thickness = options.plane.thickness * distance, side = options.voxel * distance;
  Found found{plane, PiecesAbove(grid, plane, kClear * thickness), -1, 0};
  found.piece = marks.figure.empty()
                    ? MiddlePiece(grid, found.pieces, middle, plane, 0.12 * distance)
                    : MarkedPiece(found.pieces, marks.figure);
  if (found.piece < 0) return std::nullopt;
  const Extent extent = ExtentOf(grid, found.pieces, found.piece, plane);
  found.height = extent.top;
  if (extent.voxels < kFewest || extent.top < least_height) return std::nullopt;
  if (PlaneAroundFoot(grid, found.pieces, found.piece, plane, thickness, side) < options.round)
    return std::nullopt;
  return found;
}

/// Of each piece the shares of its samples that opinions have in their masks; 0 where there is
/// none.
std::vector<double> SharesInMasks(const VoxelGrid& grid, const Pieces& pieces,
                                  const CoarseDepths& depths, const std::vector<Image8>& masks) {
  std::vector<double> in(static_cast<std::size_t>(pieces.count), 0), all(in);
  for (std::size_t v = 0; v < masks.size(); ++v) {
    const Image8& mask = masks[v];
    if (mask.empty()) continue;
    for (const DepthSample& sample : depths.views[v]) {
      const int voxel = grid.Find(sample.point);
      const int x = static_cast<int>(std::floor(sample.pixel.x())),
                y = static_cast<int>(std::floor(sample.pixel.y()));
      if (voxel < 0 || x < 0 || y < 0 || x >= mask.width || y >= mask.height) continue;
      const int piece = pieces.piece[static_cast<std::size_t>(voxel)];
      if (piece < 0) continue;
      all[static_cast<std::size_t>(piece)] += 1;
      in[static_cast<std::size_t>(piece)] += *mask.at(x, y) > 127;
    }
  }
  for (std::size_t p = 0; p < in.size(); ++p) in[p] = all[p] > 0 ? in[p] / all[p] : 0;
  return in;
}

/// Joins to the figure's piece those that stand on nothing and that opinions have in their masks.
void JoinAfloat(const VoxelGrid& grid, const std::vector<double>& shares, double afloat,
                double joins, Found& found) {
  std::vector<double> lowest(shares.size(), std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < grid.voxels().size(); ++i)
    if (const int piece = found.pieces.piece[i]; piece >= 0) {
      double& low = lowest[static_cast<std::size_t>(piece)];
      low = std::min(low, found.support.Above(grid.voxels()[i].Point()));
    }
  for (std::size_t i = 0; i < grid.voxels().size(); ++i) {
    int& piece = found.pieces.piece[i];
    if (piece < 0 || lowest[static_cast<std::size_t>(piece)] < afloat ||
        shares[static_cast<std::size_t>(piece)] < joins)
      continue;
    piece = found.piece;
    found.height = std::max(found.height, found.support.Above(grid.voxels()[i].Point()));
  }
}

/// Takes away from the figure's piece the part that a person said is another thing.
void SplitOff(const VoxelGrid& grid, const StrokeMarks& marks, Found& found) {
  if (marks.other.empty()) return;
  std::vector<int> piece;
  for (std::size_t i = 0; i < grid.voxels().size(); ++i)
    if (found.pieces.piece[i] == found.piece) piece.push_back(static_cast<int>(i));
  const std::vector<char> is_other = OtherThingIn(grid, piece, marks, found.support, found.height);
  for (std::size_t l = 0; l < is_other.size(); ++l)
    if (is_other[l]) found.pieces.piece[static_cast<std::size_t>(piece[l])] = found.pieces.count;
  ++found.pieces.count;
}

/// Points of the other pieces, without those so small that they may be wrong depths.
std::vector<Vector3d> OtherThings(const VoxelGrid& grid, const Found& found) {
  std::vector<int> size(static_cast<std::size_t>(found.pieces.count), 0);
  for (const int piece : found.pieces.piece)
    if (piece >= 0) ++size[static_cast<std::size_t>(piece)];
  std::vector<Vector3d> points;
  for (std::size_t i = 0; i < grid.voxels().size(); ++i)
    if (const int piece = found.pieces.piece[i];
        piece >= 0 && piece != found.piece && size[static_cast<std::size_t>(piece)] >= kFewest)
      points.push_back(grid.voxels()[i].Point());
  return points;
}

SampleLabel LabelOfSample(const VoxelGrid& grid, const Found& found, const Vector3d& x,
                          double thickness) {
  const double above = found.support.Above(x);
  if (above < kClear / 2 * thickness) return SampleLabel::kSupport;
  const int voxel = grid.Find(x);
  if (voxel < 0) return SampleLabel::kOther;
  const int piece = found.pieces.piece[static_cast<std::size_t>(voxel)];
  if (piece == found.piece) return SampleLabel::kFigure;
  return piece >= 0 ? SampleLabel::kOther : SampleLabel::kOpen;
}

}  // namespace

std::optional<StandingFigure> FindStandingFigure(const CoarseDepths& depths,
                                                 const std::vector<View>& views,
                                                 const Vector3d& middle, const Opinions& opinions,
                                                 const StandingOptions& options) {
  const double distance = depths.distance, thickness = options.plane.thickness * distance;
  const VoxelGrid grid(depths, middle, options.voxel * distance, options.reach * distance);
  const ThinSurface surface = SurfaceOf(grid);
  if (SizeOf(surface.points) < kFewest) return std::nullopt;
  const auto lowest = LargestPlane(surface, views, middle, distance, options.plane);
  if (!lowest) return std::nullopt;
  const StrokeMarks marks = MarksOf(grid, views, opinions.strokes);
  const std::optional<Found> on_lowest = FindOn(grid, *lowest, middle, marks, distance, 0, options);
  const double whole = on_lowest ? on_lowest->height : 0;
  std::optional<Found> found;
  for (const Support& plane : PlanesAbove(surface, *lowest, thickness)) {
    found = FindOn(grid, plane, middle, marks, distance, options.tall * whole, options);
    if (found) break;
  }
  if (!found) return std::nullopt;
  SplitOff(grid, marks, *found);
  JoinAfloat(grid, SharesInMasks(grid, found->pieces, depths, opinions.masks),
             options.afloat * distance, options.joins, *found);
  StandingFigure figure;
  figure.support = found->support;
  figure.height = found->height;
  figure.spacing = options.voxel * distance;
  figure.on_wall = IsWall(*lowest, views, middle, options.plane);
  for (std::size_t i = 0; i < grid.voxels().size(); ++i)
    if (found->pieces.piece[i] == found->piece) figure.points.push_back(grid.voxels()[i].Point());
  figure.others = OtherThings(grid, *found);
  const double end = kEnd * options.reach * distance;
  if (std::any_of(figure.points.begin(), figure.points.end(),
                  [&](const Vector3d& x) { return (x - middle).norm() > end; }))
    return std::nullopt;
  for (const std::vector<DepthSample>& samples : depths.views) {
    figure.samples.emplace_back();
    for (const DepthSample& sample : samples)
      figure.samples.back().push_back(LabelOfSample(grid, *found, sample.point, thickness));
  }
  return figure;
}

}  // namespace keypose::capture
