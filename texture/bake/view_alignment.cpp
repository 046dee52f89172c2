#include "texture/bake/view_alignment.h"

#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::texture {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Chosen on held-out photographs of the plush dog and the skull
/// (docs/algorithms/bake.md) and on the cameras of bake_test that are 1.3
/// px off; no record of single values.
struct AlignmentTuning {
  /// square root of linear light: differences of this size have a quarter of the weight (other
  /// hairs, highlights, occlusion)
  KEYPOSE_TUNED(double, kLikeness, 0.06);
  /// square root of linear light per stored pixel: smaller gradients are noise and rounding, and
  /// have no influence
  KEYPOSE_TUNED(double, kFlatSlope, 0.005);
  /// weight of the lattice's smoothness, in the photograph's mean information per node
  KEYPOSE_TUNED(double, kSmoothness, 0.5);
  KEYPOSE_TUNED(double, kStiffness, 0.02);  ///< weight of zero displacement, likewise
  KEYPOSE_TUNED(double, kMostPx, 12);       ///< px: largest displacement of a node
};
/// Stored levels of the photographs, from coarse to fine, and steps on each.
constexpr int kLevels[] = {3, 2, 1};
constexpr int kSteps[] = {3, 3, 3};

struct Observation {
  int point;
  float weight;
  Vector2d pixel;  ///< predicted by the camera
};

/// Bilinear value with its gradient; false where a pixel has no object.
struct Read {
  double value = 0;
  Vector2d slope = Vector2d::Zero();
};
bool ReadAt(const ImageF& image, const Vector2d& at, Read& read) {
  const double x = at.x() - 0.5, y = at.y() - 0.5;
  if (!(x >= 0 && y >= 0 && x < image.width - 1 && y < image.height - 1)) return false;
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
  const double fx = x - x0, fy = y - y0;
  const double a = *image.at(x0, y0), b = *image.at(x0 + 1, y0), c = *image.at(x0, y0 + 1),
               d = *image.at(x0 + 1, y0 + 1);
  read.value = (1 - fy) * ((1 - fx) * a + fx * b) + fy * ((1 - fx) * c + fx * d);
  read.slope = {(1 - fy) * (b - a) + fy * (d - c), (1 - fx) * (c - a) + fx * (d - b)};
  return std::isfinite(read.value);
}

