#include "reconstruct/turntable/ring_silhouettes.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/numerics/simplex_search.h"
#include "reconstruct/turntable/mask_outline.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Matrix3d;
using Quaternion = Eigen::Quaterniond;
using Eigen::Vector3d;

// Measured on rings of weak clay (docs/algorithms/sfm.md); no record of single values.
// Sensitivity: docs/results/sensitivity.md.
struct RingSilhouetteTuning {
  // at the search's size: for outlines farther away the gradient is not useful
  KEYPOSE_TUNED(double, kCap_px, 12);
  // at the search's size: rays that miss by less give a point
  KEYPOSE_TUNED(double, kTouches_px, 1.5);
  KEYPOSE_TUNED(double, kSees_deg, 50);  // views with a larger angle between them do not see it
  // of the square root of the outline's area: added to half its extent, as the solid's half size
  KEYPOSE_TUNED(double, kRoom, 0.75);
  KEYPOSE_TUNED(double, kNearest, 0.05);  // of the axis' distance: least depth of the solid
  // cosine: axes nearer to the line of sight are not tried
  KEYPOSE_TUNED(double, kMostAlongSight, 0.97);
  KEYPOSE_TUNED(double, kUneven_deg, 1.5);  // largest change of a view's angle in a round
  // share of this change that is made: two inconsistent neighbours would otherwise alternate
  KEYPOSE_TUNED(double, kDamping, 0.5);
};

/// The number of samples of an evaluation.
struct Effort {
  int rays = 8, depths = 16;
};

/// Three unknowns of a ring by itself and three relative to the first ring: axis direction (2),
/// position (1), rotation, height, log scale.
using Unknowns = Eigen::Matrix<double, 6, 1>;

class Fitter {
 public:
  Fitter(const Camera& camera, const RingLayout& layout, const std::vector<Image8>& masks,
         const RingSilhouetteOptions& options)
      : options_(options),
        factor_(std::max(1, static_cast<int>(std::lround(std::max(camera.width, camera.height) /
                                                         static_cast<double>(options.width))))) {
    model_.camera = camera;
    coarse_ = camera.Scaled(1.0 / factor_);
    for (std::size_t r = 0; r < layout.rings.size(); ++r) {
      model_.step_rad.push_back(2 * kPi / layout.positions[r]);
      for (const RingLayout::Place& place : layout.rings[r])
        if (!masks[place.image].empty())
          model_.views.push_back(
              {place.image, static_cast<int>(r), place.index, place.index * model_.step_rad[r]});
    }
    std::sort(model_.views.begin(), model_.views.end(),
              [](const RingView& a, const RingView& b) { return a.image < b.image; });
    model_.rings.resize(layout.rings.size());
    outlines_.resize(model_.views.size());
    ParallelFor(std::ssize(outlines_), [&](std::int64_t v) {
      outlines_[v] = MakeOutline(masks[model_.views[v].image], camera, factor_);
    });
    for (const MaskOutline& outline : outlines_)
      half_size_ = std::max(
          half_size_, RingSilhouetteTuning::kRoom * std::sqrt(outline.area) + HalfExtent(outline));
  }

  RingSilhouettes Run(Progress* progress) {
    RingSilhouettes result;
    if (model_.views.size() < 6 || half_size_ <= 0) return result;
    for (std::size_t r = 0; r < model_.rings.size(); ++r) {
      ReportProgress(progress,
                     0.5 * static_cast<double>(r) / static_cast<double>(model_.rings.size()),
                     "searching the axis by outlines");
      if (Members(static_cast<int>(r)).size() < 5) return result;
      FindAxis(static_cast<int>(r));
    }
    for (std::size_t r = 1; r < model_.rings.size(); ++r) {
      ReportProgress(progress,
                     0.5 + 0.2 * static_cast<double>(r) / static_cast<double>(model_.rings.size()),
                     "connecting rings by outlines");
      Join(static_cast<int>(r));
    }
    for (int round = 0; round < (options_.adjust_angles ? 3 : 1); ++round) {
      ReportProgress(progress, 0.7 + 0.1 * round, "adjusting rings to outlines");
      for (std::size_t r = 0; r < model_.rings.size(); ++r) Polish(static_cast<int>(r));
      if (options_.adjust_angles) AdjustAngles();
    }
    const Effort whole{3 * options_.rays, 64};
    for (std::size_t v = 0; v < model_.views.size(); ++v) {
      std::vector<Vector3d> touching;
      result.view_error_px.push_back(factor_ * ViewError(v, All(), whole, &touching));
      for (const Vector3d& x : touching) result.points.push_back(PointOf(v, x));
    }
    for (const double e : result.view_error_px)
      result.error_px += e / static_cast<double>(result.view_error_px.size());
    result.model = model_;
    result.found = result.error_px <= options_.max_error_px * factor_;
    return result;
  }

