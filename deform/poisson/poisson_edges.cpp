// Right-hand sides of PoissonSystem: wanted edges, computed and summed patch by patch.
#include <algorithm>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "deform/poisson/poisson_impl.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose {

namespace {

/// A rotation for each of four frames.
struct LaneTurns {
  double m[3][3][kVectorWidth];
};

struct GatherJob {
  const int* row_begin;
  const RowCorner* corners;
  const int* faces;  // null: edges are in the order of the patch
  const double* edges;
  int stride;
  const LaneTurns* turns;
  double* out;
  int out_stride, rows;
};

/// One frame: edges of eight numbers a face, rows of four numbers.
struct OneGatherJob {
  const int* row_begin;
  const RowCorner* corners;
  const double* edges;
  const double* turn;  // 3 x 3, column by column
  double* out;
  int rows;
};

}  // namespace

namespace plain {
#include "deform/poisson/poisson_edges.inc"
}
KEYPOSE_FUSED_BEGIN
namespace fused {
#include "deform/poisson/poisson_edges.inc"
}
KEYPOSE_FUSED_END

void PoissonSystem::Impl::CutPatches() {
  const int count = static_cast<int>((n + kPatchRows - 1) / kPatchRows);
  patch_begin.assign(1, 0);
  row_begin.assign(1, 0);
  row_begin.reserve(n + 1);
  row_corners.reserve(corners.size());
  std::vector<int> place(faces.rows(), -1);
  for (int patch = 0; patch < count; ++patch) {
    const int begin = patch * kPatchRows,
              end = std::min<int>(begin + kPatchRows, static_cast<int>(n));
    for (int row = begin; row < end; ++row) {
      const int i = solver.unknowns()[row];
      for (int at = first_corner[i]; at < first_corner[i + 1]; ++at) {
        const int f = corners[at] / 3, k = corners[at] % 3;
        if (place[f] < patch_begin[patch]) {
          place[f] = SizeOf(patch_faces);
          patch_faces.push_back(f);
        }
        // Corner k is the end of the edge opposite k+1 and the start of the edge opposite k+2. Both
        // are expressed by the edges from corner 0.
        const EdgeWeights& w = weights[f];
        const int patch_face = place[f] - patch_begin[patch];
        if (k == 0)
          row_corners.push_back({patch_face, -w[2], -w[1]});
        else if (k == 1)
          row_corners.push_back({patch_face, w[2] + w[0], -w[0]});
        else
          row_corners.push_back({patch_face, -w[0], w[0] + w[1]});
      }
      row_begin.push_back(SizeOf(row_corners));
    }
    patch_begin.push_back(SizeOf(patch_faces));
  }
}

void PoissonSystem::Impl::Gather(int patch, const EdgeBatch& edges, const Eigen::Matrix3d* turns,
                                 int first, FrameRows& sums) const {
  const int begin = patch * kPatchRows,
            end = std::min<int>(begin + kPatchRows, static_cast<int>(n));
  LaneTurns lanes;
  const bool all = edges.listed.empty();
  for (int i = 0; turns && i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < kVectorWidth; ++k)
        lanes.m[i][j][k] = turns[std::min(first + k, sums.frames - 1)](i, j);
  const GatherJob job{row_begin.data() + begin,
                      row_corners.data(),
                      all ? patch_faces.data() + patch_begin[patch] : nullptr,
                      edges.Face(0) + (all ? first : 0),
                      edges.stride,
                      turns ? &lanes : nullptr,
                      sums.Row(begin) + first,
                      sums.stride,
                      end - begin};
  HasFused() ? fused::GatherRows(job) : plain::GatherRows(job);
}

void PoissonSystem::Impl::RightHandSide(const FillEdges& fill,
                                        const std::vector<Eigen::Matrix3d>& turns,
                                        FrameRows& sums) const {
  constexpr int kPatchesTogether = 4;
  ParallelBlocks(std::ssize(patch_begin) - 1, kPatchesTogether,
                 [&](std::int64_t from, std::int64_t to) {
                   for (int patch = static_cast<int>(from); patch < to; ++patch) {
                     EdgeBatch edges(FacesOfPatch(patch), kVectorWidth);
                     edges.patch = patch;
                     for (int first = 0; first < sums.frames; first += kVectorWidth) {
                       edges.frames = std::min(kVectorWidth, sums.frames - first);
                       fill(first, edges);
                       Gather(patch, edges, turns.empty() ? nullptr : turns.data(), first, sums);
                     }
                   }
                 });
}

std::vector<double> PoissonSystem::Impl::OneRightHandSide(const FillOneFrame& fill,
                                                          const Eigen::Matrix3d& turn) const {
  std::vector<double> sums(4 * n);
  constexpr int kPatchesTogether = 4;
  ParallelBlocks(std::ssize(patch_begin) - 1, kPatchesTogether,
                 [&](std::int64_t from, std::int64_t to) {
                   std::vector<double> edges;
                   for (int patch = static_cast<int>(from); patch < to; ++patch) {
                     edges.resize(8 * FacesOfPatch(patch).size());
                     fill(patch, edges.data());
                     const int begin = patch * kPatchRows,
                               end = std::min<int>(begin + kPatchRows, static_cast<int>(n));
                     const OneGatherJob job{
                         row_begin.data() + begin, row_corners.data(), edges.data(), turn.data(),
                         sums.data() + 4 * begin,  end - begin};
                     HasFused() ? fused::GatherOneFrame(job) : plain::GatherOneFrame(job);
                   }
                 });
  return sums;
}

}  // namespace keypose
