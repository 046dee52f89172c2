#include "reconstruct/stereo/gap_fill.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/values/tuned.h"
#include "views/stereo/patch_match_sweep.h"

namespace keypose::reconstruct {
namespace {

constexpr int kLeastConfirmed = 4, kLeastMasked = 16;  // pixels of a cell, of 16

// Tuned on the synthetic weak ring (docs/algorithms/dense.md). Sensitivity:
// docs/results/sensitivity.md.
struct GapFillTuning {
  // px of depth; largest depth change by the quadratic terms over the reach
  KEYPOSE_TUNED(double, kSteepestBend, 30);
  KEYPOSE_TUNED(double, kLeastNoise, 0.5);  // px; of a cell's depth
  // times `agreement`, by which a surface nearer than a known cell contradicts it; a known cell
  // stores one depth, even where the surface is steep
  KEYPOSE_TUNED(double, kSlack, 3);
};

constexpr double kMiddle = 0.5 * (kCellPixels - 1);
constexpr float kGap = 0, kNothing = -1;

double MiddleOf(int cell) { return cell * kCellPixels + kMiddle; }

float CellDepth(const PreparedView& view, const stereo::PlaneMap& map,
                const std::vector<char>& confirmed, int cx, int cy) {
  const GreyMask& grey = view.levels[0].grey;
  double sum = 0;
  int count = 0, masked = 0;
  for (int y = cy * kCellPixels; y < (cy + 1) * kCellPixels; ++y)
    for (int x = cx * kCellPixels; x < (cx + 1) * kCellPixels; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * map.width + x;
      masked += InMask(grey.data[pixel]);
      if (!confirmed[pixel]) continue;
      const stereo::PlaneHypothesis plane = map.Plane(map.Find(pixel));
      sum += plane.inverse_depth + plane.gx * (MiddleOf(cx) - x) + plane.gy * (MiddleOf(cy) - y);
      ++count;
    }
  if (count >= kLeastConfirmed && sum > 0) return static_cast<float>(sum / count);
  return masked >= kLeastMasked ? kGap : kNothing;
}

// z = c0 + c1 u + c2 v + c3 u^2 + c4 uv + c5 v^2 over the cells around one; z in pixels of depth, u
// and v in units of the reach.
class Bridge {
 public:
  explicit Bridge(int reach) : reach_(reach) {
    for (int dy = -reach; dy <= reach; ++dy)
      for (int dx = -reach; dx <= reach; ++dx) {
        const double squared = static_cast<double>(dx * dx + dy * dy) / (reach * reach);
        if (squared > 1 || squared == 0) continue;
        Spot spot{dx, dy, Sector(dx, dy), std::exp(-2 * squared), {}};
        const double u = static_cast<double>(dx) / reach, v = static_cast<double>(dy) / reach;
        spot.row << 1, u, v, u * u, u * v, v * v;
        spots_.push_back(spot);
      }
  }

  // The plane at the cell's middle; inverse depth 0 if the fit is not reliable.
  stereo::PlaneHypothesis At(const SurfaceCells& cells, const Pinhole& camera, int cx, int cy,
                             const GapFillOptions& options) const {
    float reference = 0;
    unsigned sectors = 0;
    for (const Spot& spot : spots_) {
      const float w = Known(cells, cx + spot.dx, cy + spot.dy);
      if (w <= 0) continue;
      sectors |= 1u << spot.sector, reference = std::max(reference, w);
    }
    if (!Surrounded(sectors)) return {};
    const double scale = camera.fx / reference;  // inverse depth to pixels of depth
    Matrix a = Matrix::Zero();
    Row b = Row::Zero();
    a.diagonal() << 1e-6, 1e-6, 1e-6, kBendWeight, kBendWeight, kBendWeight;
    double squares = 0, weights = 0;
    for (const Spot& spot : spots_) {
      const float w = Known(cells, cx + spot.dx, cy + spot.dy);
      if (w <= 0) continue;
      const double z = scale * (w - reference);
      a.selfadjointView<Eigen::Lower>().rankUpdate(spot.row, spot.weight);
      b += spot.weight * z * spot.row;
      squares += spot.weight * z * z;
      weights += spot.weight;
    }
    const Eigen::LDLT<Matrix> ldlt(a);
    const Row c = ldlt.solve(b);
    const double residual = std::sqrt(std::max(0.0, (squares - c.dot(b)) / weights));
    const double error = std::max(GapFillTuning::kLeastNoise, residual) *
                         std::sqrt(std::max(0.0, ldlt.solve(Row::Unit(0))[0]));
    if (!(residual <= options.largest_residual && error <= options.largest_error)) return {};
    const double per_pixel = 1 / (scale * reach_ * kCellPixels);
    return {static_cast<float>(reference + c[0] / scale), static_cast<float>(c[1] * per_pixel),
            static_cast<float>(c[2] * per_pixel)};
  }

