#include "reconstruct/meshing/points.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/tuned.h"
#include "reconstruct/meshing/merge.h"

namespace keypose::reconstruct {
namespace {

constexpr int kFewestPoints = 100;
constexpr std::int64_t kPointGrain = 2048;

// kThinning was tuned on the wrong patch of surface_test.cpp and on the masks of a set that the
// record does not name (docs/algorithms/mesh.md); of the others there is no record.
// Sensitivity: docs/results/sensitivity.md.
struct MeshPointTuning {
  // Least share of a point's neighbours that face alike. On a thin sheet half of them are on the
  // other side with opposite normals. So only a near-unanimous disagreement indicates a wrong
  // normal.
  KEYPOSE_TUNED(double, kContraryShare, 0.2);
  // Exponent of the confidence ratio. Combined with the normals' own weights, a point of a tenth of
  // the confidence has less than a tenth of the influence.
  KEYPOSE_TUNED(double, kThinning, 1.5);
  KEYPOSE_TUNED(double, kLargestArea, 16);  // of a point, in squares of the median spacing
};

PointCloud Selected(const PointCloud& cloud, const std::vector<char>& keep) {
  std::vector<int> rows;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) rows.push_back(static_cast<int>(i));
  }
  PointCloud out;
  out.points = cloud.points(rows, Eigen::all);
  out.normals = cloud.normals(rows, Eigen::all);
  if (cloud.colors.rows() > 0) out.colors = cloud.colors(rows, Eigen::all);
  if (cloud.confidence.size() > 0) out.confidence = cloud.confidence(rows);
  return out;
}

// Removes the points with keep == 0 and returns their number.
int Drop(PointCloud& cloud, const std::vector<char>& keep) {
  const int dropped = static_cast<int>(std::count(keep.begin(), keep.end(), 0));
  if (dropped > 0) cloud = Selected(cloud, keep);
  return dropped;
}

struct Neighborhood {
  Eigen::VectorXd mean_distance;  // to the k nearest
  Eigen::VectorXd spacing;        // from the k-th: k points in a disc of that radius
  Eigen::VectorXd confidence;  // largest confidence among the k nearest for the same place; empty
                               // without confidences
  Eigen::VectorXd agreeing;    // share of the k nearest whose normal is on the same side
};

// The largest confidence, the point's own included, among the neighbours above or below it that
// face the same way. Only those are inconsistent with it; neighbours beside it are not.
double SurestAbove(const PointCloud& cloud, int i, const std::vector<KdTree::Neighbor>& near,
                   double spacing) {
  double surest = cloud.confidence[i];
  for (const KdTree::Neighbor& n : near) {
    const Eigen::RowVector3d step = cloud.points.row(n.index) - cloud.points.row(i);
    const double along = step.dot(cloud.normals.row(i));
    if (n.squared_distance - along * along > spacing * spacing ||
        cloud.normals.row(n.index).dot(cloud.normals.row(i)) < 0.5)
      continue;
    surest = std::max<double>(surest, cloud.confidence[n.index]);
  }
  return surest;
}

Neighborhood Measure(const PointCloud& cloud, int neighbors) {
  const KdTree tree(cloud.points);
  const Eigen::Index count = cloud.points.rows();
  const bool graded = cloud.confidence.size() > 0;
  Neighborhood out{Eigen::VectorXd::Zero(count), Eigen::VectorXd::Zero(count),
                   Eigen::VectorXd::Zero(graded ? count : 0), Eigen::VectorXd::Zero(count)};
  ParallelBlocks(count, kPointGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      // The query returns the point itself too.
      const auto near = tree.Nearest(cloud.points.row(i).transpose(), neighbors + 1);
      double sum = 0;
      int agree = 0;
      for (const auto& n : near) {
        sum += std::sqrt(n.squared_distance);
        if (n.index != i && cloud.normals.row(n.index).dot(cloud.normals.row(i)) > 0) ++agree;
      }
      out.mean_distance[i] = sum / neighbors;
      out.spacing[i] = std::sqrt(near.back().squared_distance * std::numbers::pi / neighbors);
      out.agreeing[i] = static_cast<double>(agree) / neighbors;
      if (graded) out.confidence[i] = SurestAbove(cloud, static_cast<int>(i), near, out.spacing[i]);
    }
  });
  return out;
}

// The mean distance from a point to its `neighbors` nearest, for points evenly distributed on a
// plane with one point per square of this side.
double EvenMeanDistance(double side, int neighbors) {
  return 2.0 / 3 * side * std::sqrt(neighbors / std::numbers::pi);
}

// The divergence theorem on samples: the sum of area-weighted normals times offsets from the
// centroid is three times the volume.
bool PointInside(const PointCloud& cloud, const Eigen::VectorXd& spacing) {
  const Eigen::RowVector3d middle = cloud.points.colwise().mean();
  double flux = 0;
  for (Eigen::Index i = 0; i < cloud.points.rows(); ++i) {
    flux += spacing[i] * spacing[i] * cloud.normals.row(i).dot(cloud.points.row(i) - middle);
  }
  return flux < 0;
}

// A point's weight includes the area around it, so that sparse points of the hull keep their
// influence beside dense neighbours.
Eigen::VectorXf Weights(const FilteredPoints& points) {
  Eigen::VectorXf weights(points.spacing.size());
  for (Eigen::Index i = 0; i < weights.size(); ++i) {
    const double ratio = points.spacing[i] / points.median_spacing;
    weights[i] = static_cast<float>(std::clamp(
        points.cloud.confidence[i] * std::min(MeshPointTuning::kLargestArea, ratio * ratio), 0.01,
        1.0));
  }
  return weights;
}

