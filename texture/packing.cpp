#include "texture/packing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "core/errors.h"
#include "core/parallel.h"

namespace keypose::texture {
namespace {

constexpr int kWord = 64;
constexpr int kDirections = 8;  // four quarter turns, then the same from a turn of 45 degrees

// Rows of bits, `words` a row, one spare word so that a shifted row can be tested without a bound check.
struct Bitmap {
  int width = 0, height = 0, words = 0;
  std::vector<std::uint64_t> bits;
  Bitmap(int w, int h) : width(w), height(h), words((w + kWord - 1) / kWord + 1), bits(static_cast<std::size_t>(words) * h, 0) {}
  const std::uint64_t* Row(int y) const { return &bits[static_cast<std::size_t>(y) * words]; }
  std::uint64_t* Row(int y) { return &bits[static_cast<std::size_t>(y) * words]; }
  void Fill(int y, int x0, int x1) {
    for (int x = std::max(x0, 0); x <= std::min(x1, width - 1); ++x) Row(y)[x / kWord] |= std::uint64_t{1} << (x % kWord);
  }
};

// What goes first, and which of the free places is best; which pair packs best differs from mesh to mesh.
struct Strategy {
  bool by_area;  // else by extent
  bool low_top;  // lowest upper end wins, else lowest centre of area
};
constexpr std::array<Strategy, 2> kStrategies = {{{false, false}, {true, true}}};

struct Place {
  int direction = 0, x = 0, y = 0;
};

UvsX2 Turned(const UvsX2& points, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  UvsX2 out(points.rows(), 2);
  for (int i = 0; i < static_cast<int>(points.rows()); ++i)
    out.row(i) << c * points(i, 0) - s * points(i, 1), s * points(i, 0) + c * points(i, 1);
  return out;
}

// Lower left corner of the bounding box to the origin.
UvsX2 Grounded(UvsX2 points) {
  const Eigen::RowVector2d low = points.colwise().minCoeff();
  points.rowwise() -= low;
  return points;
}

// The turn, in steps of three degrees, with the smallest bounding box; lying.
UvsX2 Laid(const UvsX2& points) {
  UvsX2 best;
  double least = std::numeric_limits<double>::infinity();
  for (int step = 0; step < 30; ++step) {
    const UvsX2 turned = Turned(points, step * EIGEN_PI / 60);
    const Eigen::RowVector2d extent = turned.colwise().maxCoeff() - turned.colwise().minCoeff();
    if (extent.prod() >= least * (1 - 1e-9)) continue;
    least = extent.prod();
    best = extent.x() >= extent.y() ? turned : Turned(turned, EIGEN_PI / 2);
  }
  return Grounded(best);
}

// Marks every cell that a triangle touches: per row of cells, the x range of the triangle within it.
void Rasterise(const std::array<Eigen::Vector2d, 3>& t, int margin, Bitmap& map) {
  const auto [low, high] = std::minmax({t[0].y(), t[1].y(), t[2].y()});
  for (int row = static_cast<int>(std::floor(low)); row <= static_cast<int>(std::floor(high)); ++row) {
    double left = std::numeric_limits<double>::infinity(), right = -left;
    const auto take = [&](double x) {
      left = std::min(left, x);
      right = std::max(right, x);
    };
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector2d &a = t[k], &b = t[(k + 1) % 3];
      if (a.y() >= row && a.y() <= row + 1) take(a.x());
      for (const double level : {static_cast<double>(row), row + 1.0}) {
        if ((a.y() < level) == (b.y() < level)) continue;
        take(a.x() + (b.x() - a.x()) * (level - a.y()) / (b.y() - a.y()));
      }
    }
    if (left <= right)
      map.Fill(row + margin, static_cast<int>(std::floor(left - 1e-7)) + margin, static_cast<int>(std::floor(right + 1e-7)) + margin);
  }
}

Bitmap Drawn(const UvsX2& cells, const FacesX3& corners, int margin) {
  const Eigen::RowVector2d extent = cells.colwise().maxCoeff();
  Bitmap map(static_cast<int>(std::floor(extent.x())) + 2 + 2 * margin, static_cast<int>(std::floor(extent.y())) + 2 + 2 * margin);
  for (int f = 0; f < static_cast<int>(corners.rows()); ++f)
    Rasterise({cells.row(corners(f, 0)).transpose(), cells.row(corners(f, 1)).transpose(), cells.row(corners(f, 2)).transpose()}, margin,
              map);
  return map;
}

// Every cell within `radius` cells (in both directions) of a marked one.
Bitmap Dilated(const Bitmap& map, int radius) {
  Bitmap wide = map;
  for (int round = 0; round < radius; ++round) {
    Bitmap next = wide;
    for (int y = 0; y < map.height; ++y) {
      for (int w = 0; w < map.words; ++w) {
        const std::uint64_t here = wide.Row(y)[w];
        const std::uint64_t from_left = w > 0 ? wide.Row(y)[w - 1] >> 63 : 0;
        const std::uint64_t from_right = w + 1 < map.words ? wide.Row(y)[w + 1] << 63 : 0;
        const std::uint64_t spread = here | (here << 1) | from_left | (here >> 1) | from_right;
        for (int dy = std::max(y - 1, 0); dy <= std::min(y + 1, map.height - 1); ++dy) next.Row(dy)[w] |= spread;
      }
    }
    wide = next;
  }
  return wide;
}

// Rows far apart first: most places are taken, and that shows soonest in the broad middle of a shape.
std::vector<int> TestOrder(int height) {
  std::vector<int> order;
  std::vector<char> seen(height, 0);
  for (int step = height; step > 0; step /= 2) {
    for (int r = step / 2; r < height; r += step) {
      if (!seen[r]) order.push_back(r);
      seen[r] = 1;
    }
  }
  for (int r = 0; r < height; ++r)
    if (!seen[r]) order.push_back(r);
  return order;
}

bool Free(const Bitmap& square, const Bitmap& shape, const std::vector<int>& rows, int x, int y) {
  const int word = x / kWord, shift = x % kWord;
  for (const int r : rows) {
    const std::uint64_t* below = square.Row(y + r) + word;
    const std::uint64_t* bits = shape.Row(r);
    for (int w = 0; w + 1 < shape.words; ++w) {
      std::uint64_t under = below[w] >> shift;
      if (shift) under |= below[w + 1] << (kWord - shift);
      if (under & bits[w]) return false;
    }
  }
  return true;
}

double MeanRow(const Bitmap& map) {
  double sum = 0, count = 0;
  for (int y = 0; y < map.height; ++y) {
    for (int w = 0; w < map.words; ++w) {
      sum += static_cast<double>(y) * std::popcount(map.Row(y)[w]);
      count += std::popcount(map.Row(y)[w]);
    }
  }
  return sum / count;
}

void Stamp(const Bitmap& shape, int x, int y, Bitmap& square) {
  for (int r = 0; r < shape.height; ++r)
    for (int c = 0; c < shape.width; ++c)
      if (shape.Row(r)[c / kWord] >> (c % kWord) & 1) square.Row(y + r)[(x + c) / kWord] |= std::uint64_t{1} << ((x + c) % kWord);
}

class Packer {
 public:
  Packer(const std::vector<Shape>& shapes, const PackingOptions& options) : shapes_(shapes) {
    grid_ = std::min(options.texture_size, 1024);
    gutter_ = std::max(1, static_cast<int>(std::ceil(static_cast<double>(options.gutter_px) * grid_ / options.texture_size)));
    for (const Shape& shape : shapes) laid_.push_back(Laid(shape.points));
    for (const Shape& shape : shapes)
      for (int f = 0; f < static_cast<int>(shape.corners.rows()); ++f) area_ += Area(shape, f);
    for (const bool by_area : {false, true}) {
      std::vector<int>& order = orders_[by_area];
      order.resize(shapes.size());
      std::iota(order.begin(), order.end(), 0);
      std::vector<double> size;
      for (int i = 0; i < static_cast<int>(shapes.size()); ++i)
        size.push_back(by_area ? laid_[i].colwise().maxCoeff().prod() : laid_[i].maxCoeff());
      std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return size[a] > size[b]; });
    }
  }

  Packing Run() {
    double low = 0, high = std::sqrt(0.92 / area_);
    std::vector<Place> best;
    for (double scale = high * 0.93, least = 0.03 * high; scale > least; scale *= 0.9) {
      if (const auto places = Placed(scale)) {
        best = *places;
        low = scale;
        break;
      }
      high = scale;
    }
    if (best.empty())
      throw QualityError("unwrap: " + std::to_string(shapes_.size()) + " charts do not fit the texture with this gutter; lower --gutter");
    for (int round = 0; round < 4; ++round) {
      const double middle = (low + high) / 2;
      if (const auto places = Placed(middle)) {
        best = *places;
        low = middle;
      } else {
        high = middle;
      }
    }
    return Result(low, best);
  }

 private:
  static double Area(const Shape& shape, int f) {
    const Eigen::Vector2d p = shape.points.row(shape.corners(f, 0)), q = shape.points.row(shape.corners(f, 1)),
                          r = shape.points.row(shape.corners(f, 2));
    return ((q - p).x() * (r - p).y() - (q - p).y() * (r - p).x()) / 2;
  }
  UvsX2 Cells(int shape, int direction, double scale) const {
    UvsX2 p = laid_[shape] * (scale * grid_);
    if (direction >= 4) p = Turned(p, EIGEN_PI / 4);
    for (int k = 0; k < direction % 4; ++k) {  // exact quarter turns
      UvsX2 q(p.rows(), 2);
      q.col(0) = -p.col(1);
      q.col(1) = p.col(0);
      p = q;
    }
    return Grounded(p);
  }

  // First free cell from the bottom, then from the left; the direction whose area comes to lie lowest wins.
  std::optional<Place> Find(int shape, double scale, bool low_top, const Bitmap& square, Bitmap& stamp) const {
    std::array<std::optional<Place>, kDirections> found;
    std::array<double, kDirections> top{};
    std::vector<Bitmap> maps(kDirections, Bitmap(1, 1));
    ParallelFor(kDirections, [&](std::int64_t d) {
      maps[d] = Dilated(Drawn(Cells(shape, static_cast<int>(d), scale), shapes_[shape].corners, gutter_), gutter_);
      const Bitmap& map = maps[d];
      const std::vector<int> rows = TestOrder(map.height);
      for (int y = 0; y + map.height <= grid_; ++y) {
        for (int x = 0; x + map.width <= grid_; ++x) {
          if (!Free(square, map, rows, x, y)) continue;
          found[d] = Place{static_cast<int>(d), x, y};
          top[d] = y + (low_top ? map.height : MeanRow(map));
          return;
        }
      }
    });
    int best = -1;
    for (int d = 0; d < kDirections; ++d)
      if (found[d] && (best < 0 || top[d] < top[best])) best = d;
    if (best < 0) return std::nullopt;
    stamp = Drawn(Cells(shape, best, scale), shapes_[shape].corners, gutter_);
    return found[best];
  }

  std::optional<std::vector<Place>> Placed(double scale) const {
    for (const Strategy& strategy : kStrategies) {
      if (auto places = Placed(scale, strategy)) return places;
    }
    return std::nullopt;
  }

  std::optional<std::vector<Place>> Placed(double scale, const Strategy& strategy) const {
    std::vector<Place> places(shapes_.size());
    Bitmap square(grid_, grid_);
    Bitmap stamp(1, 1);
    for (const int shape : orders_[strategy.by_area]) {
      const std::optional<Place> place = Find(shape, scale, strategy.low_top, square, stamp);
      if (!place) return std::nullopt;
      Stamp(stamp, place->x, place->y, square);
      places[shape] = *place;
    }
    return places;
  }

  Packing Result(double scale, const std::vector<Place>& places) const {
    Packing packing;
    packing.utilisation = area_ * scale * scale;
    for (int i = 0; i < static_cast<int>(shapes_.size()); ++i) {
      UvsX2 cells = Cells(i, places[i].direction, scale);
      cells.col(0).array() += places[i].x + gutter_;
      cells.col(1).array() += places[i].y + gutter_;
      packing.uvs.push_back(cells / grid_);
    }
    return packing;
  }

  const std::vector<Shape>& shapes_;
  int grid_ = 0, gutter_ = 0;
  double area_ = 0;
  std::vector<UvsX2> laid_;
  std::array<std::vector<int>, 2> orders_;
};

}  // namespace

Packing Pack(const std::vector<Shape>& shapes, const PackingOptions& options) { return Packer(shapes, options).Run(); }

}  // namespace keypose::texture
