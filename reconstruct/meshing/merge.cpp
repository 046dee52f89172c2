#include "reconstruct/meshing/merge.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <vector>

#include "core/numbers/parallel.h"
#include "reconstruct/cloud/facing_cells.h"

namespace keypose::reconstruct {
namespace {

constexpr std::int64_t kGrain = 4096;

struct Sum {
  Eigen::RowVector3d point = Eigen::RowVector3d::Zero(), normal = point, color = point;
  double weight = 0, confidence = 0, confidence_weight = 0;
};

void AddTo(const PointCloud& cloud, int i, Sum* sum) {
  const double confidence = cloud.confidence.size() ? std::max(1e-3f, cloud.confidence[i]) : 1;
  const double weight = confidence * confidence;
  sum->point += weight * cloud.points.row(i);
  sum->normal += weight * cloud.normals.row(i);
  if (cloud.colors.rows()) sum->color += weight * cloud.colors.row(i).cast<double>();
  sum->weight += weight;
  if (cloud.confidence.size()) {
    sum->confidence += confidence * cloud.confidence[i];
    sum->confidence_weight += confidence;
  }
}

void Store(const Sum& sum, int at, PointCloud* out) {
  out->points.row(at) = sum.point / sum.weight;
  out->normals.row(at) = sum.normal.normalized();
  if (out->colors.rows())
    out->colors.row(at) =
        (sum.color / sum.weight).array().round().max(0).min(255).cast<std::uint8_t>();
  if (out->confidence.size())
    out->confidence[at] = static_cast<float>(sum.confidence / sum.confidence_weight);
}

}  // namespace

PointCloud MergeWithinCells(const PointCloud& cloud, double cell) {
  const std::vector<KeyedPoint> keyed = SortByFacingCell(cloud, cell);
  std::vector<std::size_t> starts;
  for (std::size_t k = 0; k < keyed.size(); ++k)
    if (k == 0 || keyed[k].key != keyed[k - 1].key) starts.push_back(k);
  const auto count = std::ssize(starts);
  starts.push_back(keyed.size());
  PointCloud out;
  out.points.resize(count, 3);
  out.normals.resize(count, 3);
  out.colors.resize(cloud.colors.rows() ? count : 0, 3);
  out.confidence.resize(cloud.confidence.size() ? count : 0);
  ParallelBlocks(count, kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t g = begin; g < end; ++g) {
      Sum sum;
      for (std::size_t k = starts[g]; k < starts[g + 1]; ++k) AddTo(cloud, keyed[k].point, &sum);
      Store(sum, static_cast<int>(g), &out);
    }
  });
  return out;
}

}  // namespace keypose::reconstruct