 private:
  /// Half the largest extent of the outline, as a tangent.
  static double HalfExtent(const MaskOutline& outline) {
    double extent = 0;
    for (const Vector3d& ray : outline.rays)
      extent = std::max(extent, (ray - outline.middle).norm());
    return extent;
  }

  std::vector<std::size_t> Members(int ring) const {
    std::vector<std::size_t> members;
    for (std::size_t v = 0; v < model_.views.size(); ++v)
      if (model_.views[v].ring == ring) members.push_back(v);
    return members;
  }
  std::vector<std::size_t> All() const {
    std::vector<std::size_t> all(model_.views.size());
    for (std::size_t v = 0; v < all.size(); ++v) all[v] = v;
    return all;
  }
  static std::vector<std::size_t> Decimated(const std::vector<std::size_t>& views, int step) {
    std::vector<std::size_t> some;
    for (std::size_t k = 0; k < views.size(); k += static_cast<std::size_t>(step))
      some.push_back(views[k]);
    return some;
  }

  /// Mean over the outline's rays of the distance of their best point outside of the other masks
  /// [coarse px].
  double ViewError(std::size_t v, const std::vector<std::size_t>& against, const Effort& effort,
                   std::vector<Vector3d>* touching = nullptr) const {
    const MaskOutline& outline = outlines_[v];
    if (outline.rays.empty()) return RingSilhouetteTuning::kCap_px;
    struct Other {
      const ImageF* distance;
      Matrix3d rotation;
      Vector3d translation;
    };
    std::vector<Other> others;
    const Rigid3 own = model_.CameraFromTable(model_.views[v]).Inverse();
    for (const std::size_t j : against) {
      if (j == v) continue;
      const Rigid3 relative = Compose(model_.CameraFromTable(model_.views[j]), own);
      others.push_back(
          {&outlines_[j].distance, relative.rotation.toRotationMatrix(), relative.translation});
    }
    // Views perpendicular to the ray exclude most points, so they come first.
    std::stable_sort(others.begin(), others.end(), [](const Other& a, const Other& b) {
      return std::abs(a.rotation(2, 2)) < std::abs(b.rotation(2, 2));
    });
    const auto outside = [&](const Vector3d& x, double enough) {
      double worst = 0;
      for (const Other& other : others) {
        const Vector3d y = other.rotation * x + other.translation;
        if (y.z() <= 1e-6) return RingSilhouetteTuning::kCap_px;
        const Eigen::Vector2d pixel = coarse_.Project(y);
        worst =
            std::max(worst, static_cast<double>(DistanceAt(*other.distance, pixel.x(), pixel.y())));
        if (worst >= enough) return worst;
      }
      return worst;
    };
    const double distance = AimDistance(v), reach = half_size_ * distance;
    const int rays = std::min<int>(effort.rays, SizeOf(outline.rays));
    double sum = 0;
    for (int k = 0; k < rays; ++k) {
      const Vector3d& ray = outline.rays[static_cast<std::size_t>(k) * outline.rays.size() /
                                         static_cast<std::size_t>(rays)];
      double best = RingSilhouetteTuning::kCap_px, at = distance;
      for (int d = 0; d < effort.depths && best > 0; ++d) {
        const double depth = distance + reach * (2.0 * d / (effort.depths - 1) - 1);
        if (const double e = outside(depth * ray, best); e < best) {
          best = e;
          at = depth;
        }
      }
      double step = reach / (effort.depths - 1);
      for (int level = 0; level < 4 && best > 0; ++level, step /= 2)
        for (const double depth : {at - step, at + step})
          if (const double e = outside(depth * ray, best); e < best) {
            best = e;
            at = depth;
          }
      sum += best;
      if (touching && best < RingSilhouetteTuning::kTouches_px)
        touching->push_back(own * Vector3d(at * ray));
    }
    return sum / rays;
  }