 private:
  using Row = Eigen::Matrix<double, 6, 1>;
  using Matrix = Eigen::Matrix<double, 6, 6>;
  static inline const double kBendWeight =
      GapFillTuning::kLeastNoise * GapFillTuning::kLeastNoise /
      (GapFillTuning::kSteepestBend * GapFillTuning::kSteepestBend);
  struct Spot {
    int dx, dy, sector;
    double weight;
    Row row;
  };

  static int Sector(int dx, int dy) {
    return (static_cast<int>(std::floor(std::atan2(dy, dx) * 4 / M_PI)) + 8) % 8;
  }
  static float Known(const SurfaceCells& cells, int x, int y) {
    return x < 0 || y < 0 || x >= cells.width || y >= cells.height ? kNothing : cells.At(x, y);
  }
  static bool Surrounded(unsigned sectors) {
    const unsigned round = sectors | sectors << 8;
    for (int k = 0; k < 8; ++k)
      if ((round >> k & 7u) == 0) return false;
    return true;
  }

  int reach_;
  std::vector<Spot> spots_;
};

struct BridgedView {
  std::vector<stereo::PlaneHypothesis> planes;  // of gaps; inverse depth 0: none
  std::vector<char> used;
};

BridgedView BridgeView(const SurfaceCells& cells, const Pinhole& camera, const Bridge& bridge,
                       const GapFillOptions& options) {
  BridgedView out{std::vector<stereo::PlaneHypothesis>(cells.inverse_depth.size()),
                  std::vector<char>(cells.inverse_depth.size(), 0)};
  for (int y = 0; y < cells.height; ++y)
    for (int x = 0; x < cells.width; ++x)
      if (cells.At(x, y) == kGap)
        out.planes[static_cast<std::size_t>(y) * cells.width + x] =
            bridge.At(cells, camera, x, y, options);
  return out;
}

class Filler {
 public:
  Filler(const std::vector<PreparedView>& views, const std::vector<std::vector<int>>& sources,
         const std::vector<SurfaceCells>& cells, const GapFillOptions& options)
      : views_(views), sources_(sources), cells_(cells), options_(options), bridged_(views.size()) {
    const Bridge bridge(options.reach);
    ParallelFor(std::ssize(views), [&](std::int64_t i) {
      bridged_[i] = BridgeView(cells[i], views[i].camera(), bridge, options);
    });
  }

  PointCloud Run() {
    for (std::size_t i = 0; i < views_.size(); ++i) Emit(static_cast<int>(i));
    PointCloud cloud;
    const auto rows = std::ssize(found_);
    cloud.points.resize(rows, 3);
    cloud.normals.resize(rows, 3);
    cloud.colors.resize(rows, 3);
    cloud.confidence = Eigen::VectorXf::Constant(rows, kGapConfidence);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const Found& found = found_[i];
      cloud.points.row(i) = found.point;
      cloud.normals.row(i) = found.normal;
      for (int c = 0; c < 3; ++c) cloud.colors(i, c) = found.color[c];
    }
    return cloud;
  }

 private:
  struct Found {
    Eigen::Vector3d point, normal;
    std::array<std::uint8_t, 3> color;
  };
  enum class Opinion { kNone, kAgrees, kContradicts };

