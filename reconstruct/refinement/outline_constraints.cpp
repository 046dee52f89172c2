#include "reconstruct/refinement/outline_constraints.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <tuple>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

constexpr int kFine = 2;  // cells of a view's picture per pixel and axis
// pixels around the mask's crop, since the surface may extend beyond it
constexpr int kMargin = 24;
constexpr double kBeyond = 0.75;  // pixels beyond an edge without any other surface
constexpr double kHullSlack = 1;  // pixels by which a constraint may leave the hull

// Tuned on the synthetic rings of weak and rich texture, the plush dog and the skull
// (docs/algorithms/refine.md).
// Sensitivity: docs/results/sensitivity.md.
struct OutlineConstraintTuning {
  // px; largest distance of a contour inside of its neighbours on the outline
  KEYPOSE_TUNED(double, kOutermost, 0.2);
  // cosine between the surface's normal and the outline's plane
  KEYPOSE_TUNED(double, kConstraintFacing, 0.7);
  KEYPOSE_TUNED(double, kFullLength, 0.5);     // px of outline for the full weight of a constraint
  KEYPOSE_TUNED(double, kViolationFrom, 0.5);  // px outside of a mask, at least
  // times the masks' usual error, at least, that a violation lies outside of a mask
  KEYPOSE_TUNED(double, kViolationErrors, 3);
  KEYPOSE_TUNED(double, kLeastViolationFacing, 0.4);  // as kConstraintFacing, for violations
  // px; mean distance of contours from exact masks: violations then have full weight
  KEYPOSE_TUNED(double, kExactMiss, 0.15);
};

constexpr int kFrontierNeighbors = 32;
// largest distance of a vertex beside a frontier point, pixels
constexpr double kFrontierReach = 6;
constexpr int kConstraintGrain = 256;

using Constraint = OutlineConstraint;

// Two faces and the edge between them.
struct InnerEdge {
  int a = 0, b = 0;  // vertices
  int left = 0, right = 0;
};

std::vector<InnerEdge> InnerEdges(const FacesX3& faces) {
  struct Side {
    int low, high, face;
  };
  std::vector<Side> sides;
  sides.reserve(3 * static_cast<std::size_t>(faces.rows()));
  for (int f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int i = faces(f, k), j = faces(f, (k + 1) % 3);
      sides.push_back({std::min(i, j), std::max(i, j), f});
    }
  std::sort(sides.begin(), sides.end(), [](const Side& x, const Side& y) {
    return std::tie(x.low, x.high, x.face) < std::tie(y.low, y.high, y.face);
  });
  std::vector<InnerEdge> edges;
  for (std::size_t begin = 0, end = 0; begin < sides.size(); begin = end) {
    while (end < sides.size() && sides[end].low == sides[begin].low &&
           sides[end].high == sides[begin].high)
      ++end;
    if (end == begin + 2)
      edges.push_back(
          {sides[begin].low, sides[begin].high, sides[begin].face, sides[begin + 1].face});
  }
  return edges;
}

// The cells of a view's picture that the surface covers.
class Picture {
 public:
  Picture(int width, int height)
      : width_(kFine * (width + 2 * kMargin)),
        height_(kFine * (height + 2 * kMargin)),
        covered_(std::size_t(width_) * height_, 0) {}

