#include "register/auto/surface_pull.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"
#include "register/nricp/correspondence.h"

namespace keypose::registration {

namespace {

// Chosen on tentacle seeds 0 to 9 (docs/results/tentacle.md) and the seven registration pairs
// (docs/results/registration.md); sensitivity: docs/results/sensitivity.md.
struct SurfacePullTuning {
  // A pull goes to a plane. With this share of its weight it also goes to the point.
  KEYPOSE_TUNED(double, kPointShare, 0.03);
  KEYPOSE_TUNED(double, kLeastCosine, 0.5);  // between the normals of two matched points
};

constexpr int kFirstChoices = 4, kSecondChoices = 24, kNearVertices = 4;
constexpr std::int64_t kPullGrain = 256;

double Robust(double scale, double squared_distance) {
  const double s2 = scale * scale, w = s2 / (s2 + squared_distance);
  return w * w;
}

/// Root mean square of the closest 95 %, by weight.
double TrimmedRms(std::vector<std::pair<double, double>>& squared_and_weight) {
  std::sort(squared_and_weight.begin(), squared_and_weight.end());
  double total = 0, seen = 0, sum = 0;
  for (const auto& [d2, w] : squared_and_weight) total += w;
  for (const auto& [d2, w] : squared_and_weight) {
    if (seen > 0.95 * total) break;
    seen += w;
    sum += w * d2;
  }
  return seen > 0 ? std::sqrt(sum / seen) : 0;
}

struct Pull {
  int vertex = -1;
  double weight = 0, squared_distance = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), goal = Eigen::Vector3d::Zero();
};

}  // namespace

struct SurfacePull::Impl {
  Impl(const PointsX3& p, const FacesX3& faces)
      : points(p), normals(VertexNormals(p, faces)), surface(p, faces), tree(p) {}

  Pull Forward(int vertex, bool rim, const Eigen::Vector3d& at, const Eigen::Vector3d& normal,
               const Feet& feet) const {
    Pull pull;
    // The source's own boundary may belong on the target's boundary. If such points did not pull,
    // an open source would shrink with every search.
    if (feet.allowed[vertex] ||
        (rim && feet.faces[vertex] >= 0 &&
         normal.dot(feet.normals.row(vertex).normalized()) >= SurfacePullTuning::kLeastCosine)) {
      pull.goal = feet.points.row(vertex);
      pull.normal = feet.normals.row(vertex).normalized();
      pull.vertex = vertex;
    } else {
      // Usually one of the first few is suitable, so search for more only if needed.
      for (int from = 0, to = kFirstChoices; from < to && pull.vertex < 0;
           from = to, to = kSecondChoices) {
        const std::vector<KdTree::Neighbor> near = tree.Nearest(at, to);
        for (std::size_t k = from; k < near.size() && pull.vertex < 0; ++k) {
          if (normal.dot(normals.row(near[k].index)) < SurfacePullTuning::kLeastCosine ||
              open[near[k].index])
            continue;
          pull.goal = points.row(near[k].index);
          pull.normal = normals.row(near[k].index);
          pull.vertex = vertex;
        }
      }
    }
    pull.squared_distance = (pull.goal - at).squaredNorm();
    return pull;
  }

  std::vector<int> Samples(int count) const {
    std::vector<int> samples;
    const Eigen::Index step = std::max<Eigen::Index>(1, points.rows() / count);
    for (Eigen::Index v = 0; v < points.rows(); v += step)
      if (normals.row(v).squaredNorm() > 0) samples.push_back(static_cast<int>(v));
    return samples;
  }

  /// Finds for each target sample the mesh vertex that it pulls.
  void PullBack(const PointsX3& moved, const PointsX3& moved_normals,
                const std::vector<int>& samples, std::span<Pull> pulls) const {
    const KdTree moved_tree(moved);
    ParallelBlocks(std::ssize(samples), kPullGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t k = begin; k < end; ++k) {
        Pull& pull = pulls[k];
        pull.goal = points.row(samples[k]);
        pull.normal = normals.row(samples[k]);
        const auto take = [&](const KdTree::Neighbor& close) {
          if (moved_normals.row(close.index).dot(pull.normal) < SurfacePullTuning::kLeastCosine)
            return false;
          pull.vertex = close.index;
          pull.squared_distance = close.squared_distance;
          return true;
        };
        if (take(moved_tree.Nearest(pull.goal))) continue;
        for (const KdTree::Neighbor& close : moved_tree.Nearest(pull.goal, kNearVertices))
          if (take(close)) break;
      }
    });
  }

  PointsX3 points, normals;
  TargetSurface surface;
  KdTree tree;
  std::vector<char> open;
};

SurfacePull::SurfacePull(const PointsX3& points, const FacesX3& faces)
    : impl_(std::make_unique<Impl>(points, faces)) {
  impl_->open = BoundaryVertices(static_cast<int>(points.rows()), faces);
}

SurfacePull::~SurfacePull() = default;

SurfaceGap SurfacePull::Add(const PointsX3& moved, const FacesX3& faces,
                            const std::vector<char>& rim, const Eigen::VectorXd& areas,
                            const SurfacePullTerms& terms, PointsX3& last_feet,
                            Pulls& pulls) const {
  const PointsX3 normals = VertexNormals(moved, faces);
  Feet feet = impl_->surface.FindFeet(moved, normals, SurfacePullTuning::kLeastCosine,
                                      last_feet.rows() == moved.rows() ? &last_feet : nullptr);
  const double total = areas.sum(), per_area = terms.weight / total;
  const std::vector<int> samples = impl_->Samples(terms.samples);
  std::vector<Pull> found(moved.rows() + samples.size());
  ParallelBlocks(moved.rows(), kPullGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      found[i] = impl_->Forward(static_cast<int>(i), !rim.empty() && rim[i], moved.row(i),
                                normals.row(i), feet);
  });
  last_feet = std::move(feet.points);
  impl_->PullBack(moved, normals, samples, std::span(found).subspan(moved.rows()));
  SurfaceGap gap;
  std::vector<std::pair<double, double>> forward, backward;
  const double each = terms.weight / static_cast<double>(std::max<std::size_t>(1, samples.size()));
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Pull& pull = found[k];
    const bool ahead = k < static_cast<std::size_t>(moved.rows());
    if (pull.vertex < 0) {
      if (ahead) gap.rejected += areas[static_cast<Eigen::Index>(k)] / total;
      continue;
    }
    const double weight = (ahead ? per_area * areas[pull.vertex] : each) *
                          Robust(terms.robust, pull.squared_distance);
    pulls.AddPlane(pull.vertex, weight, pull.normal, pull.goal);
    const double across = pull.normal.dot(pull.goal - moved.row(pull.vertex).transpose());
    if (ahead) {
      pulls.AddPoint(pull.vertex, SurfacePullTuning::kPointShare * weight, pull.goal);
      forward.emplace_back(pull.squared_distance, areas[pull.vertex]);
    } else {
      backward.emplace_back(across * across, 1.0);
    }
  }
  if (!terms.measure) return gap;
  gap.forward = TrimmedRms(forward);
  gap.backward = TrimmedRms(backward);
  return gap;
}

}  // namespace keypose::registration