/// The four nodes around a pixel and their weights.
struct Corners {
  int node[4];
  double weight[4];
};
Corners CornersAt(const Warp& warp, const Vector2d& pixel) {
  const double x = std::clamp((pixel.x() - warp.origin.x()) / warp.spacing, 0.0, warp.wide - 1.0),
               y = std::clamp((pixel.y() - warp.origin.y()) / warp.spacing, 0.0, warp.high - 1.0);
  const int x0 = std::min(static_cast<int>(x), warp.wide - 2),
            y0 = std::min(static_cast<int>(y), warp.high - 2);
  const double fx = x - x0, fy = y - y0;
  const int first = y0 * warp.wide + x0;
  return {{first, first + 1, first + warp.wide, first + warp.wide + 1},
          {(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy}};
}

/// The pictures and means of one level.
struct Round {
  std::vector<ImageF> details;  ///< one per view
  int level = 0;
  std::vector<float> mean, weight;  ///< one per point: over the views so far
};

class Aligner {
 public:
  Aligner(const Mesh& mesh, const std::vector<BakeView>& views, const std::vector<char>& used,
          const AlignOptions& options)
      : views_(views), options_(options), warps_(views.size()), seen_(views.size()) {
    const SurfaceSamples surface = SampleSurface(mesh.points, mesh.faces, options.samples, 21);
    const PointsX3 normals = FaceNormals(mesh.points, mesh.faces);
    points_ = static_cast<int>(surface.points.rows());
    ParallelFor(std::ssize(views), [&](std::int64_t v) {
      if (!used[v] || views[v].sees_nothing()) return;
      for (int i = 0; i < points_; ++i) {
        const Vector3d x = surface.points.row(i), n = normals.row(surface.faces[i]);
        const double cosine = n.dot((views[v].center() - x).normalized());
        if (cosine < 0.35) continue;
        const Sighting sighting = views[v].See(x);
        if (sighting.trust > 0)
          seen_[v].push_back(
              {i, static_cast<float>(sighting.trust * cosine * cosine), sighting.pixel});
      }
      StartWarp(static_cast<int>(v));
    });
  }

  std::vector<Warp> Solve() {
    Round round;
    for (std::size_t l = 0; l < std::size(kLevels); ++l) {
      round.level = kLevels[l];
      round.details.assign(views_.size(), ImageF());
      ParallelFor(std::ssize(views_), [&](std::int64_t v) {
        if (warps_[v].wide > 0) round.details[v] = views_[v].Detail(round.level);
      });
      round.mean.assign(points_, 0);
      round.weight.assign(points_, 0);
      for (int step = 0; step < kSteps[l]; ++step) {
        MeasureMeans(round);
        ParallelFor(std::ssize(views_), [&](std::int64_t v) {
          if (warps_[v].wide > 0) StepView(static_cast<int>(v), round);
        });
      }
    }
    return std::move(warps_);
  }

 private:
  void StartWarp(int v) {
    if (seen_[v].size() < 100) return;
    Vector2d low = seen_[v].front().pixel, high = low;
    for (const Observation& o : seen_[v]) {
      low = low.cwiseMin(o.pixel);
      high = high.cwiseMax(o.pixel);
    }
    Warp& warp = warps_[v];
    warp.origin = low;
    warp.spacing = std::max(8.0, (high - low).maxCoeff() / (options_.nodes - 1));
    warp.wide = static_cast<int>(std::ceil((high.x() - low.x()) / warp.spacing)) + 1;
    warp.high = static_cast<int>(std::ceil((high.y() - low.y()) / warp.spacing)) + 1;
    warp.wide = std::max(warp.wide, 2);
    warp.high = std::max(warp.high, 2);
    warp.nodes.assign(static_cast<std::size_t>(warp.wide) * warp.high, Vector2d::Zero());
  }

  bool ReadView(int v, const Observation& o, const Round& round, Read& read) const {
    const BakeView::Stored stored = views_[v].StoredAt(round.level, warps_[v].Moved(o.pixel));
    if (!ReadAt(round.details[v], stored.pixel, read)) return false;
    read.slope *= stored.scale;
    return true;
  }

  /// One pass over the views in their order, so that sums are the same for any thread count; blocks
  /// of points are independent.
  void MeasureMeans(Round& round) {
    std::vector<float> sum(points_, 0), weight(points_, 0);
    // The observations of a view are in ascending order of points: each block of points finds its
    // part of every view.
    constexpr int kBlock = 4096;
    ParallelBlocks(points_, kBlock, [&](std::int64_t begin, std::int64_t end) {
      for (std::size_t v = 0; v < views_.size(); ++v) {
        if (warps_[v].wide == 0) continue;
        auto o = std::lower_bound(seen_[v].begin(), seen_[v].end(), begin,
                                  [](const Observation& a, std::int64_t p) { return a.point < p; });
        for (; o != seen_[v].end() && o->point < end; ++o) {
          Read read;
          if (!ReadView(static_cast<int>(v), *o, round, read)) continue;
          float w = o->weight;
          if (round.weight[o->point] > 0)
            w *= static_cast<float>(Robust(read.value - round.mean[o->point]));
          sum[o->point] += w * static_cast<float>(read.value);
          weight[o->point] += w;
        }
      }
    });
    for (int i = 0; i < points_; ++i) round.mean[i] = weight[i] > 0 ? sum[i] / weight[i] : 0;
    round.weight = std::move(weight);
  }

  static double Robust(double r) {
    const double u = r / AlignmentTuning::kLikeness;
    return 1 / ((1 + u * u) * (1 + u * u));
  }

  /// The normal equations of one lattice, by pairs of adjacent nodes.
  struct Normal {
    std::vector<Eigen::Matrix2d> blocks;  ///< see Slot
    Eigen::VectorXd right;
    double information = 0, total = 0;  ///< sums over all gradients and weights
  };

  Normal Collect(int v, const Round& round) const {
    const Warp& warp = warps_[v];
    Normal normal;
    normal.blocks.assign(warp.nodes.size() * 9, Eigen::Matrix2d::Zero());
    normal.right.setZero(2 * std::ssize(warp.nodes));
    for (const Observation& o : seen_[v]) {
      Read read;
      // With a single photograph the mean is that photograph.
      if (round.weight[o.point] < 1.5f * o.weight || !ReadView(v, o, round, read)) continue;
      const double r = read.value - round.mean[o.point], w = o.weight * Robust(r);
      const Corners at = CornersAt(warp, o.pixel);
      const Eigen::Matrix2d square = w * read.slope * read.slope.transpose();
      normal.information += square.trace();
      normal.total += w;
      for (int a = 0; a < 4; ++a) {
        normal.right.segment<2>(2 * at.node[a]) -= at.weight[a] * w * r * read.slope;
        for (int b = 0; b < 4; ++b)
          if (at.node[b] <= at.node[a])
            normal.blocks[Slot(warp, at.node[a], at.node[b])] +=
                at.weight[a] * at.weight[b] * square;
      }
    }
    return normal;
  }

  /// The lower triangle's entries.
  static std::vector<Eigen::Triplet<double>> EntriesOf(const Warp& warp, const Normal& normal) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int a = 0; a < std::ssize(warp.nodes); ++a)
      for (int dy = -1; dy <= 0; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const int b = a + dy * warp.wide + dx;
          if (b > a || b < 0) continue;
          const Eigen::Matrix2d& m = normal.blocks[Slot(warp, a, b)];
          for (int i = 0; i < 2; ++i)
            for (int j = 0; j < 2; ++j)
              if (2 * a + i >= 2 * b + j && m(i, j) != 0)
                entries.emplace_back(2 * a + i, 2 * b + j, m(i, j));
        }
    return entries;
  }

  /// One Gauss-Newton step of one lattice.
  void StepView(int v, const Round& round) {
    using Tuning = AlignmentTuning;
    Warp& warp = warps_[v];
    const int count = SizeOf(warp.nodes);
    Normal normal = Collect(v, round);
    if (!(normal.information > 0)) return;
    const double unit = normal.information / (2.0 * count),
                 scale = views_[v].StoredAt(round.level, Vector2d::Zero()).scale;
    const double flat = Tuning::kFlatSlope * scale;
    std::vector<Eigen::Triplet<double>> entries = EntriesOf(warp, normal);
    AddPriors(warp, Tuning::kSmoothness * unit,
              Tuning::kStiffness * unit + flat * flat * normal.total / count, entries,
              normal.right);
    Eigen::SparseMatrix<double> matrix(2 * count, 2 * count);
    matrix.setFromTriplets(entries.begin(), entries.end());
    const Eigen::VectorXd solved =
        Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>, Eigen::Lower>(matrix).solve(
            normal.right);
    if (!solved.allFinite()) return;
    // Gradients are valid within about a pixel of this level.
    const double most_step = 1.5 / scale;
    for (int a = 0; a < count; ++a) {
      Vector2d step = solved.segment<2>(2 * a);
      if (step.norm() > most_step) step *= most_step / step.norm();
      warp.nodes[a] += step;
      if (warp.nodes[a].norm() > Tuning::kMostPx)
        warp.nodes[a] *= Tuning::kMostPx / warp.nodes[a].norm();
    }
  }

  /// Index of the block of adjacent nodes a >= b.
  static std::size_t Slot(const Warp& warp, int a, int b) {
    const int dy = b / warp.wide - a / warp.wide, dx = b % warp.wide - a % warp.wide;
    return static_cast<std::size_t>(a) * 9 + static_cast<std::size_t>((dy + 1) * 3 + dx + 1);
  }

  static void AddPriors(const Warp& warp, double smooth, double stiff,
                        std::vector<Eigen::Triplet<double>>& entries, Eigen::VectorXd& right) {
    const int count = SizeOf(warp.nodes);
    for (int a = 0; a < count; ++a) {
      for (int i = 0; i < 2; ++i) entries.emplace_back(2 * a + i, 2 * a + i, stiff);
      right.segment<2>(2 * a) -= stiff * warp.nodes[a];
      for (const int b : {a % warp.wide > 0 ? a - 1 : -1, a - warp.wide}) {
        if (b < 0) continue;
        const Vector2d apart = warp.nodes[a] - warp.nodes[b];
        right.segment<2>(2 * a) -= smooth * apart;
        right.segment<2>(2 * b) += smooth * apart;
        for (int i = 0; i < 2; ++i) {
          entries.emplace_back(2 * a + i, 2 * a + i, smooth);
          entries.emplace_back(2 * b + i, 2 * b + i, smooth);
          entries.emplace_back(2 * a + i, 2 * b + i, -smooth);
        }
      }
    }
  }

  const std::vector<BakeView>& views_;
  AlignOptions options_;
  int points_ = 0;
  std::vector<Warp> warps_;
  std::vector<std::vector<Observation>> seen_;  ///< for each view, ascending by point
};

}  // namespace

Vector2d Warp::Moved(const Vector2d& pixel) const {
  if (wide == 0) return pixel;
  const Corners at = CornersAt(*this, pixel);
  Vector2d moved = pixel;
  for (int k = 0; k < 4; ++k) moved += at.weight[k] * nodes[at.node[k]];
  return moved;
}

std::vector<Warp> AlignPhotographs(const Mesh& mesh, const std::vector<BakeView>& views,
                                   const std::vector<char>& used, const AlignOptions& options) {
  return Aligner(mesh, views, used, options).Solve();
}

}  // namespace keypose::texture