  void Fill(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
    const std::array<Eigen::Vector2d, 3> p = {Cell(a), Cell(b), Cell(c)};
    const double top = std::min({p[0].y(), p[1].y(), p[2].y()}),
                 bottom = std::max({p[0].y(), p[1].y(), p[2].y()});
    if (!(bottom > 0 && top < height_)) return;
    const int first = std::max(0, static_cast<int>(std::floor(top))),
              last = std::min(height_ - 1, static_cast<int>(std::floor(bottom)));
    for (int y = first; y <= last; ++y) {
      const double middle = y + 0.5;
      double left = 1e30, right = -1e30;
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector2d &u = p[k], &v = p[(k + 1) % 3];
        if ((u.y() <= middle) == (v.y() <= middle)) continue;
        const double x = u.x() + (middle - u.y()) / (v.y() - u.y()) * (v.x() - u.x());
        left = std::min(left, x);
        right = std::max(right, x);
      }
      if (!(right > 0 && left < width_)) continue;
      const int begin = static_cast<int>(std::max(0.0, std::ceil(left - 0.5)));
      const int end = static_cast<int>(std::min<double>(width_, std::ceil(right - 0.5)));
      if (begin < end)
        std::fill(covered_.begin() + Index(begin, y), covered_.begin() + Index(end, y),
                  std::uint8_t{1});
    }
  }
  bool Covered(const Eigen::Vector2d& pixel) const {
    const Eigen::Vector2d cell = Cell(pixel);
    if (!(cell.x() >= 0 && cell.y() >= 0 && cell.x() < width_ && cell.y() < height_)) return false;
    return covered_[Index(static_cast<int>(cell.x()), static_cast<int>(cell.y()))] != 0;
  }

 private:
  static Eigen::Vector2d Cell(const Eigen::Vector2d& pixel) {
    return kFine * (pixel.array() + 0.5 + kMargin);
  }
  std::ptrdiff_t Index(int x, int y) const { return static_cast<std::ptrdiff_t>(y) * width_ + x; }
  int width_, height_;
  std::vector<std::uint8_t> covered_;
};

// A point on an edge of the occluding contour that may be on the outline.
struct Sample {
  int a = 0, b = 0;
  double t = 0, length = 0;  // share of the edge; pixels of outline that the sample represents
  double offset = 0, footprint = 0;
  double distance = 0;  // outside of the mask, pixels
  std::size_t bin = 0;  // pixel of the mask's outline
};

struct Surface {
  const Mesh& mesh;
  const PointsX3& normals;
  PointsX3 face_normals;
  std::vector<InnerEdge> edges;
};

class Outline {
 public:
  Outline(const Surface& surface, const Silhouettes& silhouettes, int view, double reach_px)
      : surface_(surface),
        silhouettes_(silhouettes),
        field_(silhouettes.field(view)),
        view_(view),
        reach_px_(reach_px),
        picture_(field_.width, field_.height) {}

  std::vector<Constraint> Terms() {
    Project();
    for (const InnerEdge& edge : surface_.edges)
      if (front_[edge.left] != front_[edge.right] && ahead_[edge.a] && ahead_[edge.b]) Walk(edge);
    KeepOutermost();
    return Merged();
  }

 private:
  void Project() {
    const Mesh& mesh = surface_.mesh;
    const Eigen::Vector3d center =
        -(field_.from_world.leftCols<3>().inverse() * field_.from_world.col(3));
    pixels_.resize(mesh.vertex_count());
    ahead_.resize(mesh.vertex_count());
    front_.resize(mesh.face_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
      const Eigen::Vector3d h =
          field_.from_world * Eigen::Vector3d(mesh.points.row(v)).homogeneous();
      ahead_[v] = h.z() > 0;
      pixels_[v] = h.head<2>() / (ahead_[v] ? h.z() : 1.0);
    }
    for (int f = 0; f < mesh.face_count(); ++f) {
      const int a = mesh.faces(f, 0), b = mesh.faces(f, 1), c = mesh.faces(f, 2);
      front_[f] =
          (center - Eigen::Vector3d(mesh.points.row(a))).dot(surface_.face_normals.row(f)) > 0;
      if (ahead_[a] && ahead_[b] && ahead_[c] && !Deep(a, b, c))
        picture_.Fill(pixels_[a], pixels_[b], pixels_[c]);
    }
  }

