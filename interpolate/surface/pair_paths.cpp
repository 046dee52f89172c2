#include "interpolate/surface/pair_paths.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "deform/solvers/lanes.h"

#pragma GCC diagnostic ignored "-Wpsabi"

namespace keypose::interpolation {

namespace {

using Record = PairPaths::Record;

using Edges = Eigen::Matrix<double, 3, 2>;

/// log(m) = (log_det / 2) I + n, n^2 = discriminant I; false where the logarithm is not real or
/// nearly so.
bool LogOf2(const Eigen::Matrix2d& m, double& log_det, Eigen::Matrix2d& n, double& discriminant) {
  const double root = std::sqrt(m.determinant());
  log_det = 2 * std::log(root);
  const double mean = 0.5 * m.trace() / root, half = 0.5 * (m(0, 0) - m(1, 1)) / root;
  n << half, m(0, 1) / root, m(1, 0) / root, -half;
  // exp(n s) = cosh(s) I + sinh(s) n for the unit n. So the traceless part has the sinh, or the
  // sine, of the sought length.
  const double q = half * half + n(0, 1) * n(1, 0);
  if (!(mean > -0.9) || (mean <= 0 && q >= 0)) return false;
  double factor = 1 - q / 6;
  if (std::abs(q) > 1e-6)
    factor = q > 0 ? std::asinh(std::sqrt(q)) / std::sqrt(q)
                   : std::atan2(std::sqrt(-q), mean) / std::sqrt(-q);
  if (mean < 0 && std::abs(q) <= 1e-6) return false;
  n *= factor;
  discriminant = q * factor * factor;
  return true;
}

/// The rotation of the face's plane within itself, times its stretch; `tilt` is the rest of the
/// remainder.
Eigen::Matrix2d ShearOf(const FaceMap& map, Eigen::Vector3d& tilt) {
  const Eigen::Vector3d normal = map.frame.col(0).cross(map.frame.col(1));
  const Eigen::Quaterniond q = QuaternionOf(map.remainder);
  double w = q.w(), along = q.vec().dot(normal);
  const double length = std::hypot(w, along);
  if (length < 1e-12) {  // a tilt by half a turn: the split is not unique
    tilt = map.remainder;
    return map.stretch;
  }
  w /= length;
  along /= length;
  const Eigen::Vector3d within = along * normal;
  tilt = LogOf(q * Eigen::Quaterniond(w, -within[0], -within[1], -within[2]));
  const double cosine = w * w - along * along, sine = 2 * w * along;
  return (Eigen::Matrix2d() << cosine, -sine, sine, cosine).finished() * map.stretch;
}

/// The part of v that a turn about `turn` keeps, and the parts for the cosine and the sine of its
/// angle.
std::array<double, 9> SplitBy(const Eigen::Vector3d& turn, double angle, const Eigen::Vector3d& v) {
  std::array<double, 9> parts{};
  const Eigen::Vector3d axis = angle > 0 ? (turn / angle).eval() : Eigen::Vector3d::Zero();
  const Eigen::Vector3d kept = axis.dot(v) * axis;
  Eigen::Vector3d::Map(&parts[0]) = kept;
  Eigen::Vector3d::Map(&parts[3]) = v - kept;
  Eigen::Vector3d::Map(&parts[6]) = axis.cross(v);
  return parts;
}

/// Axes along and across the tilt; the second lies in the plane of the face where the first does.
Eigen::Matrix3d TiltAxes(const FaceMap& map, const Eigen::Vector3d& tilt, bool& flat) {
  Eigen::Matrix3d axes;
  const Eigen::Vector3d normal = map.frame.col(0).cross(map.frame.col(1));
  const double angle = tilt.norm();
  axes.col(0) = angle > 0 ? (tilt / angle).eval() : Eigen::Vector3d(map.frame.col(0));
  flat = std::abs(axes.col(0).dot(normal)) < 1e-15;
  Eigen::Vector3d across = normal - axes.col(0) * axes.col(0).dot(normal);
  if (across.norm() < 1e-3)
    across = map.frame.col(0) - axes.col(0) * axes.col(0).dot(map.frame.col(0));
  axes.col(2) = across.normalized();
  axes.col(1) = axes.col(2).cross(axes.col(0));
  return axes;
}

Record RecordOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces, Eigen::Index f,
                const SegmentMaps& maps, const Eigen::Matrix3d& body, Stretch stretch) {
  const FaceMap& map = maps.faces[f];
  Record r{};
  Edges plain, generated;
  for (int k = 0; k < 2; ++k) plain.col(k) = v.row(faces(f, k + 1)) - v.row(faces(f, 0));
  const auto applied = [&](const Eigen::Matrix2d& m) {
    return (map.frame * (m * (map.frame.transpose() * plain))).eval();
  };
  Eigen::Vector3d turn = Eigen::Vector3d::Zero(), tilt = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();
  if (map.degenerate) {
    // A straight path from edge to edge, relative to the body.
    for (int k = 0; k < 2; ++k)
      generated.col(k) =
          body.transpose() * (u.row(faces(f, k + 1)) - u.row(faces(f, 0))).transpose();
    generated -= plain;
    r.straight = true;
  } else {
    turn = map.turn;
    tilt = map.remainder;
    Eigen::Matrix2d n;
    const bool in_one = stretch == Stretch::kBalanced && !maps.differential &&
                        LogOf2(ShearOf(map, tilt), r.log_area, n, r.discriminant);
    if (!in_one) {
      tilt = map.remainder;
      LogOf2(map.stretch, r.log_area, n, r.discriminant);  // symmetric and positive: always real
    }
    r.straight = stretch == Stretch::kLinear;
    generated = applied(r.straight ? map.stretch - Eigen::Matrix2d::Identity() : n);
    r.growth = stretch == Stretch::kBalanced ? map.growth : 0.0;
    r.log_area -= 2 * r.growth;
    axes = TiltAxes(map, tilt, r.flat);
  }
  r.turn_angle = turn.norm();
  r.tilt_angle = tilt.norm();
  r.along = SplitBy(turn, r.turn_angle, axes.col(0));
  r.across = SplitBy(turn, r.turn_angle, axes.col(1));
  r.third = SplitBy(turn, r.turn_angle, axes.col(2));
  const Edges plain_in = axes.transpose() * plain, generated_in = axes.transpose() * generated;
  for (int c = 0; c < 3; ++c)
    r.in_axes[c] = {plain_in(c, 0), generated_in(c, 0), plain_in(c, 1), generated_in(c, 1)};
  return r;
}

constexpr int kTerms = 18, kFewTerms = 8, kFewestTerms = 5;
constexpr double kSmallAngle = 0.78;
/// 1 / (2n)! and 1 / (2n+1)!: cosh(x) and sinh(x) / x as series of x^2. Negative x^2 gives the
/// cosine and the sine.
struct EvenSeries {
  constexpr EvenSeries() {
    double factorial = 1;
    for (int n = 0; n < kTerms; ++n) {
      cosh[n] = 1 / factorial;
      factorial *= 2 * n + 1;
      sinh[n] = 1 / factorial;
      factorial *= 2 * n + 2;
    }
  }
  double cosh[kTerms] = {}, sinh[kTerms] = {};
};
constexpr EvenSeries kSeries;

struct EvaluateJob {
  const Record* records;
  const int* listed;  // or null: in order
  std::int64_t count;
  bool balanced;
  const double* times;
  int stride;
  double* edges;
};

}  // namespace

