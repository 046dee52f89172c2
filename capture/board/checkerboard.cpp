#include "capture/board/checkerboard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "capture/board/grey_level.h"
#include "capture/board/markers.h"
#include "core/values/size_of.h"

namespace keypose::capture {
namespace {

using Point = cv::Point2d;
using Cell = std::pair<int, int>;  // column, row

constexpr int kRing = 32;               // samples of a ring around a corner
constexpr double kSectorContrast = 25;  // grey levels between dark and bright sectors
constexpr int kLeastSide = 3;           // corners

/// Where four sectors meet.
struct Saddle {
  Point at;
  std::array<Point, 2> edges;  // unit, along the two lines between sectors
  Point dark;                  // unit, into a dark sector
  double strength = 0;
};

double Level(const cv::Mat& grey, const Point& p) { return LevelAt(grey, p.x, p.y); }

Point Along(double angle) { return {std::cos(angle), std::sin(angle)}; }

/// The ring around a corner, where it has two dark and two bright arcs.
std::optional<Saddle> RingOf(const cv::Mat& grey, const Point& at, double radius_px) {
  if (at.x < radius_px || at.y < radius_px || at.x > grey.cols - 1 - radius_px ||
      at.y > grey.rows - 1 - radius_px)
    return {};
  constexpr double kStep = 2 * std::numbers::pi / kRing;
  std::array<double, kRing> level;
  for (int i = 0; i < kRing; ++i) level[i] = Level(grey, at + radius_px * Along(i * kStep));
  const auto [low, high] = std::minmax_element(level.begin(), level.end());
  if (*high - *low < kSectorContrast) return {};
  const double middle = (*low + *high) / 2;
  std::vector<double> crossings;
  int first_dark = -1;  // of the crossings, that which leads into the dark
  for (int i = 0; i < kRing; ++i) {
    const double a = level[i] - middle, b = level[(i + 1) % kRing] - middle;
    if ((a < 0) == (b < 0)) continue;
    if (b < 0 && first_dark < 0) first_dark = SizeOf(crossings);
    crossings.push_back((i + a / (a - b)) * kStep);
  }
  if (crossings.size() != 4) return {};
  Saddle saddle;
  saddle.at = at;
  for (int k = 0; k < 2; ++k) {
    // Opposite crossings lie on one line through the corner.
    const Point a = Along(crossings[k]), b = Along(crossings[k + 2]);
    if (a.dot(b) > -0.8) return {};
    saddle.edges[k] = (a - b) / cv::norm(a - b);
  }
  const double from = crossings[first_dark], to = crossings[(first_dark + 1) % 4];
  const double arc = std::fmod(to - from + 2 * std::numbers::pi, 2 * std::numbers::pi);
  saddle.dark = Along(from + arc / 2);
  saddle.strength = *high - *low;
  return saddle;
}

/// Where the Hessian's negative determinant peaks, and a ring agrees.
std::vector<Saddle> SaddlesOf(const cv::Mat& grey) {
  constexpr float kLeastResponse = 3;  // of a contrast of kSectorContrast after the blur
  cv::Mat smooth, xx, yy, xy, highest;
  grey.convertTo(smooth, CV_32F);
  cv::GaussianBlur(smooth, smooth, {0, 0}, 1.5);
  cv::Sobel(smooth, xx, CV_32F, 2, 0, 3, 0.25);
  cv::Sobel(smooth, yy, CV_32F, 0, 2, 3, 0.25);
  cv::Sobel(smooth, xy, CV_32F, 1, 1, 3, 0.25);
  const cv::Mat response = xy.mul(xy) - xx.mul(yy);
  cv::dilate(response, highest, cv::Mat::ones(5, 5, CV_8U));
  std::vector<Saddle> saddles;
  for (int y = 2; y < grey.rows - 2; ++y)
    for (int x = 2; x < grey.cols - 2; ++x) {
      const float value = response.at<float>(y, x);
      if (value < kLeastResponse || value < highest.at<float>(y, x)) continue;
      for (const double radius : {5.0, 3.0})
        if (std::optional<Saddle> saddle = RingOf(grey, Point(x, y), radius)) {
          saddles.push_back(*saddle);
          break;
        }
    }
  return saddles;
}

/// Joins saddles to a grid, from one of them.
class GridGrower {
 public:
  explicit GridGrower(const std::vector<Saddle>& saddles) : saddles_(saddles) {}

