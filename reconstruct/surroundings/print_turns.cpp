#include "reconstruct/surroundings/print_turns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d, Eigen::Vector3d;

/// The plane's axes, and the side of a cell.
struct Sheet {
  Vector3d middle, x, y;
  double cell = 0;
  int cells = 0;
  Vector3d At(double column, double row) const {
    const double half = 0.5 * cells;
    return middle + cell * ((column - half) * x + (row - half) * y);
  }
};

Sheet SheetOf(const SupportPlane& plane, const PrintTurnOptions& options) {
  Sheet sheet;
  sheet.middle = plane.foot;
  sheet.x = plane.normal.unitOrthogonal();
  sheet.y = plane.normal.cross(sheet.x);
  sheet.cells = options.cells;
  sheet.cell = 2 * options.radius * plane.distance / options.cells;
  return sheet;
}

constexpr int kChannels = 3;

/// Lightness and two differences of colours, without their local mean and contrast, and where they
/// are known.
struct FromAbove {
  std::array<cv::Mat1f, kChannels> values;
  cv::Mat1f known;
};

bool IsIn(const Image8& region, const Camera& camera, const Vector2d& pixel) {
  if (region.empty()) return true;
  const auto at = [](double x, int of, int size) {
    return std::clamp(static_cast<int>(x * size / of), 0, size - 1);
  };
  return *region.at(at(pixel.x(), camera.width, region.width),
                    at(pixel.y(), camera.height, region.height)) > 127;
}

/// The colour at a place between the picture's pixels; nothing outside.
std::optional<Vector3d> ColourAt(const Image8& picture, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= picture.width || y0 + 1 >= picture.height) return std::nullopt;
  const double fx = x - x0, fy = y - y0;
  Vector3d colour;
  for (int c = 0; c < 3; ++c) {
    const auto value = [&](int dx, int dy) {
      return static_cast<double>(picture.at(x0 + dx, y0 + dy)[c]);
    };
    colour[c] = (1 - fy) * ((1 - fx) * value(0, 0) + fx * value(1, 0)) +
                fy * ((1 - fx) * value(0, 1) + fx * value(1, 1));
  }
  return colour;
}

/// Where each view shows what stands on the plane, by the points that it sees; small.
std::vector<Image8> StandingIn(const Scene& scene, const SupportPlane& plane) {
  constexpr int kWidth = 160;
  constexpr double kAbove = 0.012;      // of the cameras' distance
  constexpr int kRadius = 4, kGap = 9;  // px: of a point, and between points that are one surface
  std::vector<std::vector<Vector2d>> places(scene.views.size());
  for (const SparsePoint& point : scene.points) {
    if (plane.normal.dot(point.position) - plane.offset < kAbove * plane.distance) continue;
    for (const int v : point.views) {
      const Camera& camera = scene.views[v].camera;
      places[v].push_back(scene.views[v].Project(point.position) * kWidth / camera.width);
    }
  }
  std::vector<Image8> standing;
  for (std::size_t v = 0; v < scene.views.size(); ++v) {
    const Camera& camera = scene.views[v].camera;
    Image8 mask(kWidth, std::max(1, kWidth * camera.height / camera.width), 1);
    cv::Mat1b drawn(mask.height, mask.width, mask.data.data());
    for (const Vector2d& at : places[v])
      cv::circle(drawn, {static_cast<int>(at.x()), static_cast<int>(at.y())}, kRadius, 255, -1);
    cv::morphologyEx(drawn, drawn, cv::MORPH_CLOSE,
                     cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * kGap + 1, 2 * kGap + 1}));
    standing.push_back(std::move(mask));
  }
  return standing;
}