// Selects a share of the points, evenly and the same in every run.
bool Chosen(std::uint64_t index, double share) {
  std::uint64_t z = (index + 1) * 0x9E3779B97F4A7C15ull;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53 < share;
}

void RequireEnough(const PointCloud& cloud, const std::string& what, Eigen::Index before) {
  if (cloud.points.rows() >= kFewestPoints) return;
  throw InputError("mesh: of the " + std::to_string(before) + " points of " + what + " only " +
                   std::to_string(cloud.points.rows()) +
                   " are left after outlier removal, and a surface needs " +
                   std::to_string(kFewestPoints) +
                   "; raise `outlier_ratio`, lower `min_confidence`, or look at the cloud");
}

}  // namespace

void RequireMeshable(const PointCloud& cloud, const std::string& what) {
  const Eigen::Index count = cloud.points.rows();
  if (count < kFewestPoints) {
    throw InputError("mesh: " + what + " has " + std::to_string(count) +
                     " points; a surface needs at least " + std::to_string(kFewestPoints) +
                     ": check the masks and the report of the dense step");
  }
  if (cloud.normals.rows() != count)
    throw InputError("mesh: " + what +
                     " has no normals (nx ny nz); a surface cannot be fitted without them: take a "
                     "cloud of the dense step");
  for (Eigen::Index i = 0; i < count; ++i) {
    if (!cloud.points.row(i).allFinite() || !cloud.normals.row(i).allFinite())
      throw InputError("mesh: point " + std::to_string(i) + " of " + what +
                       " has a value that is not a finite number; remove it");
  }
  const Eigen::RowVector3d extent =
      cloud.points.colwise().maxCoeff() - cloud.points.colwise().minCoeff();
  if (!(extent.maxCoeff() > 0))
    throw InputError("mesh: all " + std::to_string(count) + " points of " + what +
                     " lie in one place; the reconstruction before it failed");
}

namespace {

void DropUnsure(double min_confidence, FilteredPoints& out) {
  std::vector<char> keep(out.cloud.points.rows(), 1);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const bool sure = out.cloud.confidence.size() == 0 || out.cloud.confidence[i] >= min_confidence;
    keep[i] = sure && out.cloud.normals.row(i).norm() > 1e-6;
  }
  out.removed_unsure = Drop(out.cloud, keep);
}

/// Drops points far from others, some of the less sure ones where there are many, and those whose
/// neighbours have other normals.
void DropOutliers(const PointFilterOptions& options, double merge_cell, FilteredPoints& out) {
  Neighborhood near = Measure(out.cloud, options.neighbors);
  // Several layers of points are denser than a merged layer. With this limit, the hull's points,
  // one per voxel, are no outliers beside them.
  const double usual =
      std::max(UpperMedian(near.mean_distance), EvenMeanDistance(merge_cell, options.neighbors));
  const double limit = options.outlier_ratio > 0 ? options.outlier_ratio * usual : INFINITY;
  std::vector<char> keep(out.cloud.points.rows(), 1), aligned;
  const bool graded = options.thin_unsure && out.cloud.confidence.size() > 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    keep[i] = near.mean_distance[i] <= limit;
    out.removed_outliers += !keep[i];
    if (keep[i] && graded &&
        !Chosen(i, std::pow(out.cloud.confidence[i] / near.confidence[i],
                            MeshPointTuning::kThinning))) {
      keep[i] = 0;
      ++out.removed_thinned;
    }
    if (keep[i]) aligned.push_back(near.agreeing[i] >= MeshPointTuning::kContraryShare);
  }
  Drop(out.cloud, keep);
  out.removed_contrary = Drop(out.cloud, aligned);
}

}  // namespace

FilteredPoints FilterPoints(PointCloud cloud, const PointFilterOptions& options, double merge_cell,
                            const std::string& what, Progress* progress) {
  RequireMeshable(cloud, what);
  const Eigen::Index before = cloud.points.rows();
  FilteredPoints out;
  out.cloud = std::move(cloud);
  DropUnsure(options.min_confidence, out);
  RequireEnough(out.cloud, what, before);
  out.cloud.normals.rowwise().normalize();
  if (merge_cell > 0) {
    const Eigen::Index unmerged = out.cloud.points.rows();
    out.cloud = MergeWithinCells(out.cloud, merge_cell);
    out.merged = static_cast<int>(unmerged - out.cloud.points.rows());
    RequireEnough(out.cloud, what, before);
  }

  ReportProgress(progress, 0.1, "removing outliers");
  DropOutliers(options, merge_cell, out);
  RequireEnough(out.cloud, what, before);

  ReportProgress(progress, 0.6, "measuring the sampling");
  out.spacing = Measure(out.cloud, options.neighbors).spacing;
  out.median_spacing = UpperMedian(out.spacing);
  if (!(out.median_spacing > 0))
    throw InputError("mesh: most points of " + what +
                     " lie on top of each other; fuse the cloud first, so that places are unique");
  if (out.cloud.confidence.size() > 0) out.weights = Weights(out);
  out.normals_flipped = PointInside(out.cloud, out.spacing);
  if (out.normals_flipped) out.cloud.normals = -out.cloud.normals;
  return out;
}

}  // namespace keypose::reconstruct