  // Whether a face is so deep in the mask that it cannot be within reach of the outline. Most faces
  // are, and need not be drawn.
  bool Deep(int a, int b, int c) const {
    const Eigen::Vector2d& p = pixels_[a];
    if (!(p.x() >= 0 && p.y() >= 0 && p.x() <= field_.width - 1 && p.y() <= field_.height - 1))
      return false;
    const double depth =
        -field_.At(static_cast<int>(p.x() + 0.5), static_cast<int>(p.y() + 0.5)) - reach_px_ - 2;
    return depth > 0 &&
           depth * depth > std::max((pixels_[b] - p).squaredNorm(), (pixels_[c] - p).squaredNorm());
  }

  void Walk(const InnerEdge& edge) {
    const double length = (pixels_[edge.b] - pixels_[edge.a]).norm();
    const int steps = std::clamp(static_cast<int>(std::ceil(length)), 1, 64);
    for (int k = 0; k < steps; ++k) Ask(edge, (k + 0.5) / steps, std::max(length, 0.1) / steps);
  }

  // Adds a sample at the share t of an edge, which represents `length` pixels of outline.
  void Ask(const InnerEdge& edge, double t, double length) {
    const PointsX3 &points = surface_.mesh.points, &normals = surface_.normals;
    const Eigen::Vector3d x = (1 - t) * points.row(edge.a) + t * points.row(edge.b);
    const Eigen::Vector3d normal =
        ((1 - t) * normals.row(edge.a) + t * normals.row(edge.b)).normalized();
    const Silhouettes::Sighting sighting = silhouettes_.See(view_, x);
    if (!sighting.seen || std::abs(sighting.distance) > reach_px_) return;
    const Eigen::Vector3d h = field_.from_world * x.homogeneous(),
                          step = field_.from_world.leftCols<3>() * normal;
    const Eigen::Vector2d pixel = h.head<2>() / h.z();
    if (AtPhotographsEnd(pixel)) return;
    const Eigen::Vector2d away = step.head<2>() - pixel * step.z();
    if (picture_.Covered(pixel + kBeyond * away.normalized())) return;
    const double facing = silhouettes_.OutlineNormal(view_, x).dot(normal);
    if (facing < OutlineConstraintTuning::kConstraintFacing) return;
    const double offset = -sighting.distance * sighting.footprint / facing;
    if (offset > 0 && !silhouettes_.Within(x + offset * normal, kHullSlack)) return;
    const Eigen::Vector2d foot = pixel - sighting.distance * away.normalized();
    samples_.push_back(
        {edge.a, edge.b, t, length, offset, sighting.footprint, sighting.distance, Bin(foot)});
  }

  std::size_t Bin(const Eigen::Vector2d& foot) const {
    const auto cell = [](double at, int size) {
      return std::clamp<std::ptrdiff_t>(std::lround(at) + kMargin, 1, size + 2 * kMargin - 2);
    };
    return static_cast<std::size_t>(cell(foot.y(), field_.height) * (field_.width + 2 * kMargin) +
                                    cell(foot.x(), field_.width));
  }

  // A rough surface has many such edges near its outline. Edges that others occlude from the
  // outline, by a fraction of a pixel, are no outline; using them would pull them outwards.
  void KeepOutermost() {
    const std::ptrdiff_t row = field_.width + 2 * kMargin;
    std::vector<float> outermost(static_cast<std::size_t>(row * (field_.height + 2 * kMargin)),
                                 -1e9f);
    for (const Sample& sample : samples_)
      outermost[sample.bin] = std::max(outermost[sample.bin], static_cast<float>(sample.distance));
    for (const Sample& sample : samples_) {
      float most = -1e9f;
      for (const std::ptrdiff_t y : {-row, std::ptrdiff_t{0}, row})
        for (const std::ptrdiff_t x : {-1, 0, 1})
          most = std::max(most, outermost[sample.bin + static_cast<std::size_t>(x + y)]);
      if (sample.distance < most - OutlineConstraintTuning::kOutermost) continue;
      constraints_.push_back(
          {sample.a, view_, sample.offset, (1 - sample.t) * sample.length, sample.footprint});
      constraints_.push_back(
          {sample.b, view_, sample.offset, sample.t * sample.length, sample.footprint});
    }
  }