  void Emit(int view) {
    const SurfaceCells& cells = cells_[view];
    const Pinhole& camera = views_[view].camera();
    const Eigen::Matrix3d world_from_camera =
        views_[view].camera_from_world.rotation.conjugate().toRotationMatrix();
    for (std::size_t i = 0; i < bridged_[view].planes.size(); ++i) {
      const stereo::PlaneHypothesis& plane = bridged_[view].planes[i];
      if (!(plane.inverse_depth > 0) || bridged_[view].used[i]) continue;
      const double x = MiddleOf(static_cast<int>(i % cells.width)),
                   y = MiddleOf(static_cast<int>(i / cells.width));
      const Eigen::Vector3d point =
          views_[view].Center() + world_from_camera * camera.Ray(x, y) / plane.inverse_depth;
      if (!Supported(view, point)) continue;
      const std::uint8_t* rgb = views_[view].color.at(static_cast<int>(x), static_cast<int>(y));
      found_.push_back(
          {point, world_from_camera * PlaneNormal(camera, x, y, plane), {rgb[0], rgb[1], rgb[2]}});
    }
  }

  // Also marks the cells of other views that have the same point.
  bool Supported(int view, const Eigen::Vector3d& point) {
    int agreeing = 1;
    std::vector<std::pair<int, std::size_t>> same;
    for (const int s : sources_[view]) {
      std::size_t cell = 0;
      const Opinion opinion = Ask(s, point, &cell);
      if (opinion == Opinion::kContradicts) return false;
      if (opinion != Opinion::kAgrees) continue;
      ++agreeing;
      same.emplace_back(s, cell);
    }
    if (agreeing < options_.least_views) return false;
    for (const auto& [s, cell] : same) bridged_[s].used[cell] = 1;
    return true;
  }

  Opinion Ask(int view, const Eigen::Vector3d& point, std::size_t* cell) const {
    const SurfaceCells& cells = cells_[view];
    if (cells.inverse_depth.empty()) return Opinion::kNone;
    const Eigen::Vector3d x = views_[view].camera_from_world * point;
    if (x.z() <= 0) return Opinion::kNone;
    const Pinhole& camera = views_[view].camera();
    const Eigen::Vector2d p = camera.Project(x);
    const int px = static_cast<int>(std::lround(p.x())), py = static_cast<int>(std::lround(p.y()));
    if (px < 0 || py < 0 || px / kCellPixels >= cells.width || py / kCellPixels >= cells.height)
      return Opinion::kNone;
    if (!InMask(*views_[view].levels[0].grey.at(px, py))) return Opinion::kContradicts;
    const int cx = px / kCellPixels, cy = py / kCellPixels;
    *cell = static_cast<std::size_t>(cy) * cells.width + cx;
    const stereo::PlaneHypothesis& plane = bridged_[view].planes[*cell];
    double w = cells.inverse_depth[*cell];
    if (plane.inverse_depth > 0)
      w = plane.inverse_depth + plane.gx * (p.x() - MiddleOf(cx)) +
          plane.gy * (p.y() - MiddleOf(cy));
    if (!(w > 0)) return Opinion::kNone;
    const double nearer = (1 / x.z() - w) * camera.fx /
                          w;  // pixels on the surface, positive in front of the view's own depth
    if (std::abs(nearer) <= options_.agreement) return Opinion::kAgrees;
    return nearer > GapFillTuning::kSlack * options_.agreement && !(plane.inverse_depth > 0)
               ? Opinion::kContradicts
               : Opinion::kNone;
  }

  const std::vector<PreparedView>& views_;
  const std::vector<std::vector<int>>& sources_;
  const std::vector<SurfaceCells>& cells_;
  const GapFillOptions& options_;
  std::vector<BridgedView> bridged_;
  std::vector<Found> found_;
};

}  // namespace

SurfaceCells CellsOf(const PreparedView& view, const stereo::PlaneMap& map,
                     const std::vector<char>& confirmed) {
  SurfaceCells cells{map.width / kCellPixels, map.height / kCellPixels, {}};
  cells.inverse_depth.reserve(static_cast<std::size_t>(cells.width) * cells.height);
  for (int y = 0; y < cells.height; ++y)
    for (int x = 0; x < cells.width; ++x)
      cells.inverse_depth.push_back(CellDepth(view, map, confirmed, x, y));
  return cells;
}

PointCloud FillGaps(const std::vector<PreparedView>& views,
                    const std::vector<std::vector<int>>& sources,
                    const std::vector<SurfaceCells>& cells, const GapFillOptions& options) {
  return Filler(views, sources, cells, options).Run();
}

}  // namespace keypose::reconstruct