  std::map<Cell, int> Grow(int seed, const std::vector<bool>& taken) {
    cells_.clear();
    used_ = taken;
    Put({0, 0}, seed);
    const Saddle& s = saddles_[seed];
    std::deque<Cell> open{{0, 0}};
    axes_ = {s.edges[0], s.edges[1]};
    while (!open.empty()) {
      const Cell cell = open.front();
      open.pop_front();
      for (const auto& [dx, dy] : {Cell{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
        const Cell next{cell.first + dx, cell.second + dy};
        if (cells_.count(next)) continue;
        const int found = Next(cell, {dx, dy});
        if (found < 0) continue;
        Put(next, found);
        open.push_back(next);
      }
    }
    return cells_;
  }

 private:
  void Put(const Cell& cell, int saddle) {
    cells_[cell] = saddle;
    used_[saddle] = true;
  }
  const Point* At(int column, int row) const {
    const auto found = cells_.find({column, row});
    return found == cells_.end() ? nullptr : &saddles_[found->second].at;
  }
  /// The step from a cell to its neighbour, as the cells behind and beside it take it.
  std::optional<Point> Step(const Cell& cell, const Cell& by) const {
    const Point here = *At(cell.first, cell.second);
    if (const Point* behind = At(cell.first - by.first, cell.second - by.second))
      return here - *behind;
    for (const int side : {1, -1}) {
      const Cell beside{cell.first + side * by.second, cell.second + side * by.first};
      const Point* from = At(beside.first, beside.second);
      const Point* to = At(beside.first + by.first, beside.second + by.second);
      if (from && to) return *to - *from;
    }
    return {};
  }
  int Next(const Cell& cell, const Cell& by) const {
    const Saddle& from = saddles_[cells_.at(cell)];
    if (const std::optional<Point> step = Step(cell, by)) return Nearest(from, *step);
    return First(from, by);
  }
  /// The saddle where a step of known length leads.
  int Nearest(const Saddle& from, const Point& step) const {
    constexpr double kReach = 0.35;  // of the step
    const Point goal = from.at + step;
    double least = kReach * cv::norm(step);
    int best = -1;
    for (int i = 0; i < SizeOf(saddles_); ++i) {
      const double distance = cv::norm(saddles_[i].at - goal);
      if (distance < least && !used_[i] && Alternates(from, saddles_[i])) {
        least = distance;
        best = i;
      }
    }
    return best;
  }
  /// The nearest saddle along one of the first corner's edges.
  int First(const Saddle& from, const Cell& by) const {
    constexpr double kWithin = 0.94;  // cosine
    const Point axis = by.first != 0 ? by.first * axes_[0] : by.second * axes_[1];
    double least = 1e300;
    int best = -1;
    for (int i = 0; i < SizeOf(saddles_); ++i) {
      const Point way = saddles_[i].at - from.at;
      const double distance = cv::norm(way);
      if (used_[i] || distance >= least || way.dot(axis) < kWithin * distance) continue;
      if (Alternates(from, saddles_[i])) {
        least = distance;
        best = i;
      }
    }
    return best;
  }
  /// Neighbours share a line between sectors, and dark lies on its other side.
  static bool Alternates(const Saddle& a, const Saddle& b) {
    constexpr double kParallel = 0.88;  // cosine; strong perspective turns edges
    const Point way = (b.at - a.at) / cv::norm(b.at - a.at);
    const auto along = [&](const Saddle& s) {
      return std::max(std::abs(s.edges[0].dot(way)), std::abs(s.edges[1].dot(way))) > kParallel;
    };
    if (!along(a) || !along(b)) return false;
    // The dark sector of `a` that looks towards `b` lies on one side of the way, and so does the
    // one of `b` that looks back: it is one square.
    const Point ahead = a.dark.dot(way) > 0 ? a.dark : -a.dark;
    const Point back = b.dark.dot(way) < 0 ? b.dark : -b.dark;
    return way.cross(ahead) * way.cross(back) > 0;
  }

  const std::vector<Saddle>& saddles_;
  std::array<Point, 2> axes_;
  std::map<Cell, int> cells_;
  std::vector<bool> used_;
};

/// Without corners that a homography of the others does not explain.
std::map<Cell, int> Agreeing(const std::map<Cell, int>& cells, const std::vector<Saddle>& saddles) {
  constexpr double kMost = 0.2;  // squares; lenses bend rows
  if (cells.size() < 4) return {};
  std::vector<Point> grid, seen;
  for (const auto& [cell, saddle] : cells) {
    grid.emplace_back(cell.first, cell.second);
    seen.push_back(saddles[saddle].at);
  }
  std::vector<std::uint8_t> inlier;
  if (cv::findHomography(seen, grid, cv::RANSAC, kMost, inlier, 500, 0.999).empty()) return {};
  std::map<Cell, int> kept;
  std::size_t i = 0;
  for (const auto& item : cells)
    if (inlier[i++]) kept.insert(item);
  return kept;
}

struct Bounds {
  int left = 1 << 20, right = -(1 << 20), top = 1 << 20, bottom = -(1 << 20);
};

Bounds BoundsOf(const std::map<Cell, int>& cells) {
  Bounds b;
  for (const auto& [cell, saddle] : cells) {
    b.left = std::min(b.left, cell.first);
    b.right = std::max(b.right, cell.first);
    b.top = std::min(b.top, cell.second);
    b.bottom = std::max(b.bottom, cell.second);
  }
  return b;
}

/// Cuts outer rows and columns that are less than half filled: strays beside the board.
void Trim(std::map<Cell, int>* cells) {
  while (!cells->empty()) {
    const Bounds b = BoundsOf(*cells);
    const auto drop = [&](auto&& on_line, int length) {
      const auto count = std::count_if(cells->begin(), cells->end(),
                                       [&](const auto& item) { return on_line(item.first); });
      if (2 * count >= length) return false;
      std::erase_if(*cells, [&](const auto& item) { return on_line(item.first); });
      return true;
    };
    const int width = b.right - b.left + 1, height = b.bottom - b.top + 1;
    if (drop([&](const Cell& c) { return c.first == b.left; }, height) ||
        drop([&](const Cell& c) { return c.first == b.right; }, height) ||
        drop([&](const Cell& c) { return c.second == b.top; }, width) ||
        drop([&](const Cell& c) { return c.second == b.bottom; }, width))
      continue;
    return;
  }
}

/// Adds corners that the grid foretells, where the ring about them agrees: glare or blur hid them
/// from the first search.
void Complete(const cv::Mat& grey, std::map<Cell, int>* cells, std::vector<Saddle>* saddles) {
  std::vector<Point> grid, seen;
  for (const auto& [cell, saddle] : *cells) {
    grid.emplace_back(cell.first, cell.second);
    seen.push_back((*saddles)[saddle].at);
  }
  if (grid.size() < 4) return;
  const cv::Mat h = cv::findHomography(grid, seen);
  if (h.empty()) return;
  const Bounds b = BoundsOf(*cells);
  for (int row = b.top - 1; row <= b.bottom + 1; ++row)
    for (int column = b.left - 1; column <= b.right + 1; ++column) {
      if (cells->count({column, row})) continue;
      std::vector<Point> at{{double(column), double(row)}, {column + 1.0, double(row)}}, pixels;
      cv::perspectiveTransform(at, pixels, h);
      const double spacing = cv::norm(pixels[1] - pixels[0]);
      const int half = std::max(2, static_cast<int>(0.2 * spacing));
      const cv::Rect inside(half + 2, half + 2, grey.cols - 2 * half - 4, grey.rows - 2 * half - 4);
      if (!inside.contains(cv::Point(pixels[0]))) continue;
      std::vector<cv::Point2f> fine{cv::Point2f(pixels[0])};
      cv::cornerSubPix(grey, fine, {half, half}, {-1, -1},
                       {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 30, 1e-2});
      if (cv::norm(Point(fine[0]) - pixels[0]) > 0.2 * spacing) continue;
      for (const double share : {0.25, 0.4})
        if (const auto saddle = RingOf(grey, fine[0], share * spacing)) {
          (*cells)[{column, row}] = SizeOf(*saddles);
          saddles->push_back(*saddle);
          break;
        }
    }
}

struct GridSquare {
  double mean = 0, deviation = 0, contrast = 0;
};

/// Grey levels of the square to the right of and below a corner; none where a corner is missing.
std::optional<GridSquare> SquareAt(const cv::Mat& grey, const Cell& cell,
                                   const std::map<Cell, int>& cells,
                                   const std::vector<Saddle>& saddles) {
  constexpr int kSamples = 5;  // each way
  constexpr double kCount = kSamples * kSamples;
  std::array<Point, 4> at;
  GridSquare square;
  int i = 0;
  for (const auto& [dx, dy] : {Cell{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    const auto found = cells.find({cell.first + dx, cell.second + dy});
    if (found == cells.end()) return {};
    at[i++] = saddles[found->second].at;
    square.contrast += saddles[found->second].strength / 4;
  }
  double sum = 0, squares = 0;
  for (int k = 0; k < kSamples * kSamples; ++k) {
    const double u = (k % kSamples + 1) / (kSamples + 1.0),
                 v = (k / kSamples + 1) / (kSamples + 1.0);
    const double level =
        Level(grey, (1 - v) * ((1 - u) * at[0] + u * at[1]) + v * ((1 - u) * at[3] + u * at[2]));
    sum += level;
    squares += level * level;
  }
  square.mean = sum / kCount;
  square.deviation = std::sqrt(std::max(0.0, squares / kCount - square.mean * square.mean));
  return square;
}

/// Corners of squares that are evenly dark or bright, unlike those beside them. Other patterns,
/// such as a blouse's, have corners too.
std::map<Cell, int> AboutEvenSquares(const cv::Mat& grey, const std::map<Cell, int>& cells,
                                     const std::vector<Saddle>& saddles) {
  constexpr double kMostUneven = 0.25, kLeastStep = 0.5;  // over the corners' contrast
  std::map<Cell, GridSquare> squares;
  for (const auto& [cell, saddle] : cells)
    if (const std::optional<GridSquare> square = SquareAt(grey, cell, cells, saddles))
      if (square->deviation < kMostUneven * square->contrast) squares[cell] = *square;
  std::map<Cell, int> kept;
  for (const auto& [cell, square] : squares)
    for (const auto& [dx, dy] : {Cell{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
      const auto beside = squares.find({cell.first + dx, cell.second + dy});
      if (beside == squares.end()) continue;
      if (std::abs(beside->second.mean - square.mean) < kLeastStep * square.contrast) continue;
      for (const auto& [x, y] : {Cell{0, 0}, {1, 0}, {1, 1}, {0, 1}})
        kept.insert(*cells.find({cell.first + x, cell.second + y}));
    }
  return kept;
}

/// A grid without what belongs to no square, and with what the first search missed.
std::map<Cell, int> Mended(const cv::Mat& grey, bool even, std::map<Cell, int> cells,
                           std::vector<Saddle>* saddles) {
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    cells = Agreeing(cells, *saddles);
    if (even) cells = AboutEvenSquares(grey, cells, *saddles);
    Trim(&cells);
    if (SizeOf(cells) < kLeastSide * kLeastSide) return {};
    const std::size_t before = cells.size();
    if (round + 1 < kRounds) Complete(grey, &cells, saddles);
    if (cells.size() == before) break;
  }
  return cells;
}

/// The largest grid of all seeds.
/// @param even  of squares without anything in them
std::map<Cell, int> LargestGrid(const cv::Mat& grey, bool even, std::vector<Saddle>* saddles) {
  const int seeds = SizeOf(*saddles);
  std::vector<bool> tried(saddles->size(), false);
  std::map<Cell, int> best;
  for (int seed = 0; seed < seeds; ++seed) {
    if (tried[seed]) continue;
    const std::vector<bool> none(saddles->size(), false);
    std::map<Cell, int> cells = GridGrower(*saddles).Grow(seed, none);
    for (const auto& [cell, saddle] : cells)
      if (saddle < seeds) tried[saddle] = true;
    if (cells.size() <= best.size() / 2) continue;
    cells = Mended(grey, even, std::move(cells), saddles);
    if (cells.size() > best.size()) best = std::move(cells);
  }
  return best;
}

/// The grid with columns along its longer side, seen from the front, and a dark first square where
/// that is possible.
CheckerGrid Ordered(const std::map<Cell, int>& cells, const std::vector<Saddle>& saddles) {
  const Bounds b = BoundsOf(cells);
  CheckerGrid grid;
  grid.columns = b.right - b.left + 1;
  grid.rows = b.bottom - b.top + 1;
  struct Placed {
    int column, row;
    const Saddle* saddle;
  };
  std::vector<Placed> placed;
  for (const auto& [cell, saddle] : cells)
    placed.push_back({cell.first - b.left, cell.second - b.top, &saddles[saddle]});
  const auto transpose = [&] {
    for (Placed& p : placed) std::swap(p.column, p.row);
    std::swap(grid.columns, grid.rows);
  };
  // one quarter turn: columns become rows, and run the other way
  const auto turn = [&] {
    transpose();
    for (Placed& p : placed) p.column = grid.columns - 1 - p.column;
  };
  const auto axis = [&](bool rows) {
    Point sum(0, 0);
    for (const Placed& p : placed)
      sum += (2 * (rows ? p.row : p.column) - (rows ? grid.rows : grid.columns) + 1) * p.saddle->at;
    return sum;
  };
  if (axis(false).cross(axis(true)) < 0) transpose();
  if (grid.columns < grid.rows) turn();
  const auto first_dark = [&] {
    int votes = 0;
    for (const Placed& p : placed) {
      const Point back = -(axis(false) / cv::norm(axis(false)) + axis(true) / cv::norm(axis(true)));
      const bool dark = std::abs(p.saddle->dark.dot(back)) / cv::norm(back) > 0.7;
      votes += dark == ((p.column + p.row) % 2 == 0) ? 1 : -1;
    }
    return votes > 0;
  };
  const int turns = grid.columns == grid.rows ? 4 : 2;
  for (int i = 0; i < turns && !first_dark(); ++i)
    for (int quarter = 0; quarter < 4 / turns; ++quarter) turn();
  grid.first_dark = first_dark();
  for (const Placed& p : placed)
    grid.corners.push_back({p.column, p.row, Eigen::Vector2d(p.saddle->at.x, p.saddle->at.y)});
  std::sort(grid.corners.begin(), grid.corners.end(), [](const auto& x, const auto& y) {
    return std::pair(x.row, x.column) < std::pair(y.row, y.column);
  });
  return grid;
}

/// Distance to the nearest neighbour in the grid [px].
double Spacing(const CheckerGrid& grid, const CheckerGrid::Corner& corner) {
  double least = 1e300;
  for (const CheckerGrid::Corner& other : grid.corners)
    if (std::abs(other.column - corner.column) + std::abs(other.row - corner.row) == 1)
      least = std::min(least, (other.pixel - corner.pixel).norm());
  return least;
}

/// Corners of the reduced picture, found in the whole one to a fraction of a pixel.
void Refine(const cv::Mat& grey, double factor, CheckerGrid* grid) {
  for (CheckerGrid::Corner& corner : grid->corners)
    corner.pixel = (corner.pixel.array() + 0.5) / factor - 0.5;
  std::vector<Eigen::Vector2d> fine;
  for (const CheckerGrid::Corner& corner : grid->corners) {
    // first as far as the reduced picture may be wrong, then close by
    std::vector<cv::Point2f> at{
        {static_cast<float>(corner.pixel.x()), static_cast<float>(corner.pixel.y())}};
    const double spacing = Spacing(*grid, corner);
    for (const double share : {0.35, 0.22}) {
      const int half = std::clamp(static_cast<int>(share * spacing), 2, 15);
      cv::cornerSubPix(grey, at, {half, half}, {-1, -1},
                       {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
    }
    fine.emplace_back(at[0].x, at[0].y);
  }
  for (int i = 0; i < SizeOf(fine); ++i) {
    CheckerGrid::Corner& corner = grid->corners[i];
    // One that ran away is no corner, or hidden.
    const double most = 0.2 * Spacing(*grid, corner);
    if ((fine[i] - corner.pixel).norm() < most) corner.pixel = fine[i];
    corner.pixel.array() += 0.5;
  }
}

}  // namespace

CheckerGrid FindCheckerboard(const Image8& image) {
  Image8 pixels = GreyPicture(image);
  const cv::Mat grey(pixels.height, pixels.width, CV_8UC1, pixels.data.data());
  const double whole = std::max(grey.cols, grey.rows);
  CheckerGrid best;
  double best_factor = 1;
  for (const double side : {800.0, 400.0, 1600.0}) {
    const double factor = std::min(1.0, side / whole);
    cv::Mat small = grey;
    if (factor < 1) cv::resize(grey, small, {}, factor, factor, cv::INTER_AREA);
    std::vector<Saddle> saddles = SaddlesOf(small);
    const std::map<Cell, int> cells = LargestGrid(small, true, &saddles);
    if (cells.size() > best.corners.size()) {
      best = Ordered(cells, saddles);
      best_factor = factor;
    }
    if (best.whole() && best.rows > kLeastSide) break;
    if (factor == 1 && side > whole) break;
  }
  if (best.columns < kLeastSide || best.rows < kLeastSide) return {};
  Refine(grey, best_factor, &best);
  return best;
}

CheckerGrid FindCornerGrid(const Image8& grey, double enlarged) {
  const cv::Mat view(grey.height, grey.width, CV_8UC1, const_cast<std::uint8_t*>(grey.data.data()));
  cv::Mat large;
  cv::resize(view, large, {}, enlarged, enlarged, cv::INTER_CUBIC);
  std::vector<Saddle> saddles = SaddlesOf(large);
  const std::map<Cell, int> cells = LargestGrid(large, false, &saddles);
  CheckerGrid grid;
  if (!cells.empty()) grid = Ordered(cells, saddles);
  for (CheckerGrid::Corner& corner : grid.corners)
    corner.pixel = (corner.pixel.array() + 0.5) / enlarged;
  return grid;
}

}  // namespace keypose::capture