/// What a view shows of the sheet; nothing where it is outside of the picture or its region.
FromAbove Drawn(const View& view, const Image8& picture, const Image8& region,
                const Image8& standing, const Sheet& sheet) {
  FromAbove drawn;
  for (cv::Mat1f& values : drawn.values) values = cv::Mat1f::zeros(sheet.cells, sheet.cells);
  drawn.known = cv::Mat1f::zeros(sheet.cells, sheet.cells);
  const double by_x = static_cast<double>(picture.width) / view.camera.width,
               by_y = static_cast<double>(picture.height) / view.camera.height;
  for (int row = 0; row < sheet.cells; ++row)
    for (int column = 0; column < sheet.cells; ++column) {
      const Vector3d at = view.camera_from_world * sheet.At(column + 0.5, row + 0.5);
      if (at.z() <= 0) continue;
      const Vector2d pixel = view.camera.Project(at);
      const auto rgb = ColourAt(picture, pixel.x() * by_x - 0.5, pixel.y() * by_y - 0.5);
      if (!rgb || !IsIn(region, view.camera, pixel) || IsIn(standing, view.camera, pixel)) continue;
      drawn.values[0](row, column) = static_cast<float>(rgb->mean());
      drawn.values[1](row, column) = static_cast<float>(rgb->x() - rgb->y());
      drawn.values[2](row, column) = static_cast<float>(rgb->z() - 0.5 * (rgb->x() + rgb->y()));
      drawn.known(row, column) = 1;
    }
  return drawn;
}

/// Takes the local mean and contrast away: light and shadow.
void Flatten(int window, FromAbove& drawn) {
  constexpr float kNoise = 12;  // grey values
  const cv::Size size(2 * window + 1, 2 * window + 1);
  const auto mean = [&](const cv::Mat1f& values) {
    cv::Mat1f out;
    cv::boxFilter(values, out, CV_32F, size, {-1, -1}, true, cv::BORDER_CONSTANT);
    return out;
  };
  const cv::Mat1f share = cv::max(mean(drawn.known), 1e-6F);
  for (cv::Mat1f& values : drawn.values) {
    const cv::Mat1f level = mean(values) / share;
    const cv::Mat1f off = (values - level).mul(drawn.known);
    cv::Mat1f contrast;
    // Sums that slide over the rows end a little below zero.
    cv::sqrt(cv::max(mean(off.mul(off)), 0.0F) / share, contrast);
    values = off / (contrast + kNoise);
  }
}

using Spectrum = std::vector<std::complex<float>>;  ///< rings x frequencies

/// Spectra along the angle, by ring: of values, of their squares, and of where they are known.
struct Polar {
  std::array<Spectrum, kChannels> values;
  Spectrum square, known;
};

struct Rings {
  int rings = 0, angles = 0;
  int frequencies() const { return angles / 2 + 1; }
};

float Bilinear(const cv::Mat1f& grid, double x, double y) {
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  if (x0 < 0 || y0 < 0 || x0 + 1 >= grid.cols || y0 + 1 >= grid.rows) return 0;
  const auto fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
  return (1 - fy) * ((1 - fx) * grid(y0, x0) + fx * grid(y0, x0 + 1)) +
         fy * ((1 - fx) * grid(y0 + 1, x0) + fx * grid(y0 + 1, x0 + 1));
}

Spectrum SpectrumOf(const cv::Mat1f& rows, const Rings& rings) {
  cv::Mat2f full;
  cv::dft(rows, full, cv::DFT_ROWS | cv::DFT_COMPLEX_OUTPUT);
  Spectrum spectrum;
  for (int r = 0; r < rows.rows; ++r)
    for (int k = 0; k < rings.frequencies(); ++k)
      spectrum.emplace_back(full(r, k)[0], full(r, k)[1]);
  return spectrum;
}

/// What a view shows of the sheet round a place of it: rings x angles.
struct Unrolled {
  std::array<cv::Mat1f, kChannels> values;
  cv::Mat1f known;
};

Unrolled UnrolledRound(const FromAbove& drawn, const Vector2d& middle, const Rings& rings) {
  Unrolled unrolled;
  for (cv::Mat1f& each : unrolled.values) each.create(rings.rings, rings.angles);
  unrolled.known.create(rings.rings, rings.angles);
  const double reach = 0.5 * drawn.known.cols;
  for (int r = 0; r < rings.rings; ++r) {
    const double radius = reach * (r + 0.5) / rings.rings;
    for (int a = 0; a < rings.angles; ++a) {
      const double angle = 2 * kPi * a / rings.angles;
      const double x = middle.x() + radius * std::cos(angle) - 0.5,
                   y = middle.y() + radius * std::sin(angle) - 0.5;
      unrolled.known(r, a) = Bilinear(drawn.known, x, y);
      for (int c = 0; c < kChannels; ++c)
        unrolled.values[c](r, a) = Bilinear(drawn.values[c], x, y);
    }
  }
  return unrolled;
}