  /// A point on the outline of view v. Views within kSees_deg are assumed to see it too.
  SparsePoint PointOf(std::size_t v, const Vector3d& x) const {
    SparsePoint point;
    point.position = x;
    point.color.setConstant(160);
    const Rigid3 own = model_.CameraFromTable(model_.views[v]);
    for (std::size_t j = 0; j < model_.views.size(); ++j) {
      const Rigid3 other = Compose(model_.CameraFromTable(model_.views[j]), own.Inverse());
      if ((other.rotation * Vector3d::UnitZ()).z() >
          std::cos(RingSilhouetteTuning::kSees_deg * kDegree))
        point.views.push_back(static_cast<int>(j));
    }
    return point;
  }

  /// Depth of the axis where a view's camera sees the centre of the solid.
  double AimDistance(std::size_t v) const {
    const Rigid3& ring = model_.rings[model_.views[v].ring];
    const Vector3d axis = ring.rotation * Vector3d::UnitZ(),
                   foot = ring.translation - ring.translation.dot(axis) * axis;
    const Vector3d& m = outlines_[v].middle;
    // The point of the ray nearest to the axis.
    const Vector3d across = m - m.dot(axis) * axis;
    return std::max(RingSilhouetteTuning::kNearest * foot.norm(),
                    across.dot(foot) / std::max(across.squaredNorm(), 1e-12));
  }

  static Rigid3 AxisPose(const Vector3d& direction, const Vector3d& through) {
    const Vector3d toward = (through - through.dot(direction) * direction).normalized();
    Matrix3d r;
    r << toward, direction.cross(toward), direction;
    return {Eigen::Quaterniond(r), toward};
  }

  Vector3d MeanMiddle(const std::vector<std::size_t>& views) const {
    Vector3d mean = Vector3d::Zero();
    for (const std::size_t v : views)
      mean += outlines_[v].middle / static_cast<double>(views.size());
    return mean;
  }

  /// `ring` with its axis rotated and moved sideways, and the table rotated, lifted and scaled.
  static Rigid3 Moved(const Rigid3& ring, const Unknowns& by) {
    const Vector3d axis = ring.rotation * Vector3d::UnitZ(),
                   toward = ring.rotation * Vector3d::UnitX(),
                   side = ring.rotation * Vector3d::UnitY();
    const Vector3d turned = (axis + by(0) * toward + by(1) * side).normalized();
    const Quaternion rotation = Quaternion::FromTwoVectors(axis, turned) * ring.rotation *
                                Quaternion(RotationAboutZ(by(3)));
    return {rotation.normalized(),
            std::exp(by(5)) * (ring.translation + by(2) * ring.translation.norm() * side) +
                by(4) * ring.translation.norm() * turned};
  }

  /// Mean error of some views with another pose of one ring, whose pose is then restored.
  double ErrorWith(int ring, const Rigid3& pose, const std::vector<std::size_t>& of,
                   const std::vector<std::size_t>& against, const Effort& effort) {
    const Rigid3 kept = model_.rings[ring];
    model_.rings[ring] = pose;
    std::vector<double> errors(of.size());
    ParallelFor(std::ssize(of),
                [&](std::int64_t k) { errors[k] = ViewError(of[k], against, effort); });
    model_.rings[ring] = kept;
    double sum = 0;
    for (const double e : errors) sum += e;
    return sum / static_cast<double>(of.size());
  }

