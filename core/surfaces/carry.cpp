#include "core/surfaces/carry.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"

namespace keypose {

namespace {

// Distances are relative to the diagonal of the new mesh.
constexpr double kFar = 0.03;          // distance from which on a sample has the full cost
constexpr double kAgrees = 0.012;      // samples this near count as on the surface
constexpr double kSameFrame = 0.0015;  // median distance below which no other frame is searched for
constexpr double kSure = 0.006, kNear = 0.02;
constexpr double kFacesAlike = 0.7, kFacesAway = 0.25;  // cosines: 45 and 75 degrees
constexpr double kOtherColor = 35, kWrongColor = 90;    // of 255
constexpr double kScaleSlack =
    0.15;  // of the scale: the spread of the samples gives it to a few percent
constexpr double kTie = 1.25,
                 kTieFloor = 0.004;  // costs this close cannot be distinguished
constexpr double kOtherTurn =
    20 * std::numbers::pi / 180;  // rotations further apart are different results
constexpr int kTurnsUpright = 36, kTurnsAny = 120, kCoarseSamples = 80, kRefined = 8;

double AngleOf(const Eigen::Matrix3d& turn) { return Eigen::AngleAxisd(turn).angle(); }

/// Rotations that cover all rotations evenly: super-Fibonacci spirals (Alexa, CVPR 2022).
Eigen::Matrix3d SpreadTurn(int index, int count) {
  const double phi = std::numbers::sqrt2, psi = 1.533751168755204288118041;
  const double s = index + 0.5, t = s / count, d = 2 * std::numbers::pi * s;
  const double r = std::sqrt(t), q = std::sqrt(1 - t);
  const double alpha = d / phi, beta = d / psi;
  return Eigen::Quaterniond(r * std::sin(alpha), r * std::cos(alpha), q * std::sin(beta),
                            q * std::cos(beta))
      .toRotationMatrix();
}

struct Spread {
  Eigen::Vector3d center;
  double radius;  // root mean square
  explicit Spread(const PointsX3& points) : center(points.colwise().mean()) {
    radius = std::sqrt((points.rowwise() - center.transpose()).rowwise().squaredNorm().mean());
  }
};

}  // namespace

std::string FrameChange::Words() const {
  if (same_frame) return "in the same frame";
  return fmt::format("turned by {:.1f} degrees, {:.3f} times as large",
                     AngleOf(now_from_before.rotation) * 180 / std::numbers::pi,
                     now_from_before.scale);
}

struct Carrier::Impl {
  Impl(const MeshBinding& before_mesh, const Mesh& now_mesh)
      : before(before_mesh),
        now(now_mesh),
        look(now),
        scene(now.points, now.faces),
        diagonal(BoundingDiagonal(now.points)),
        sample_now(BindTo(now)) {
    colored = before.colors.rows() > 0 && sample_now.colors.rows() > 0;
    if (colored) {
      const Eigen::RowVector3d mean_now = sample_now.colors.colwise().mean(),
                               mean_before = before.colors.colwise().mean();
      gain = (mean_now.array().max(1) / mean_before.array().max(1)).matrix().transpose();
    }
    Find();
  }

  struct Foot {
    double distance = 0, facing = 0, color = 0;  // over the diagonal; cosine; 0 to 255
    Eigen::Vector3d moved, point, normal;
  };

  Foot FootOf(const Similarity3& frame, Eigen::Index sample) const {
    Foot foot;
    foot.moved = frame * Eigen::Vector3d(before.points.row(sample));
    const RayScene::Foot hit = scene.ClosestPoint(foot.moved);
    foot.point = hit.point;
    foot.distance = std::sqrt(hit.squared_distance) / diagonal;
    foot.normal.setZero();
    Eigen::Vector3d shade = Eigen::Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      const int v = now.faces(hit.face, k);
      foot.normal += hit.barycentric[k] * look.vertex_normals().row(v).transpose();
      if (colored) shade += hit.barycentric[k] * now.colors.row(v).cast<double>().transpose();
    }
    foot.normal.normalize();
    foot.facing = foot.normal.dot(frame.rotation * before.normals.row(sample).transpose());
    if (colored) foot.color = ColorDifference(before.colors.row(sample), shade);
    return foot;
  }