/// Takes away what looks alike after a quarter of a turn, as a scale does and marks in four
/// corners: it tells no turn from another. What is seen in one quarter alone is not known to be
/// unlike.
void KeepUnlike(Unrolled& unrolled) {
  constexpr int kQuarters = 4;
  const int quarter = unrolled.known.cols / kQuarters;
  for (int r = 0; r < unrolled.known.rows; ++r)
    for (int a = 0; a < quarter; ++a) {
      int seen = 0;
      float weight = 0;
      std::array<float, kChannels> sum{};
      for (int at = a; at < unrolled.known.cols; at += quarter) {
        const float known = unrolled.known(r, at);
        seen += known > 0;
        weight += known;
        for (int c = 0; c < kChannels; ++c) sum[c] += known * unrolled.values[c](r, at);
      }
      for (int at = a; at < unrolled.known.cols; at += quarter) {
        if (seen < 2) unrolled.known(r, at) = 0;
        for (int c = 0; weight > 0 && c < kChannels; ++c)
          unrolled.values[c](r, at) -= sum[c] / weight;
      }
    }
}

Polar SpectraOf(const Unrolled& unrolled, const Rings& rings) {
  cv::Mat1f weight = unrolled.known.clone();
  // Farther out a step of the angle covers more of the print.
  for (int r = 0; r < rings.rings; ++r)
    weight.row(r) *= (static_cast<float>(r) + 0.5F) / static_cast<float>(rings.rings);
  Polar polar;
  cv::Mat1f square = cv::Mat1f::zeros(weight.size());
  for (int c = 0; c < kChannels; ++c) {
    const cv::Mat1f value = weight.mul(unrolled.values[c]);
    square += value.mul(unrolled.values[c]);
    polar.values[c] = SpectrumOf(value, rings);
  }
  polar.square = SpectrumOf(square, rings);
  polar.known = SpectrumOf(weight, rings);
  return polar;
}

/// sum over places of first(place + turn) * second(place), by turn.
cv::Mat1f Correlated(const Spectrum& first, const Spectrum& second, const Rings& rings) {
  cv::Mat2f product = cv::Mat2f::zeros(1, rings.angles);
  const int n = rings.frequencies();
  for (int r = 0; r < rings.rings; ++r)
    for (int k = 0; k < n; ++k) {
      const std::complex<float> p = first[static_cast<std::size_t>(r * n + k)] *
                                    std::conj(second[static_cast<std::size_t>(r * n + k)]);
      product(0, k) += cv::Vec2f(p.real(), p.imag());
    }
  for (int k = n; k < rings.angles; ++k) {
    const cv::Vec2f& mirrored = product(0, rings.angles - k);
    product(0, k) = {mirrored[0], -mirrored[1]};
  }
  cv::Mat1f by_turn;
  cv::idft(product, by_turn, cv::DFT_REAL_OUTPUT | cv::DFT_SCALE);
  return by_turn;
}

/// Correlation of what two photographs show of the print, by the turn of the first against the
/// second; 0 where they hardly share any.
std::vector<float> ByTurn(const Polar& first, const Polar& second, const Rings& rings) {
  cv::Mat1f both = cv::Mat1f::zeros(1, rings.angles);
  for (int c = 0; c < kChannels; ++c) both += Correlated(first.values[c], second.values[c], rings);
  const cv::Mat1f a = Correlated(first.square, second.known, rings),
                  b = Correlated(first.known, second.square, rings),
                  shared = Correlated(first.known, second.known, rings);
  constexpr float kLeastShared = 0.015F;  // of the disc
  const float least = kLeastShared * static_cast<float>(rings.angles * rings.rings);
  std::vector<float> by_turn(static_cast<std::size_t>(rings.angles), 0);
  for (int t = 0; t < rings.angles; ++t) {
    const float energy = std::sqrt(std::max(0.0F, a(0, t)) * std::max(0.0F, b(0, t)));
    if (shared(0, t) > least && energy > 1e-3F) by_turn[t] = both(0, t) / energy;
  }
  return by_turn;
}

