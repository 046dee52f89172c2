#include "motion/reconstruct/kept_volume.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "deform/solvers/lanes.h"
#include "deform/volume/volume_correction.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::motion {

namespace {

constexpr double kMostReach = 0.25;  // of the diagonal
constexpr double kProbe = 1e-3;      // of the diagonal: a step that tells the curvature at rest

constexpr int kFansTogether = 2048;

/// Some fans of a pose.
struct FanJob {
  const double* points;
  int last;  // vertex
  const int *centre, *begin, *chain;
  int first, last_fan;
};

FanJob JobOf(const PointsX3& pose, const FaceFans& fans, int begin, int end) {
  return {pose.data(),
          static_cast<int>(pose.rows()) - 1,
          fans.centre.data(),
          fans.begin.data(),
          fans.chain.data(),
          begin,
          end};
}

/// What is made at the centres of fans.
struct FieldJob {
  const double* amount;
  const double* columns;  // of pulls
  int pulls;
  std::ptrdiff_t rows;
  double* out;
};

/// Those of closed parts, part by part.
std::vector<int> VerticesOf(const std::vector<int>& parts, const std::vector<char>& closed) {
  std::vector<int> vertices;
  for (int i = 0; i < SizeOf(parts); ++i)
    if (closed[parts[i]]) vertices.push_back(i);
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](int a, int b) { return parts[a] < parts[b]; });
  return vertices;
}

}  // namespace

namespace plain {
using namespace keypose::plain;
#include "motion/reconstruct/inverse_root.inc"
#include "motion/reconstruct/volume_sums.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;
#include "motion/reconstruct/inverse_root.inc"
#include "motion/reconstruct/volume_sums.inc"
}  // namespace fused
KEYPOSE_FUSED_END

KeptVolume::KeptVolume(const PoissonSystem& system, const PointsX3& rest)
    : system_(&system), diagonal_(BoundingDiagonal(rest)) {
  const VolumeCorrection correction(system);
  closed_ = correction.closed_parts();
  any_closed_ = std::any_of(closed_.begin(), closed_.end(), [](char c) { return c != 0; });
  if (!any_closed_) return;
  amount_ = correction.Direction(rest)
                .cwiseProduct(VertexNormals(rest, system.faces()))
                .rowwise()
                .sum()
                .cwiseMax(0.0);
  const std::vector<int> vertices = VerticesOf(system.parts(), closed_);
  around_ = FansOfVertices(system.faces(), system.vertex_count(), vertices);
  once_ = FansOfFaces(system.faces(), system.vertex_count(), vertices);
  around_blocks_ = BlocksOf(around_);
  once_blocks_ = BlocksOf(once_);
  State state;
  Measure(rest, Eigen::MatrixXd(rest.rows(), 0), state);
  volume_ = state.volume;
  // The volume is a cubic of the step, of which a symmetric difference gives the square term.
  const double step = kProbe * diagonal_;
  const std::vector<double> outer = Volumes(rest + step * state.field),
                            inner = Volumes(rest - step * state.field);
  for (int p = 0; p < SizeOf(volume_); ++p)
    curvature_.push_back((outer[p] + inner[p] - 2 * volume_[p]) / (2 * step * step));
}

std::vector<KeptVolume::Block> KeptVolume::BlocksOf(const FaceFans& fans) const {
  std::vector<Block> blocks;
  for (int f = 0; f < fans.count(); ++f) {
    const int part = parts()[fans.centre[f]];
    if (blocks.empty() || blocks.back().part != part || f - blocks.back().begin == kFansTogether)
      blocks.push_back({part, f, f});
    blocks.back().end = f + 1;
  }
  return blocks;
}

void KeptVolume::Measure(const PointsX3& pose, const Eigen::MatrixXd& pulls, State& state) const {
  const int count = static_cast<int>(pulls.cols()), numbers = 2 + 12 * count;
  if (state.field.rows() != pose.rows()) state.field.setZero(pose.rows(), 3);
  state.sums.assign(around_blocks_.size() * numbers, 0);
  const FieldJob field{amount_.data(), pulls.data(), count, pose.rows(), state.field.data()};
  ParallelFor(std::ssize(around_blocks_), [&](std::int64_t k) {
    const Block& block = around_blocks_[k];
    const auto measure = HasFused() ? fused::MeasureFans : plain::MeasureFans;
    measure(JobOf(pose, around_, block.begin, block.end), field, &state.sums[k * numbers]);
  });
  state.volume.assign(closed_.size(), 0);
  state.slope.assign(closed_.size(), 0);
  state.gains.setZero(part_count(), 3 * count);
  for (int k = 0; k < SizeOf(around_blocks_); ++k) {
    const int part = around_blocks_[k].part;
    const double* sums = &state.sums[static_cast<std::size_t>(k) * numbers];
    state.volume[part] += sums[0] / 18;
    state.slope[part] += sums[1] / 6;
    for (int p = 0; p < count; ++p)
      for (int c = 0; c < 3; ++c)
        state.gains(part, 3 * p + c) +=
            Eigen::Map<const Eigen::Vector4d>(sums + 2 + 12 * p + 4 * c).sum() / 6;
  }
}

std::vector<double> KeptVolume::Volumes(const PointsX3& pose) const {
  std::vector<double> sums(once_blocks_.size()), volume(closed_.size(), 0);
  ParallelFor(std::ssize(once_blocks_), [&](std::int64_t k) {
    const FanJob job = JobOf(pose, once_, once_blocks_[k].begin, once_blocks_[k].end);
    sums[k] = HasFused() ? fused::SumVolumes(job) : plain::SumVolumes(job);
  });
  for (int k = 0; k < SizeOf(sums); ++k) volume[once_blocks_[k].part] += sums[k] / 6;
  return volume;
}

double KeptVolume::StepFor(int part, double missing, double slope, double before) const {
  const double here = slope + 2 * curvature_[part] * before, first = missing / here;
  const double second = missing / (here + curvature_[part] * first);
  return std::abs(before + second) < kMostReach * diagonal_ ? second : 0.0;
}

}  // namespace keypose::motion