  double ColorDifference(const Eigen::Vector3d& then, const Eigen::Vector3d& here) const {
    return (gain.cwiseProduct(then) - here).norm() / std::sqrt(3.0);
  }

  /// Mean cost of the samples: distance (at most 1), normal and colour (at most 0.5 each).
  double Cost(const Similarity3& frame, Eigen::Index stride) const {
    double cost = 0;
    int count = 0;
    for (Eigen::Index i = 0; i < before.points.rows(); i += stride, ++count) {
      const Foot foot = FootOf(frame, i);
      const double far = std::min(1.0, foot.distance / kFar);
      cost += far * far + 0.5 * (1 - std::max(0.0, foot.facing)) +
              (colored ? 0.5 * std::min(1.0, foot.color / kWrongColor) : 0);
    }
    return cost / std::max(1, count);
  }

  /// One Gauss-Newton step: a small similarity about the centre of the moved samples. Geman-McClure
  /// weights of width `reach`.
  Similarity3 Step(const Similarity3& frame, Eigen::Index stride, double reach) const {
    using Vector7 = Eigen::Matrix<double, 7, 1>;
    const Eigen::Vector3d center = frame * Eigen::Vector3d(before.points.colwise().mean());
    Eigen::Matrix<double, 7, 7> normal_matrix = Eigen::Matrix<double, 7, 7>::Zero();
    Vector7 right = Vector7::Zero();
    const auto add = [&](const Eigen::Vector3d& arm, const Eigen::Vector3d& along, double residual,
                         double weight) {
      Vector7 row;
      row << arm.cross(along), along * diagonal, arm.dot(along);
      normal_matrix += weight * row * row.transpose();
      right -= weight * residual * row;
    };
    for (Eigen::Index i = 0; i < before.points.rows(); i += stride) {
      const Foot foot = FootOf(frame, i);
      if (foot.facing < 0.3) continue;
      const double ratio = foot.distance / reach,
                   weight = 1 / ((1 + ratio * ratio) * (1 + ratio * ratio));
      const Eigen::Vector3d arm = foot.moved - center, gap = foot.moved - foot.point;
      add(arm, foot.normal, gap.dot(foot.normal), weight);
      for (int k = 0; k < 3; ++k) add(arm, Eigen::Vector3d::Unit(k), gap[k], 0.02 * weight);
    }
    normal_matrix.diagonal().array() += 1e-9 * diagonal * diagonal;
    const Vector7 move = normal_matrix.ldlt().solve(right);
    if (!move.allFinite()) return frame;
    const double angle = move.head<3>().norm();
    Similarity3 next = frame;
    const Eigen::Matrix3d turn =
        angle > 1e-15 ? Eigen::AngleAxisd(angle, move.head<3>() / angle).toRotationMatrix()
                      : Eigen::Matrix3d::Identity();
    const double grow = std::clamp(1 + move[6], 0.9, 1.1);
    next.scale = frame.scale * grow;
    next.rotation = turn * frame.rotation;
    next.translation =
        center + diagonal * move.segment<3>(3) + grow * (turn * (frame.translation - center));
    return next;
  }

  Similarity3 Refined(Similarity3 frame, Eigen::Index stride, int rounds, double reach_first,
                      double reach_last) const {
    for (int i = 0; i < rounds; ++i) {
      const double share = rounds > 1 ? static_cast<double>(i) / (rounds - 1) : 1;
      frame = Step(frame, stride, reach_first * std::pow(reach_last / reach_first, share));
    }
    return frame;
  }

  struct Candidate {
    Similarity3 frame;
    double cost = 0;
  };

  void Find() {
    const Similarity3 as_is;
    Measure(as_is);
    if (change.misfit < kSameFrame && change.agreeing > 0.95 && ColorsFit(as_is)) {
      change.same_frame = true;
      return;
    }
    const std::vector<Candidate> found = Search();
    const Candidate& best = found.front();
    Measure(best.frame);
    // Among results of about the same cost, the one nearest to the old frame is the most likely.
    const Candidate* nearest = &best;
    bool tied = false;
    for (const Candidate& other : found) {
      if (other.cost > kTie * best.cost + kTieFloor) continue;
      tied = tied || AngleOf(other.frame.rotation * best.frame.rotation.transpose()) > kOtherTurn;
      if (AngleOf(other.frame.rotation) < AngleOf(nearest->frame.rotation)) nearest = &other;
    }
    if (!tied) return;
    if (AngleOf(nearest->frame.rotation) < 0.5 * kOtherTurn &&
        std::abs(std::log(nearest->frame.scale)) < 0.05)
      Measure(nearest->frame);
    else
      change.ambiguous = true;
  }