/// How pairs of photographs correlate.
struct Curves {
  int count = 0, angles = 0;
  std::vector<std::vector<float>> of_pair;  ///< i < j; turn of i against j
  const std::vector<float>& At(int i, int j) const {
    return of_pair[static_cast<std::size_t>(i * count + j)];
  }
  /// When i is turned by `a` and j by `b`.
  float Of(int i, int j, int a, int b) const {
    const int turn = i < j ? b - a : a - b;
    return At(std::min(i, j), std::max(i, j))[((turn % angles) + angles) % angles];
  }
};

/// @param unlike  only what does not look alike after a quarter of a turn counts
Curves CurvesRound(const std::vector<FromAbove>& drawn, const Vector2d& middle, const Rings& rings,
                   bool unlike) {
  const int n = SizeOf(drawn);
  std::vector<Polar> polar(drawn.size());
  ParallelFor(n, [&](std::int64_t i) {
    Unrolled unrolled = UnrolledRound(drawn[i], middle, rings);
    if (unlike) KeepUnlike(unrolled);
    polar[i] = SpectraOf(unrolled, rings);
  });
  Curves curves{n, rings.angles, {}};
  curves.of_pair.resize(static_cast<std::size_t>(n) * n);
  ParallelFor(n, [&](std::int64_t i) {
    for (int j = static_cast<int>(i) + 1; j < n; ++j)
      curves.of_pair[i * n + j] = ByTurn(polar[i], polar[j], rings);
  });
  return curves;
}

void LeaveOutUnturned(double unturned, Curves& curves) {
  const auto steps = std::lround(unturned / (2 * kPi) * curves.angles);
  for (std::vector<float>& curve : curves.of_pair) {
    if (curve.empty() || steps == 0) continue;
    std::fill(curve.begin(), curve.begin() + steps + 1, 0.0F);
    std::fill(curve.end() - steps, curve.end(), 0.0F);
  }
}

/// How well prints go with others when they are turned by more than a little: marks that repeat
/// themselves do so round the print's middle only.
double GoesWhenTurned(const Curves& curves) {
  const int little = curves.angles / 32;
  double sum = 0;
  for (const std::vector<float>& curve : curves.of_pair) {
    if (curve.empty()) continue;
    const float best = *std::max_element(curve.begin() + little, curve.end() - little);
    if (best > 0) sum += static_cast<double>(best) * best;
  }
  return sum;
}

/// How well view i turned by `a` goes with the others as they are turned.
double Agreement(const Curves& curves, const std::vector<int>& turns, int i, int a, double least) {
  double sum = 0;
  for (int j = 0; j < curves.count; ++j)
    if (j != i) sum += std::max(0.0, static_cast<double>(curves.Of(i, j, a, turns[j])) - least);
  return sum / std::max(1, curves.count - 1);
}

int BestTurn(const Curves& curves, const std::vector<int>& turns, int i, double least) {
  int best = 0;
  double most = -1;
  for (int a = 0; a < curves.angles; ++a)
    if (const double here = Agreement(curves, turns, i, a, least); here > most) {
      most = here;
      best = a;
    }
  return best;
}

/// Turns along the pairs that correlate best, then each by all others.
std::vector<int> Settled(const Curves& curves, double least) {
  struct Edge {
    float best;
    int i, j, turn;
  };
  std::vector<Edge> edges;
  for (int i = 0; i < curves.count; ++i)
    for (int j = i + 1; j < curves.count; ++j) {
      const std::vector<float>& curve = curves.At(i, j);
      const auto peak = std::max_element(curve.begin(), curve.end());
      edges.push_back({*peak, i, j, static_cast<int>(peak - curve.begin())});
    }
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& a, const Edge& b) { return a.best > b.best; });
  std::vector<int> turns(static_cast<std::size_t>(curves.count), 0), part(turns.size());
  std::iota(part.begin(), part.end(), 0);
  for (const Edge& e : edges) {
    if (part[e.i] == part[e.j]) continue;
    const int step = turns[e.i] + e.turn - turns[e.j], joins = part[e.j];
    for (int k = 0; k < curves.count; ++k)
      if (part[k] == joins) {
        turns[k] += step;
        part[k] = part[e.i];
      }
  }
  constexpr int kRounds = 12;
  for (int round = 0; round < kRounds; ++round) {
    bool moved = false;
    for (int i = 0; i < curves.count; ++i) {
      const int best = BestTurn(curves, turns, i, least);
      moved |= (best - turns[i]) % curves.angles != 0;
      turns[i] = best;
    }
    if (!moved) break;
  }
  for (int& turn : turns) turn = ((turn % curves.angles) + curves.angles) % curves.angles;
  return turns;
}

