#include "capture/room/standing_figure.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <deque>
#include <limits>
#include <random>
#include <set>
#include <unordered_map>

#include "capture/room/piece_split.h"
#include "core/size_of.h"

namespace keypose::capture {
namespace {

using Eigen::Vector3d, Eigen::Vector3f, Eigen::Vector3i;

constexpr int kTries = 400;
constexpr double kLevel = 0.9;       // cosine: the surface of a plane, and the plane
constexpr double kOneSide = 0.9;     // of the cameras are above it
constexpr double kClear = 1.2;       // thicknesses: what is higher is not the plane
constexpr double kEnd = 0.97;        // of the reach: what goes on to here goes on beyond
constexpr double kNearStroke = 1.5;  // pixels
constexpr double kUpperEnd = 0.85;   // of the figure's height
constexpr int kFewest = 200;         // voxels

/// One point for each voxel of a sparse grid.
struct Voxel {
  Vector3i at;
  Vector3d sum = Vector3d::Zero();
  Vector3f outward = Vector3f::Zero(), colour = Vector3f::Zero();
  int count = 0;
  int first_view = -1;
  bool several = false;  ///< more views than one show it

  Vector3d Point() const { return sum / count; }
};

std::int64_t KeyOf(const Vector3i& at) {
  constexpr std::int64_t kOffset = 1 << 20;
  return ((at.x() + kOffset) << 42) | ((at.y() + kOffset) << 21) | (at.z() + kOffset);
}

class Grid {
 public:
  Grid(const CoarseDepths& depths, const Vector3d& middle, double side, double reach)
      : middle_(middle), side_(side) {
    for (std::size_t v = 0; v < depths.views.size(); ++v)
      for (const DepthSample& sample : depths.views[v]) {
        if ((sample.point - middle).norm() > reach) continue;
        Add(sample, static_cast<int>(v));
      }
  }

  const std::vector<Voxel>& voxels() const { return voxels_; }
  /// Index of the voxel that holds the point; -1: none.
  int Find(const Vector3d& x) const { return FindAt(CellOf(x)); }
  int FindAt(const Vector3i& at) const {
    const auto found = index_.find(KeyOf(at));
    return found == index_.end() ? -1 : found->second;
  }

 private:
  Vector3i CellOf(const Vector3d& x) const {
    const Vector3d cell = (x - middle_) / side_;
    return {static_cast<int>(std::floor(cell.x())), static_cast<int>(std::floor(cell.y())),
            static_cast<int>(std::floor(cell.z()))};
  }
  void Add(const DepthSample& sample, int view) {
    const Vector3i at = CellOf(sample.point);
    const auto [found, added] = index_.try_emplace(KeyOf(at), SizeOf(voxels_));
    if (added) {
      voxels_.emplace_back();
      voxels_.back().at = at;
      voxels_.back().first_view = view;
    }
    Voxel& voxel = voxels_[static_cast<std::size_t>(found->second)];
    voxel.sum += sample.point;
    voxel.outward += sample.outward;
    voxel.colour += sample.colour;
    ++voxel.count;
    voxel.several = voxel.several || voxel.first_view != view;
  }