  std::vector<Candidate> Search() const {
    const Spread from(before.points), to(sample_now.points);
    std::vector<Candidate> candidates(1 + kTurnsUpright + kTurnsAny);
    const double scale = to.radius / std::max(1e-300, from.radius);
    for (std::size_t i = 1; i < candidates.size(); ++i) {
      const int turn = static_cast<int>(i) - 1;
      Similarity3& frame = candidates[i].frame;
      frame.scale = scale;
      frame.rotation = turn < kTurnsUpright
                           ? Eigen::AngleAxisd(2 * std::numbers::pi * turn / kTurnsUpright,
                                               Eigen::Vector3d::UnitZ())
                                 .toRotationMatrix()
                           : SpreadTurn(turn - kTurnsUpright, kTurnsAny);
      frame.translation = to.center - scale * (frame.rotation * from.center);
    }
    const Eigen::Index stride = std::max<Eigen::Index>(1, before.points.rows() / kCoarseSamples);
    ParallelFor(std::ssize(candidates), [&](std::int64_t i) {
      Candidate& candidate = candidates[i];
      candidate.frame = Refined(candidate.frame, stride, 8, 0.1, 0.02);
      candidate.cost = PlausibleCost(candidate.frame, stride, scale);
    });
    const auto cheaper = [](const Candidate& a, const Candidate& b) { return a.cost < b.cost; };
    std::stable_sort(candidates.begin(), candidates.end(), cheaper);
    std::vector<Candidate> finalists;
    for (const Candidate& candidate : candidates) {
      const bool is_new =
          std::none_of(finalists.begin(), finalists.end(), [&](const Candidate& other) {
            return AngleOf(other.frame.rotation * candidate.frame.rotation.transpose()) <
                   0.5 * kOtherTurn;
          });
      if (is_new && finalists.size() < kRefined) finalists.push_back(candidate);
    }
    ParallelFor(std::ssize(finalists), [&](std::int64_t i) {
      Candidate& candidate = finalists[i];
      candidate.frame = Refined(candidate.frame, 1, 24, 0.02, 0.004);
      candidate.cost = PlausibleCost(candidate.frame, 1, scale);
    });
    std::stable_sort(finalists.begin(), finalists.end(), cheaper);
    return finalists;
  }

  /// The cost, and a penalty for implausible scales: samples that have shrunk to a small spot also
  /// lie on the surface.
  double PlausibleCost(const Similarity3& frame, Eigen::Index stride, double scale) const {
    return Cost(frame, stride) + (std::abs(std::log(frame.scale / scale)) > kScaleSlack ? 10 : 0);
  }

  bool ColorsFit(const Similarity3& frame) const {
    if (!colored) return true;
    std::vector<double> differences;
    for (Eigen::Index i = 0; i < before.points.rows(); ++i)
      differences.push_back(FootOf(frame, i).color);
    return UpperMedian(differences) < 0.5 * kOtherColor;
  }

  void Measure(const Similarity3& frame) {
    change.now_from_before = frame;
    std::vector<double> distances;
    int agree = 0, covered = 0;
    for (Eigen::Index i = 0; i < before.points.rows(); ++i) {
      const Foot foot = FootOf(frame, i);
      distances.push_back(foot.distance);
      agree += foot.distance < kAgrees && foot.facing > 0.5;
    }
    // The samples are sparse: a point of the mesh counts as covered when a sample near it faces the
    // same way.
    const KdTree tree(Transformed(frame, before.points));
    const double sparse = 2.5 * std::sqrt(SurfaceArea(now.points, now.faces) /
                                          static_cast<double>(before.points.rows()));
    for (Eigen::Index i = 0; i < sample_now.points.rows(); ++i) {
      const Eigen::Vector3d point = sample_now.points.row(i);
      for (const KdTree::Neighbor& near : tree.Nearest(point, 3)) {
        const Eigen::Vector3d normal = frame.rotation * before.normals.row(near.index).transpose();
        if (std::sqrt(near.squared_distance) > sparse ||
            normal.dot(sample_now.normals.row(i)) < 0.3)
          continue;
        ++covered;
        break;
      }
    }
    change.misfit = UpperMedian(distances);
    change.agreeing =
        std::min(static_cast<double>(agree) / static_cast<double>(before.points.rows()),
                 static_cast<double>(covered) / static_cast<double>(sample_now.points.rows()));
  }