/// The turn that most of these views have, give or take a little.
int CommonTurn(const std::vector<int>& turns, int angles) {
  constexpr int kSteps = 4;
  int best = 0, most = -1;
  for (const int turn : turns) {
    int near = 0;
    for (const int other : turns) {
      const int off = std::abs(other - turn);
      near += std::min(off, angles - off) <= kSteps;
    }
    if (near > most) {
      most = near;
      best = turn;
    }
  }
  return best;
}

/// Around which place of the sheet prints correlate best when they are turned. A few views tell.
Vector2d MiddleOfPrint(const std::vector<FromAbove>& drawn, const PrintTurnOptions& options) {
  constexpr std::size_t kViews = 12;
  std::vector<FromAbove> some;
  const std::size_t count = std::min(kViews, drawn.size());
  for (std::size_t k = 0; k < count; ++k) some.push_back(drawn[k * drawn.size() / count]);
  const Rings coarse{options.rings / 3, options.angles / 4}, fine{options.rings, options.angles};
  const double half = 0.5 * options.cells;
  Vector2d best(half, half);
  const auto search = [&](double step, const Rings& rings) {
    const Vector2d start = best;
    double most = -1;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const Vector2d at = start + step * half * Vector2d(dx, dy);
        const double sum = GoesWhenTurned(CurvesRound(some, at, rings, false));
        if (sum > most) {
          most = sum;
          best = at;
        }
      }
  };
  search(0.08, coarse);
  search(0.03, coarse);
  search(0.012, fine);
  search(0.004, fine);
  return best;
}

}  // namespace

PrintTurns FindPrintTurns(const Scene& scene, const std::vector<Image8>& pictures,
                          const std::vector<Image8>& regions, const SupportPlane& plane,
                          const PrintTurnOptions& options) {
  const std::vector<View>& views = scene.views;
  const std::vector<Image8> standing = StandingIn(scene, plane);
  const Sheet sheet = SheetOf(plane, options);
  std::vector<FromAbove> drawn(views.size());
  ParallelFor(std::ssize(views), [&](std::int64_t i) {
    drawn[i] = Drawn(views[i], pictures[i], regions[i], standing[i], sheet);
    Flatten(options.window, drawn[i]);
  });
  const Rings rings{options.rings, options.angles};
  const Vector2d middle = MiddleOfPrint(drawn, options);
  Curves curves = CurvesRound(drawn, middle, rings, true);
  LeaveOutUnturned(options.unturned, curves);
  std::vector<int> turns = Settled(curves, options.least);
  PrintTurns found;
  std::vector<int> of_knowing;
  for (int i = 0; i < curves.count; ++i) {
    found.knows.push_back(Agreement(curves, turns, i, turns[i], options.least) > options.enough);
    if (found.knows.back()) of_knowing.push_back(turns[i]);
  }
  const int common = CommonTurn(of_knowing, options.angles);
  for (int& turn : turns) turn = (turn - common + options.angles) % options.angles;
  found.middle = sheet.At(middle.x(), middle.y());
  for (int i = 0; i < curves.count; ++i) {
    const double best = Agreement(curves, turns, i, turns[i], options.least),
                 none = Agreement(curves, turns, i, 0, options.least);
    const int turn = turns[i] > options.angles / 2 ? turns[i] - options.angles : turns[i];
    const bool is_turned = found.knows[i] && none < options.clearly * best;
    found.turn.push_back(is_turned ? 2 * kPi * turn / options.angles : 0);
  }
  return found;
}

View TurnedWithPrint(const View& view, double turn, const Vector3d& normal,
                     const Vector3d& middle) {
  const Eigen::Quaterniond back(Eigen::AngleAxisd(-turn, normal));
  const Rigid3& pose = view.camera_from_world;
  View turned = view;
  turned.camera_from_world = {pose.rotation * back, pose * (middle - back * middle)};
  return turned;
}

}  // namespace keypose::reconstruct
