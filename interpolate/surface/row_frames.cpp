#include "interpolate/surface/row_frames.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation {

namespace {

constexpr int kPatchRows = 512, kWritten = 1024;
// vectors per patch: four of volume, three of points, three of the field, one for its longest
// vector
constexpr int kSums = 11;

/// Numbers per place of a patch: positions at four frames, then the field's vectors.
constexpr int kPlace = 24;

struct SumJob {
  const double* rows;  // of the first of four frames
  int stride;
  const int *row, *vertex;
  int own, all;  // number of places: of the patch's rows, and including the faces' others
  const TurningField::Vertex* field;  // or null
  const std::array<int, 3>*face, *last_face;
  const double* times;
  double* places;  // kPlace each
  double* sums;    // kSums x 4
};

struct WriteJob {
  const double* rows;
  int stride, first, last;  // vertices
  const int *row_of, *part;
  const TurningField::Vertex* field;
  const double* times;
  const double* body;   // 9 x 4
  const double* moves;  // parts x 4 x 4: step, shift
  double* out[4];
};

}  // namespace

namespace plain {
using namespace keypose::plain;  // the lanes
#include "interpolate/surface/row_frames.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;  // the lanes
#include "interpolate/surface/row_frames.inc"
}  // namespace fused
KEYPOSE_FUSED_END

namespace {

std::vector<double> PaddedTimes(const FrameRows& rows, const std::vector<double>& times) {
  std::vector<double> padded(rows.stride, 0.0);
  std::copy(times.begin(), times.end(), padded.begin());
  return padded;
}

}  // namespace

RowFrames::RowFrames(const PoissonSystem& system, const TurningField* field)
    : system_(&system), field_(field) {
  const std::vector<int>&row_of = system.row_of(), &parts = system.parts();
  const FacesX3& faces = system.faces();
  const int n = system.vertex_count();
  std::vector<int> vertex_of(n), first(n + 1, 0), by_row(faces.rows());
  for (int i = 0; i < n; ++i) vertex_of[row_of[i]] = i;
  const auto lowest = [&](Eigen::Index f) {
    return std::min({row_of[faces(f, 0)], row_of[faces(f, 1)], row_of[faces(f, 2)]});
  };
  for (Eigen::Index f = 0; f < faces.rows(); ++f) ++first[lowest(f) + 1];
  for (int i = 0; i < n; ++i) first[i + 1] += first[i];
  std::vector<int> at(first.begin(), first.end() - 1);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) by_row[at[lowest(f)]++] = static_cast<int>(f);
  std::vector<int> place(n, -1);
  faces_.reserve(by_row.size());
  for (int begin = 0; begin < n;) {
    Patch patch{parts[vertex_of[begin]], begin, begin, SizeOf(rows_), 0, SizeOf(faces_), 0};
    while (patch.end < n && patch.end < begin + kPatchRows &&
           parts[vertex_of[patch.end]] == patch.part)
      ++patch.end;
    const auto add = [&](int row) {
      place[row] = SizeOf(rows_);
      rows_.push_back(row);
      vertices_.push_back(vertex_of[row]);
    };
    for (int row = begin; row < patch.end; ++row) add(row);
    for (int k = first[begin]; k < first[patch.end]; ++k) {
      std::array<int, 3> face;
      for (int c = 0; c < 3; ++c) {
        const int row = row_of[faces(by_row[k], c)];
        if (place[row] < patch.first_vertex) add(row);
        face[c] = place[row] - patch.first_vertex;
      }
      faces_.push_back(face);
    }
    patch.last_vertex = SizeOf(rows_);
    patch.last_face = SizeOf(faces_);
    patches_.push_back(patch);
    begin = patch.end;
  }
}

