#include "motion/reconstruct/point_moves.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::motion {

namespace {

constexpr int kPointsTogether = 4096;  // a multiple of four

struct MoveJob {
  std::ptrdiff_t rows;
  const double* field;  // or null
  const int* parts;
  const double *along, *columns;
  const int* pulled;
  int pulls;
  const double* pull;  // column by column
  double* points;
};

}  // namespace

namespace plain {
using namespace keypose::plain;
#include "motion/reconstruct/point_moves.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;
#include "motion/reconstruct/point_moves.inc"
}  // namespace fused
KEYPOSE_FUSED_END

double MovePoints(const PointMoves& moves, PointsX3& points) {
  const int pulls = SizeOf(moves.pulled);
  const MoveJob job{points.rows(),
                    moves.field ? moves.field->data() : nullptr,
                    moves.field ? moves.parts->data() : nullptr,
                    moves.field ? moves.along->data() : nullptr,
                    pulls > 0 ? moves.columns->data() : nullptr,
                    moves.pulled.data(),
                    pulls,
                    moves.pulls.data(),
                    points.data()};
  std::vector<double> largest(points.rows() / kPointsTogether + 1, 0.0);
  ParallelBlocks(points.rows(), kPointsTogether, [&](std::int64_t begin, std::int64_t end) {
    const auto move = HasFused() ? fused::MoveRows : plain::MoveRows;
    largest[begin / kPointsTogether] = move(job, begin, end);
  });
  return std::sqrt(*std::max_element(largest.begin(), largest.end()));
}

}  // namespace keypose::motion