  bool AtPhotographsEnd(const Eigen::Vector2d& pixel) const {
    constexpr double kNear = 2;
    return (field_.edges[0] && pixel.x() < kNear) ||
           (field_.edges[1] && pixel.x() > field_.width - 1 - kNear) ||
           (field_.edges[2] && pixel.y() < kNear) ||
           (field_.edges[3] && pixel.y() > field_.height - 1 - kNear);
  }

  std::vector<Constraint> Merged() {
    std::stable_sort(constraints_.begin(), constraints_.end(),
                     [](const Constraint& a, const Constraint& b) { return a.vertex < b.vertex; });
    std::vector<Constraint> merged;
    for (std::size_t begin = 0, end = 0; begin < constraints_.size(); begin = end) {
      Constraint sum{constraints_[begin].vertex, view_, 0, 0, constraints_[begin].footprint};
      for (; end < constraints_.size() && constraints_[end].vertex == sum.vertex; ++end) {
        sum.offset += constraints_[end].weight * constraints_[end].offset;
        sum.weight += constraints_[end].weight;
      }
      sum.offset /= sum.weight;
      sum.weight = std::min(1.0, sum.weight / OutlineConstraintTuning::kFullLength);
      merged.push_back(sum);
    }
    return merged;
  }

  const Surface& surface_;
  const Silhouettes& silhouettes_;
  const MaskField& field_;
  int view_;
  double reach_px_;
  Picture picture_;
  std::vector<Eigen::Vector2d> pixels_;
  std::vector<char> ahead_, front_;
  std::vector<Sample> samples_;
  std::vector<Constraint> constraints_;
};

bool Before(const Constraint& a, const Constraint& b) {
  return a.vertex != b.vertex ? a.vertex < b.vertex : a.view < b.view;
}

// Merges constraints to one per vertex and view.
std::vector<Constraint> Together(std::vector<Constraint> constraints) {
  std::stable_sort(constraints.begin(), constraints.end(), Before);
  std::vector<Constraint> out;
  for (std::size_t begin = 0, end = 0; begin < constraints.size(); begin = end) {
    Constraint sum{constraints[begin].vertex, constraints[begin].view, 0, 0,
                   constraints[begin].footprint};
    for (; end < constraints.size() && constraints[end].vertex == sum.vertex &&
           constraints[end].view == sum.view;
         ++end) {
      sum.offset += constraints[end].weight * constraints[end].offset;
      sum.weight += constraints[end].weight;
    }
    sum.offset /= sum.weight;
    sum.weight = std::min(1.0, sum.weight);
    out.push_back(sum);
  }
  return out;
}

std::vector<Constraint> Made(std::vector<Constraint> constraints) {
  constraints.erase(std::remove_if(constraints.begin(), constraints.end(),
                                   [](const Constraint& c) { return c.vertex < 0; }),
                    constraints.end());
  return constraints;
}

// Constraints from frontier points, even where the surface is too deep inside to have an outline.
std::vector<Constraint> FrontierTerms(const Surface& surface,
                                      const std::vector<FrontierPoint>& frontier, double reach_px) {
  const KdTree tree(surface.mesh.points);
  std::vector<Constraint> constraints(frontier.size());
  ParallelFor(
      std::ssize(frontier),
      [&](std::int64_t i) {
        const FrontierPoint& touch = frontier[i];
        double least = 1e30;
        Constraint& constraint = constraints[i];
        constraint.vertex = -1;
        for (const KdTree::Neighbor& near : tree.Nearest(touch.point, kFrontierNeighbors)) {
          const Eigen::Vector3d way =
              touch.point - Eigen::Vector3d(surface.mesh.points.row(near.index));
          const double facing = touch.normal.dot(surface.normals.row(near.index)),
                       height = way.dot(touch.normal);
          if (facing < OutlineConstraintTuning::kConstraintFacing ||
              std::abs(height) > reach_px * touch.footprint)
            continue;
          const double aside = (way - height * touch.normal).norm();
          if (aside >= least || aside > kFrontierReach * touch.footprint) continue;
          least = aside;
          constraint = {near.index, touch.view, height / facing, touch.weight, touch.footprint};
        }
      },
      kConstraintGrain);
  return Together(Made(std::move(constraints)));
}

