#include "deform/levels/landmark_coordinates.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/values/tuned.h"
#include "deform/levels/geodesics.h"

namespace keypose {

namespace {

// kNear was chosen on tentacle seeds 0 to 9 (docs/results/tentacle.md), kGrowthQuantile on 42
// damaged registration pairs (docs/algorithms/register.md); sensitivity:
// docs/results/sensitivity.md.
struct LandmarkCoordinatesTuning {
  // of the source's diagonal: keeps relative differences finite near a landmark
  KEYPOSE_TUNED(float, kNear, 0.05F);
  // quantile: paths along the inside of a bend get shorter, and hardly any get longer
  KEYPOSE_TUNED(double, kGrowthQuantile, 0.7);
};

constexpr int kBlock = 64;

}  // namespace

LandmarkCoordinates::LandmarkCoordinates(const PointsX3& source, const FacesX3& source_faces,
                                         const std::vector<int>& source_marks,
                                         const PointsX3& target, const FacesX3& target_faces,
                                         const std::vector<int>& target_marks)
    : source_marks_(source_marks), target_marks_(target_marks) {
  const GeodesicGraph from(source, source_faces), to(target, target_faces);
  const double unit = 1 / BoundingDiagonal(source);
  source_ = (unit * from.Rows(source_marks)).cast<float>();
  target_ = (unit * to.Rows(target_marks)).cast<float>();
}

std::vector<LandmarkCoordinates::Match> LandmarkCoordinates::MatchVertices(
    const std::vector<int>& vertices) const {
  const Eigen::Index marks = source_.rows();
  // sum_l w_l (s_l - t_l)^2 with w = 1 / (s^2 + near^2) is linear in (t, t^2): one matrix product
  // for a block of vertices.
  Eigen::MatrixXf features(2 * marks, target_.cols());
  features << target_, target_.cwiseAbs2();
  std::vector<Match> matches(vertices.size());
  ParallelBlocks(std::ssize(vertices), kBlock, [&](std::int64_t begin, std::int64_t end) {
    Eigen::MatrixXf queries(end - begin, 2 * marks);
    Eigen::VectorXf constants(end - begin);
    for (std::int64_t k = begin; k < end; ++k) {
      const Eigen::ArrayXf s = source_.col(vertices[k]).array(),
                           w = 1 / (s.square() + LandmarkCoordinatesTuning::kNear *
                                                     LandmarkCoordinatesTuning::kNear);
      queries.row(k - begin).head(marks) = (-2 * w * s).matrix();
      queries.row(k - begin).tail(marks) = w.matrix();
      constants[k - begin] = (w * s.square()).sum();
    }
    const Eigen::MatrixXf cost = queries * features;
    for (std::int64_t k = begin; k < end; ++k) {
      Eigen::Index best = 0;
      const float least = cost.row(k - begin).minCoeff(&best) + constants[k - begin];
      matches[k] = {static_cast<int>(best),
                    std::sqrt(std::max(0.0F, least) / static_cast<float>(marks))};
    }
  });
  return matches;
}

double LandmarkCoordinates::Growth() const {
  std::vector<float> ratios;
  for (std::size_t a = 0; a < source_marks_.size(); ++a)
    for (std::size_t b = a + 1; b < source_marks_.size(); ++b) {
      const float ours = source_(static_cast<Eigen::Index>(a), source_marks_[b]),
                  theirs = target_(static_cast<Eigen::Index>(a), target_marks_[b]);
      if (ours > 0 && theirs > 0) ratios.push_back(theirs / ours);
    }
  if (ratios.empty()) return 1;
  return QuantileAbove(std::move(ratios), LandmarkCoordinatesTuning::kGrowthQuantile);
}

}  // namespace keypose