  Vector3d middle_;
  double side_;
  std::vector<Voxel> voxels_;
  std::unordered_map<std::int64_t, int> index_;
};

/// Points of a surface, thinned to one a voxel.
struct Surface {
  std::vector<Vector3d> points;
  std::vector<Vector3d> normals;
};

Surface SurfaceOf(const Grid& grid) {
  Surface surface;
  for (const Voxel& voxel : grid.voxels()) {
    if (!voxel.several || voxel.outward.norm() < 1e-6F) continue;
    surface.points.push_back(voxel.Point());
    surface.normals.push_back(voxel.outward.cast<double>().normalized());
  }
  return surface;
}

bool IsBelow(const Support& plane, const std::vector<View>& views, const Vector3d& middle,
             double slack) {
  if (plane.Above(middle) < -slack) return false;
  const auto above = std::count_if(
      views.begin(), views.end(), [&](const View& view) { return plane.Above(view.Center()) > 0; });
  return static_cast<double>(above) >= kOneSide * static_cast<double>(views.size());
}

bool OnPlane(const Surface& surface, std::size_t i, const Support& plane, double thickness) {
  return std::abs(plane.Above(surface.points[i])) < thickness &&
         surface.normals[i].dot(plane.up) > kLevel;
}

int CountOn(const Surface& surface, const Support& plane, double thickness) {
  int count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    count += OnPlane(surface, i, plane, thickness);
  return count;
}

Support Refitted(const Surface& surface, const Support& plane, double thickness) {
  Vector3d mean = Vector3d::Zero();
  int count = 0;
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (OnPlane(surface, i, plane, thickness)) {
      mean += surface.points[i];
      ++count;
    }
  mean /= std::max(1, count);
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < surface.points.size(); ++i)
    if (OnPlane(surface, i, plane, thickness))
      scatter += (surface.points[i] - mean) * (surface.points[i] - mean).transpose();
  Vector3d up = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  if (up.dot(plane.up) < 0) up = -up;
  return {up, up.dot(mean)};
}

/// Whether a plane is a wall: cameras that are held upright look at it from the front, from the
/// left and from the right. A table's up is up in the pictures, also seen steeply.
bool IsWall(const Support& plane, const std::vector<View>& views, const Vector3d& middle,
            const StandingOptions& options) {
  std::vector<double> rises;
  Vector3d mean = Vector3d::Zero();
  for (const View& view : views) {
    rises.push_back(plane.up.dot((view.Center() - middle).normalized()));
    mean += view.camera_from_world.rotation * plane.up / static_cast<double>(views.size());
  }
  const auto half = rises.begin() + static_cast<std::ptrdiff_t>(rises.size() / 2);
  std::nth_element(rises.begin(), half, rises.end());
  return *half > options.steep && mean.head<2>().norm() < options.upright;
}

/// The plane with most of the surface.
std::optional<Support> LargestPlane(const Surface& surface, const std::vector<View>& views,
                                    const Vector3d& middle, double distance,
                                    const StandingOptions& options) {
  std::mt19937 random(1);
  const double thickness = options.thickness * distance;
  std::optional<Support> best;
  int most = 0;
  for (int t = 0; t < kTries; ++t) {
    const std::size_t i = random() % surface.points.size(), j = random() % surface.points.size(),
                      k = random() % surface.points.size();
    Vector3d up =
        (surface.points[j] - surface.points[i]).cross(surface.points[k] - surface.points[i]);
    if (up.norm() < 1e-3 * distance * distance) continue;
    up.normalize();
    if (up.dot(views.front().Center() - surface.points[i]) < 0) up = -up;
    const Support plane{up, up.dot(surface.points[i])};
    if (!IsBelow(plane, views, middle, 0.05 * distance)) continue;
    const int count = CountOn(surface, plane, thickness);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  if (!best) return std::nullopt;
  for (int round = 0; round < 3; ++round) best = Refitted(surface, *best, thickness);
  if (CountOn(surface, *best, thickness) < options.share * SizeOf(surface.points))
    return std::nullopt;
  return best;
}

/// Planes parallel to `lowest`, where there is more level surface than above and below, from the
/// highest to `lowest` itself.
std::vector<Support> PlanesAbove(const Surface& surface, const Support& lowest, double thickness) {
  std::vector<double> level;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const double above = lowest.Above(surface.points[i]);
    if (above < -thickness || surface.normals[i].dot(lowest.up) < kLevel) continue;
    const auto bin = static_cast<std::size_t>((above + thickness) / thickness);
    if (bin >= level.size()) level.resize(bin + 1, 0);
    level[bin] += 1;
  }
  std::vector<Support> planes;
  for (std::size_t bin = level.size(); bin-- > 4;) {
    const auto at = [&](std::size_t b) { return b < level.size() ? level[b] : 0.0; };
    const double here = at(bin) + std::max(at(bin - 1), at(bin + 1));
    if (at(bin) < std::max(at(bin - 1), at(bin + 1)) || here < kFewest / 4) continue;
    Support plane = lowest;
    plane.height += (static_cast<double>(bin) - 0.5) * thickness;
    planes.push_back(Refitted(surface, plane, thickness));
  }
  planes.push_back(lowest);
  return planes;
}

/// Connected voxels above a plane.
struct Pieces {
  std::vector<int> piece;  ///< by voxel; -1: none
  int count = 0;
};

Pieces PiecesAbove(const Grid& grid, const Support& plane, double clearance) {
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
int MiddlePiece(const Grid& grid, const Pieces& pieces, const Vector3d& middle,
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

Extent ExtentOf(const Grid& grid, const Pieces& pieces, int piece, const Support& plane) {
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
double PlaneAroundFoot(const Grid& grid, const Pieces& pieces, int piece, const Support& plane,
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

/// Voxels under a person's strokes.
struct Marks {
  std::vector<int> figure, other;
};

std::optional<Found> FindOn(const Grid& grid, const Support& plane, const Vector3d& middle,
                            const Marks& marks, double distance, double least_height,
                            const StandingOptions& options) {
  const double thickness = options.thickness * distance, side = options.voxel * distance;
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
std::vector<double> SharesInMasks(const Grid& grid, const Pieces& pieces,
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
void JoinAfloat(const Grid& grid, const std::vector<double>& shares, double afloat, double joins,
                Found& found) {
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

/// The voxels whose samples lie near a person's strokes.
void AddMarks(const Grid& grid, const std::vector<DepthSample>& samples,
              const std::vector<Eigen::Vector2i>& strokes, double near, std::vector<int>& marks) {
  for (const DepthSample& sample : samples) {
    const bool marked = std::any_of(strokes.begin(), strokes.end(), [&](const Eigen::Vector2i& s) {
      return (s.cast<double>() + Eigen::Vector2d(0.5, 0.5) - sample.pixel).norm() <= near;
    });
    if (const int voxel = marked ? grid.Find(sample.point) : -1; voxel >= 0) marks.push_back(voxel);
  }
}

Marks MarksOf(const Grid& grid, const CoarseDepths& depths,
              const std::vector<ViewStrokes>& strokes) {
  Marks marks;
  for (std::size_t v = 0; v < strokes.size(); ++v) {
    AddMarks(grid, depths.views[v], strokes[v].figure, kNearStroke, marks.figure);
    AddMarks(grid, depths.views[v], strokes[v].other, kNearStroke, marks.other);
  }
  return marks;
}

/// Takes away from the figure's piece the part that a person said is another thing. Where nothing
/// of the figure is marked, its upper end is the figure.
void SplitOff(const Grid& grid, const Marks& marks, Found& found) {
  std::vector<int> local(grid.voxels().size(), -1), members;
  for (std::size_t i = 0; i < local.size(); ++i)
    if (found.pieces.piece[i] == found.piece) {
      local[i] = SizeOf(members);
      members.push_back(static_cast<int>(i));
    }
  const auto in_piece = [&local](const std::vector<int>& voxels) {
    std::vector<int> in;
    for (const int voxel : voxels)
      if (const int l = local[static_cast<std::size_t>(voxel)]; l >= 0) in.push_back(l);
    return in;
  };
  const std::vector<int> other = in_piece(marks.other);
  std::vector<int> figure = in_piece(marks.figure);
  if (other.empty()) return;
  ColouredSurface surface;
  for (std::size_t l = 0; l < members.size(); ++l) {
    const Voxel& voxel = grid.voxels()[static_cast<std::size_t>(members[l])];
    surface.colours.push_back(voxel.colour / static_cast<float>(voxel.count));
    surface.neighbours.emplace_back();
    for (int k = 0; k < 27; ++k) {
      const int n = grid.FindAt(voxel.at + Vector3i(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
      if (n >= 0 && local[static_cast<std::size_t>(n)] >= 0)
        surface.neighbours.back().push_back(local[static_cast<std::size_t>(n)]);
    }
    if (marks.figure.empty() && found.support.Above(voxel.Point()) > kUpperEnd * found.height)
      figure.push_back(static_cast<int>(l));
  }
  if (figure.empty()) return;
  const std::vector<char> is_other = OtherPart(surface, figure, other);
  for (std::size_t l = 0; l < members.size(); ++l)
    if (is_other[l]) found.pieces.piece[static_cast<std::size_t>(members[l])] = found.pieces.count;
  ++found.pieces.count;
}

Stands StandsOf(const Grid& grid, const Found& found, const Vector3d& x, double thickness) {
  const double above = found.support.Above(x);
  if (above < kClear / 2 * thickness) return Stands::kSupport;
  const int voxel = grid.Find(x);
  if (voxel < 0) return Stands::kOther;
  const int piece = found.pieces.piece[static_cast<std::size_t>(voxel)];
  if (piece == found.piece) return Stands::kFigure;
  return piece >= 0 ? Stands::kOther : Stands::kOpen;
}

}  // namespace

std::optional<StandingFigure> FindStandingFigure(const CoarseDepths& depths,
                                                 const std::vector<View>& views,
                                                 const Vector3d& middle, const Opinions& opinions,
                                                 const StandingOptions& options) {
  const double distance = depths.distance, thickness = options.thickness * distance;
  const Grid grid(depths, middle, options.voxel * distance, options.reach * distance);
  const Surface surface = SurfaceOf(grid);
  if (SizeOf(surface.points) < kFewest) return std::nullopt;
  const auto lowest = LargestPlane(surface, views, middle, distance, options);
  if (!lowest) return std::nullopt;
  const Marks marks = MarksOf(grid, depths, opinions.strokes);
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
  figure.on_wall = IsWall(*lowest, views, middle, options);
  for (std::size_t i = 0; i < grid.voxels().size(); ++i)
    if (found->pieces.piece[i] == found->piece) figure.points.push_back(grid.voxels()[i].Point());
  const double end = kEnd * options.reach * distance;
  if (std::any_of(figure.points.begin(), figure.points.end(),
                  [&](const Vector3d& x) { return (x - middle).norm() > end; }))
    return std::nullopt;
  for (const std::vector<DepthSample>& samples : depths.views) {
    figure.samples.emplace_back();
    for (const DepthSample& sample : samples)
      figure.samples.back().push_back(StandsOf(grid, *found, sample.point, thickness));
  }
  return figure;
}

}  // namespace keypose::capture