namespace plain {
using namespace keypose::plain;  // the lanes
#include "interpolate/surface/pair_paths.inc"
}  // namespace plain
KEYPOSE_FUSED_BEGIN
namespace fused {
using namespace keypose::fused;  // the lanes
#include "interpolate/surface/pair_paths.inc"
}  // namespace fused
KEYPOSE_FUSED_END

namespace {

void EvaluateBest(const EvaluateJob& job) {
  HasFused() ? fused::EvaluateFaces(job) : plain::EvaluateFaces(job);
}

}  // namespace

PairPaths::PairPaths(const PointsX3& v, const PointsX3& u, const FacesX3& faces,
                     const SegmentMaps& maps, Stretch stretch)
    : records_(maps.faces.size()), balanced_(stretch == Stretch::kBalanced) {
  const Eigen::Matrix3d body = ExpOf(maps.body_turn);
  ParallelFor(
      std::ssize(records_),
      [&](std::int64_t f) { records_[f] = RecordOf(v, u, faces, f, maps, body, stretch); }, 512);
}

void PairPaths::Evaluate(const std::vector<double>& times, EdgeBatch& edges) const {
  std::vector<double> padded(edges.stride, 0.0);
  std::copy(times.begin(), times.end(), padded.begin());
  const auto job = [&](std::int64_t begin, std::int64_t end) {
    const int* listed = edges.listed.empty() ? nullptr : edges.listed.data();
    return EvaluateJob{records_.data() + (listed ? 0 : begin),
                       listed,
                       end - begin,
                       balanced_,
                       padded.data(),
                       edges.stride,
                       edges.Face(begin)};
  };
  if (!edges.listed.empty()) return EvaluateBest(job(0, std::ssize(edges.listed)));
  ParallelBlocks(std::ssize(records_), 256,
                 [&](std::int64_t begin, std::int64_t end) { EvaluateBest(job(begin, end)); });
}

void PairPaths::EvaluateWith(const std::vector<Eigen::Matrix3d>& rotations, double t, int frame,
                             EdgeBatch& edges) const {
  const bool all = edges.listed.empty();
  ParallelFor(
      static_cast<std::int64_t>(all ? records_.size() : edges.listed.size()),
      [&](std::int64_t k) {
        const std::int64_t f = all ? k : edges.listed[k];
        const Record& r = records_[f];
        double plain = 1, generated = t;
        if (!r.straight) {
          const double tau = balanced_ ? BalancedTime(t, r.log_area) : t,
                       root = std::sqrt(std::max(0.0, r.discriminant)), x = tau * root;
          const double scale = std::exp(t * r.growth + tau * 0.5 * r.log_area);
          plain = scale * std::cosh(x);
          generated = scale * (root > 1e-8 ? std::sinh(x) / root : tau);
        }
        // The tilt's axes before the turn: the kept part plus the part of the cosine.
        Edges local = Edges::Zero();
        const std::array<double, 9>* axes[] = {&r.along, &r.across, &r.third};
        for (int c = 0; c < 3; ++c) {
          const Eigen::Vector3d axis =
              Eigen::Vector3d::Map(axes[c]->data()) + Eigen::Vector3d::Map(axes[c]->data() + 3);
          for (int e = 0; e < 2; ++e)
            local.col(e) +=
                (plain * r.in_axes[c][2 * e] + generated * r.in_axes[c][2 * e + 1]) * axis;
        }
        edges.Set(k, frame, rotations[f] * local);
      },
      512);
}

}  // namespace keypose::interpolation