// Mean distance of occluding contours from the masks' outlines, pixels.
double UsualMiss(const std::vector<Constraint>& contour) {
  double sum = 0, weight = 0;
  for (const Constraint& constraint : contour) {
    sum += constraint.weight * std::abs(constraint.offset / constraint.footprint);
    weight += constraint.weight;
  }
  return weight > 0 ? sum / weight : 0;
}

// Where a mask shows the background, there is no surface. The largest distance over many masks is
// large because of their noise alone, so distances below `from_px` give no constraint.
std::vector<Constraint> SilhouetteViolations(const Surface& surface, const Silhouettes& silhouettes,
                                             double weight, double from_px, double reach_px) {
  std::vector<Constraint> constraints(surface.mesh.vertex_count());
  ParallelFor(
      surface.mesh.vertex_count(),
      [&](std::int64_t v) {
        const Eigen::Vector3d x = surface.mesh.points.row(v);
        constraints[v].vertex = -1;
        for (int view = 0; view < silhouettes.views(); ++view) {
          const Silhouettes::Sighting sighting = silhouettes.See(view, x);
          if (!sighting.seen || sighting.distance < from_px || sighting.distance > reach_px)
            continue;
          const double facing = silhouettes.OutlineNormal(view, x).dot(surface.normals.row(v));
          if (facing < OutlineConstraintTuning::kLeastViolationFacing) continue;
          const double offset = -sighting.distance * sighting.footprint / facing;
          if (constraints[v].vertex < 0 || offset < constraints[v].offset)
            constraints[v] = {static_cast<int>(v), view, offset, weight, sighting.footprint};
        }
      },
      kConstraintGrain);
  return Made(std::move(constraints));
}

std::vector<Constraint> ContourTerms(const Surface& surface, const Silhouettes& silhouettes,
                                     double reach_px) {
  std::vector<std::vector<Constraint>> of_view(silhouettes.views());
  ParallelFor(silhouettes.views(), [&](std::int64_t i) {
    of_view[i] = Outline(surface, silhouettes, static_cast<int>(i), reach_px).Terms();
  });
  std::vector<Constraint> all;
  for (const std::vector<Constraint>& constraints : of_view)
    all.insert(all.end(), constraints.begin(), constraints.end());
  return Together(std::move(all));
}

}  // namespace

OutlineConstraints FindOutlineConstraints(const Mesh& mesh, const PointsX3& normals,
                                          const Silhouettes& silhouettes,
                                          const std::vector<FrontierPoint>& frontier,
                                          double violation_weight, double reach_px) {
  const Surface surface{mesh, normals, FaceNormals(mesh.points, mesh.faces),
                        InnerEdges(mesh.faces)};
  OutlineConstraints constraints;
  constraints.contour = ContourTerms(surface, silhouettes, reach_px);
  if (!frontier.empty()) {
    const std::vector<Constraint> all = FrontierTerms(surface, frontier, reach_px);
    std::set_difference(all.begin(), all.end(), constraints.contour.begin(),
                        constraints.contour.end(), std::back_inserter(constraints.frontier),
                        Before);
  }
  if (violation_weight > 0) {
    const double miss = UsualMiss(constraints.contour);
    // The weight of a violation depends on the accuracy of these masks: inaccurate masks cut off
    // parts of the figure somewhere.
    const double trust =
        std::pow(std::min(1.0, OutlineConstraintTuning::kExactMiss / std::max(miss, 1e-6)), 4);
    constraints.violations =
        SilhouetteViolations(surface, silhouettes, violation_weight * trust,
                             std::max(OutlineConstraintTuning::kViolationFrom,
                                      OutlineConstraintTuning::kViolationErrors * miss),
                             reach_px);
  }
  return constraints;
}

}  // namespace keypose::reconstruct