  Unknowns Searched(int ring, const std::vector<std::size_t>& of,
                    const std::vector<std::size_t>& against, const Effort& effort,
                    const std::vector<int>& free, double size, int evaluations) {
    const Rigid3 start = model_.rings[ring];
    const Unknowns steps =
        size * (Unknowns() << 3 * kDegree, 3 * kDegree, 0.02, 4 * kDegree, 0.03, 0.05).finished();
    const auto spread = [&](const Eigen::VectorXd& x) {
      Unknowns by = Unknowns::Zero();
      for (std::size_t k = 0; k < free.size(); ++k) by(free[k]) = x(static_cast<Eigen::Index>(k));
      return by;
    };
    Eigen::VectorXd step(std::ssize(free));
    for (std::size_t k = 0; k < free.size(); ++k)
      step(static_cast<Eigen::Index>(k)) = steps(free[k]);
    return spread(MinimizeSimplex(
        [&](const Eigen::VectorXd& x) {
          return ErrorWith(ring, Moved(start, spread(x)), of, against, effort);
        },
        Eigen::VectorXd::Zero(step.size()), step, evaluations));
  }

  void FindAxis(int ring) {
    const std::vector<std::size_t> members = Members(ring);
    const std::vector<std::size_t> some =
        Decimated(members, std::max<int>(1, SizeOf(members) / 10));
    const Vector3d through = MeanMiddle(members);
    std::vector<std::pair<double, Rigid3>> tried;
    constexpr int kLatitudes = 36;
    for (int i = 0; i < kLatitudes; ++i) {
      const double polar = kPi * (i + 0.5) / kLatitudes;
      const int around =
          std::max(1, static_cast<int>(std::lround(2 * kLatitudes * std::sin(polar))));
      for (int k = 0; k < around; ++k) {
        const double turn = 2 * kPi * k / around;
        const Vector3d d(std::sin(polar) * std::cos(turn), std::cos(polar),
                         std::sin(polar) * std::sin(turn));
        if (std::abs(d.z()) < RingSilhouetteTuning::kMostAlongSight)
          tried.emplace_back(ErrorWith(ring, AxisPose(d, through), some, some, {6, 12}),
                             AxisPose(d, through));
      }
    }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    tried.resize(std::min<std::size_t>(tried.size(), 12));
    for (auto& [error, pose] : tried) {
      model_.rings[ring] = pose;
      pose = Moved(pose, Searched(ring, some, members, {10, 24}, {0, 1, 2}, 1, 50));
      error = ErrorWith(ring, pose, members, members, {10, 32});
    }
    const auto best = std::min_element(
        tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    model_.rings[ring] = best->second;
    const Unknowns by = Searched(ring, members, members, {options_.rays, 32}, {0, 1, 2}, 0.3, 80);
    model_.rings[ring] = Moved(best->second, by);
  }

  /// Height above the axis' origin at which the ring's cameras see the centre of the solid.
  double MiddleHeight(int ring) const {
    const Rigid3& pose = model_.rings[ring];
    const Vector3d axis = pose.rotation * Vector3d::UnitZ(), m = MeanMiddle(Members(ring));
    const Vector3d foot = pose.translation - pose.translation.dot(axis) * axis;
    return m.dot(axis) / m.dot(foot) * foot.squaredNorm() - pose.translation.dot(axis);
  }

  void Join(int ring) {
    std::vector<std::size_t> others;
    for (std::size_t v = 0; v < model_.views.size(); ++v)
      if (model_.views[v].ring < ring) others.push_back(v);
    const std::vector<std::size_t> members = Members(ring);
    std::vector<std::size_t> both = others;
    both.insert(both.end(), members.begin(), members.end());
    const auto area = [&](const std::vector<std::size_t>& views) {
      double sum = 0;
      for (const std::size_t v : views)
        sum += std::sqrt(outlines_[v].area) / static_cast<double>(views.size());
      return sum;
    };
    const std::vector<std::size_t> first = Members(0);
    // The closer a camera, the larger the solid in its pictures.
    const auto aim = [&](int r) { return AimDistance(Members(r)[0]); };
    const double scale = std::log(aim(0) / aim(ring) * area(first) / area(members));
    const Rigid3 own = model_.rings[ring];
    const double lift = std::exp(scale) * MiddleHeight(ring) - MiddleHeight(0);
    std::vector<std::pair<double, Rigid3>> tried;
    for (int turn = 0; turn < 72; ++turn)
      for (int s = -1; s <= 1; ++s) {
        Unknowns by = Unknowns::Zero();
        by.tail<3>() << turn * 5 * kDegree, lift / own.translation.norm(), scale + 0.07 * s;
        tried.emplace_back(
            ErrorWith(ring, Moved(own, by), Decimated(members, 3), Decimated(others, 2), {8, 24}),
            Moved(own, by));
      }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    tried.resize(8);
    for (auto& [error, pose] : tried) {
      model_.rings[ring] = pose;
      pose = Moved(pose, Searched(ring, Decimated(both, 3), both, {8, 32}, {3, 4, 5}, 1, 60));
      error = ErrorWith(ring, pose, both, both, {10, 32});
    }
    model_.rings[ring] =
        std::min_element(tried.begin(), tried.end(), [](const auto& a, const auto& b) {
          return a.first < b.first;
        })->second;
  }

  void Polish(int ring) {
    const std::vector<int> free =
        ring == 0 ? std::vector<int>{0, 1, 2} : std::vector<int>{0, 1, 2, 3, 4, 5};
    const Rigid3 start = model_.rings[ring];
    const Unknowns by =
        Searched(ring, All(), All(), {options_.rays, 32}, free, 0.15, ring == 0 ? 60 : 110);
    model_.rings[ring] = Moved(start, by);
  }

  /// Adjusts the table's angle at each view by the view's own outline. All views use the angles
  /// from before the step.
  void AdjustAngles() {
    std::vector<double> angles(model_.views.size());
    for (std::size_t v = 0; v < model_.views.size(); ++v) {
      RingView& view = model_.views[v];
      const double start = view.angle_rad;
      double best = start, least = std::numeric_limits<double>::infinity(),
             reach = RingSilhouetteTuning::kUneven_deg * kDegree;
      for (int level = 0; level < 3; ++level, reach /= 3) {
        const double middle = best;
        for (int k = -2; k <= 2; ++k) {
          view.angle_rad = middle + reach * k / 2;
          if (const double e = ViewError(v, All(), {options_.rays, 32}); e < least) {
            least = e;
            best = view.angle_rad;
          }
        }
      }
      angles[v] = best;
      view.angle_rad = start;
    }
    for (std::size_t v = 0; v < model_.views.size(); ++v)
      model_.views[v].angle_rad +=
          RingSilhouetteTuning::kDamping * (angles[v] - model_.views[v].angle_rad);
  }

  const RingSilhouetteOptions& options_;
  int factor_;
  Camera coarse_;
  RingModel model_;
  std::vector<MaskOutline> outlines_;
  double half_size_ = 0;  ///< extent of the solid from its centre, over the distance
};

}  // namespace

RingSilhouettes FitRingToSilhouettes(const Camera& camera, const RingLayout& layout,
                                     const std::vector<Image8>& masks,
                                     const RingSilhouetteOptions& options, Progress* progress) {
  for (const auto& ring : layout.rings)
    for (const RingLayout::Place& place : ring) {
      const Image8& mask = masks.at(static_cast<std::size_t>(place.image));
      if (!mask.empty() &&
          (mask.channels != 1 || mask.width != camera.width || mask.height != camera.height))
        throw InputError("silhouettes: the mask of photograph " + std::to_string(place.image) +
                         " is " + std::to_string(mask.width) + " x " + std::to_string(mask.height) +
                         ", but the camera has " + std::to_string(camera.width) + " x " +
                         std::to_string(camera.height));
    }
  return Fitter(camera, layout, masks, options).Run(progress);
}

}  // namespace keypose::reconstruct