std::vector<std::vector<RowFrames::PartSums>> RowFrames::Sums(
    const FrameRows& rows, const std::vector<double>& given) const {
  const std::vector<double> times = PaddedTimes(rows, given);
  const std::size_t groups = rows.stride / 4;
  std::vector<double> by_patch(patches_.size() * groups * kSums * 4);
  ParallelBlocks(std::ssize(patches_), 4, [&](std::int64_t from, std::int64_t to) {
    std::vector<double> places;
    for (std::int64_t k = from; k < to; ++k) {
      const Patch& patch = patches_[k];
      places.resize(
          std::max<std::size_t>(places.size(), kPlace * (patch.last_vertex - patch.first_vertex)));
      for (std::size_t g = 0; g < groups; ++g) {
        const SumJob job{rows.Row(0) + 4 * g,
                         rows.stride,
                         rows_.data() + patch.first_vertex,
                         vertices_.data() + patch.first_vertex,
                         patch.end - patch.begin,
                         patch.last_vertex - patch.first_vertex,
                         field_ ? field_->vertices().data() : nullptr,
                         faces_.data() + patch.first_face,
                         faces_.data() + patch.last_face,
                         times.data() + 4 * g,
                         places.data(),
                         by_patch.data() + (k * groups + g) * kSums * 4};
        HasFused() ? fused::SumPatch(job) : plain::SumPatch(job);
      }
    }
  });
  std::vector<std::vector<PartSums>> sums(rows.frames,
                                          std::vector<PartSums>(system_->part_count()));
  std::vector<int> count(system_->part_count(), 0);
  for (const Patch& patch : patches_) count[patch.part] += patch.end - patch.begin;
  for (int t = 0; t < rows.frames; ++t) {
    for (std::size_t k = 0; k < patches_.size(); ++k) {
      const double* s = by_patch.data() + (k * groups + t / 4) * kSums * 4 + t % 4;
      PartSums& sum = sums[t][patches_[k].part];
      for (int c = 0; c < 4; ++c) sum.volume[c] += s[4 * c] / 6;
      for (int c = 0; c < 3; ++c) {
        sum.point[c] += s[4 * (4 + c)];
        sum.field[c] += s[4 * (7 + c)];
      }
      sum.longest = std::max(sum.longest, std::sqrt(s[40]));
    }
    for (std::size_t p = 0; p < count.size(); ++p) {
      sums[t][p].point /= count[p];
      sums[t][p].field /= count[p];
    }
  }
  return sums;
}

std::vector<PointsX3> RowFrames::Frames(const FrameRows& rows, const std::vector<double>& given,
                                        const std::vector<Eigen::Matrix3d>& bodies,
                                        const std::vector<std::vector<Move>>& moves) const {
  const std::vector<double> times = PaddedTimes(rows, given);
  const int n = system_->vertex_count(), groups = rows.stride / 4, parts = system_->part_count();
  std::vector<PointsX3> frames(rows.frames);
  for (PointsX3& frame : frames) frame.resize(n, 3);
  std::vector<double> lane_bodies(groups * 36, 0.0),
      lane_moves(static_cast<std::size_t>(groups) * parts * 16, 0.0);
  for (int t = 0; t < rows.frames; ++t) {
    for (int k = 0; k < 9; ++k) lane_bodies[t / 4 * 36 + 4 * k + t % 4] = bodies[t](k / 3, k % 3);
    for (int p = 0; p < parts; ++p) {
      double* to = lane_moves.data() + (static_cast<std::size_t>(t / 4) * parts + p) * 16 + t % 4;
      to[0] = moves[t][p].step;
      for (int c = 0; c < 3; ++c) to[4 + 4 * c] = moves[t][p].shift[c];
    }
  }
  ParallelBlocks(n, kWritten, [&](std::int64_t begin, std::int64_t end) {
    for (int g = 0; g < groups; ++g) {
      WriteJob job{rows.Row(0) + 4 * g,
                   rows.stride,
                   static_cast<int>(begin),
                   static_cast<int>(end),
                   system_->row_of().data(),
                   system_->parts().data(),
                   field_ ? field_->vertices().data() : nullptr,
                   times.data() + 4 * g,
                   lane_bodies.data() + g * 36,
                   lane_moves.data() + static_cast<std::size_t>(g) * parts * 16,
                   {}};
      for (int k = 0; k < 4; ++k)
        job.out[k] = 4 * g + k < rows.frames ? frames[4 * g + k].data() : nullptr;
      HasFused() ? fused::WriteFrames(job) : plain::WriteFrames(job);
    }
  });
  return frames;
}

}  // namespace keypose::interpolation