  MeshBinding before;
  const Mesh& now;
  SurfacePlaces look;
  RayScene scene;
  double diagonal;
  MeshBinding sample_now;
  bool colored = false;
  Eigen::Vector3d gain = Eigen::Vector3d::Ones();
  FrameChange change;
};

Carrier::Carrier(const MeshBinding& before, const Mesh& now)
    : impl_(std::make_unique<Impl>(before, now)) {}
Carrier::~Carrier() = default;

const FrameChange& Carrier::change() const { return impl_->change; }

Eigen::Vector3d Carrier::BackFrom(const Eigen::Vector3d& now_point) const {
  return impl_->change.now_from_before.Inverse() * now_point;
}

namespace {

/// The nearest vertex within `radius` of `point` whose normal is close to `normal`, as a face and
/// its corner; -1 when there is none.
std::pair<int, int> FacingCorner(const Mesh& mesh, const SurfacePlaces& look,
                                 const Eigen::Vector3d& point, const Eigen::Vector3d& normal,
                                 double radius) {
  for (const KdTree::Neighbor& near : look.vertices().Within(point, radius)) {
    if (normal.dot(look.vertex_normals().row(near.index)) < kFacesAlike) continue;
    for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (mesh.faces(f, k) == near.index) return {static_cast<int>(f), k};
  }
  return {-1, 0};
}

/// Grade and reason of a place by how far the surface is from where it was, and how alike.
///
/// @param facing  cosine between the normals
/// @param color   difference of the colours
void Judge(double facing, double color, CarriedPlace* carried) {
  if (carried->off > kNear)
    carried->why = fmt::format("the surface is {:.1f} % of the diagonal away", 100 * carried->off);
  else if (facing < kFacesAway)
    carried->why = "the surface there faces another way";
  else if (color > kWrongColor)
    carried->why = "the surface there has another colour";
  if (!carried->why.empty()) return;
  carried->grade = CarriedPlace::Grade::kSure;
  if (carried->off > kSure)
    carried->why = fmt::format("{:.1f} % of the diagonal from where it was", 100 * carried->off);
  else if (facing < kFacesAlike)
    carried->why = "the surface has another slope";
  else if (color > kOtherColor)
    carried->why = "the colour differs";
  if (!carried->why.empty()) carried->grade = CarriedPlace::Grade::kDoubtful;
}

std::string WhyNotFound(const FrameChange& change) {
  if (change.ambiguous)
    return "the object looks the same from several sides, so its alignment is ambiguous";
  return fmt::format("the mesh has another shape: at best {:.0f} % of the two surfaces agree",
                     100 * change.agreeing);
}

}  // namespace

CarriedPlace Carrier::Carry(const SurfacePlace& before) const {
  const Impl& s = *impl_;
  CarriedPlace carried;
  if (!s.change.found()) {
    carried.why = WhyNotFound(s.change);
    return carried;
  }
  const Eigen::Vector3d goal = s.change.now_from_before * before.position;
  const Eigen::Vector3d normal = s.change.now_from_before.rotation * before.normal;
  const RayScene::Foot foot = s.scene.ClosestPoint(goal);
  carried.face = foot.face;
  carried.barycentric = foot.barycentric;
  SurfacePlace here = s.look.At(carried.face, carried.barycentric);
  if (here.normal.dot(normal) < kFacesAway) {
    // The nearest surface is the other side of a thin part.
    const auto [face, corner] = FacingCorner(s.now, s.look, goal, normal, kNear * s.diagonal);
    if (face >= 0) {
      carried.face = face;
      carried.barycentric = Eigen::Vector3d::Unit(corner);
      here = s.look.At(carried.face, carried.barycentric);
    }
  }
  carried.off = (here.position - goal).norm() / s.diagonal;
  const double facing = here.normal.dot(normal);
  const double color =
      before.color && here.color && s.colored ? s.ColorDifference(*before.color, *here.color) : 0;
  Judge(facing, color, &carried);
  return carried;
}

}  // namespace keypose
