#include "reconstruct/guided_matching.h"

#include <Eigen/LU>

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 128;

int Dot(const std::int16_t* a, const std::int16_t* b) {
  int sum = 0;
  for (int k = 0; k < kSize; ++k) sum += static_cast<int>(a[k]) * static_cast<int>(b[k]);
  return sum;
}

/// Features of b that the geometry allows for one point of a.
class Gate {
 public:
  Gate(const PairGeometry& geometry, double max_error_px)
      : matrix_(geometry.matrix), homography_(geometry.kind == PairGeometry::kHomography), limit_(max_error_px * max_error_px) {}

  void Aim(const Eigen::Vector2f& point) {
    const Eigen::Vector3d x = point.cast<double>().homogeneous();
    if (homography_) {
      target_ = (matrix_ * x).hnormalized();
      return;
    }
    line_ = matrix_ * x;
    line_norm2_ = line_.head<2>().squaredNorm();
  }

  bool Allows(float u, float v) const {
    if (homography_) return (Eigen::Vector2d(u, v) - target_).squaredNorm() <= limit_;
    const double distance = line_(0) * u + line_(1) * v + line_(2);
    return distance * distance <= limit_ * (line_norm2_ + BackNorm2(u, v));
  }

 private:
  double BackNorm2(float u, float v) const {
    const double p = matrix_(0, 0) * u + matrix_(1, 0) * v + matrix_(2, 0), q = matrix_(0, 1) * u + matrix_(1, 1) * v + matrix_(2, 1);
    return p * p + q * q;
  }
  Eigen::Matrix3d matrix_;
  bool homography_;
  double limit_;
  Eigen::Vector3d line_;
  double line_norm2_ = 0;
  Eigen::Vector2d target_;
};

}  // namespace

std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchGuided(const Features& a, const Features& b, const PairGeometry& geometry,
                                                                 const MatchOptions& options, double max_error_px) {
  std::vector<NearestTwo> of_a(static_cast<std::size_t>(a.count())), of_b(static_cast<std::size_t>(b.count()));
  Gate gate(geometry, max_error_px);
  for (int i = 0; i < a.count(); ++i) {
    gate.Aim(a.positions.row(i).transpose());
    for (int j = 0; j < b.count(); ++j) {
      if (!gate.Allows(b.positions(j, 0), b.positions(j, 1))) continue;
      const int dot =
          Dot(a.descriptors.data() + static_cast<std::ptrdiff_t>(i) * kSize, b.descriptors.data() + static_cast<std::ptrdiff_t>(j) * kSize);
      of_a[static_cast<std::size_t>(i)].Offer(dot, j);
      of_b[static_cast<std::size_t>(j)].Offer(dot, i);
    }
  }
  return MutualMatches(of_a, of_b, options);
}

}  // namespace keypose::reconstruct
