#include "reconstruct/turntable/ring_order.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <iterator>
#include <map>
#include <set>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/numerics/epipolar.h"
#include "reconstruct/numerics/simplex_search.h"
#include "reconstruct/turntable/leveling.h"
#include "reconstruct/turntable/ring_fit.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Tried on 24 and 36 photographs of weak clay with shuffled names (docs/results/cameras.md); no
// record of single values. Sensitivity: docs/results/sensitivity.md.
struct RingOrderTuning {
  KEYPOSE_TUNED(double, kApart, 0.6);  // of a step: positions closer together are the same
  KEYPOSE_TUNED(double, kTaken, 0.5);  // of a step: a position nearer to a photograph is taken
  // of the camera distance: largest distance of cameras of a few views from their rings
  KEYPOSE_TUNED(double, kMostOffAxis, 0.03);
  // cameras nearer and more alike are of one ring: of the camera distance, and degrees
  KEYPOSE_TUNED(double, kSamePlace, 0.08);
  KEYPOSE_TUNED(double, kSameTurn_deg, 5);
  KEYPOSE_TUNED(double, kAnotherRing_deg, 6);  // least difference of the elevations of two rings
  // of the score at a new elevation: a position on a known ring with more is preferred
  KEYPOSE_TUNED(double, kOnRing, 0.7);
  KEYPOSE_TUNED(double, kWide, 1.5);  // of the final epipolar limit: limit during the search
};

double Wrapped(double angle) { return std::remainder(angle, 2 * kPi); }

/// Whether two ring poses (camera from table at angle 0, the camera at azimuth 0), from different
/// photographs, belong to the same ring.
bool SameRing(const Rigid3& a, const Rigid3& b) {
  const Vector3d ca = a.Inverse().translation, cb = b.Inverse().translation;
  return (ca - cb).norm() < RingOrderTuning::kSamePlace * ca.norm() &&
         a.rotation.angularDistance(b.rotation) < RingOrderTuning::kSameTurn_deg * kDegree;
}

/// A candidate position of a photograph.
struct Place {
  Rigid3 ring;           ///< pose of one of the rings, or of a new one
  int ring_index = -1;   ///< -1: a new ring
  double angle_rad = 0;  ///< of the table
  double score = 0;

  Rigid3 CameraFromTable() const {
    return {(ring.rotation * Eigen::Quaterniond(RotationAboutZ(angle_rad))).normalized(),
            ring.translation};
  }
  Vector3d Center() const { return CameraFromTable().Inverse().translation; }
};

/// A match between a photograph without a position and one with a position.
struct SeenPair {
  Vector3d own, other;  ///< rays with z = 1, each in its camera
};

class Sorter {
 public:
  Sorter(const Scene& part, const Leveling& leveling, const std::vector<std::string>& names,
         const std::vector<PairPoints>& pairs, const RingOrderOptions& options)
      : options_(options), pairs_(pairs), of_image_(names.size()) {
    const RingModel model = NearestRingModel(part, leveling);
    camera_ = model.camera;
    limit_ = options.max_error_px / camera_.fx;
    MeasureObject(Transformed(leveling.level_from_model, part));
    for (const RingView& view : model.views) {
      const std::string& name = part.views[view.image].name;
      const auto at = std::find(names.begin(), names.end(), name);
      if (at == names.end()) continue;
      const Rigid3& ring = model.rings[view.ring];
      Put(static_cast<int>(at - names.begin()), {ring, RingLike(ring), view.angle_rad, 0});
    }
    step_ = LeastStep();
  }

  /// @return number of photographs that got a position
  int PlaceOthers(Progress* progress) {
    int found = 0;
    std::vector<int> waiting;
    for (std::size_t i = 0; i < of_image_.size(); ++i)
      if (of_image_[i].ring_index < 0) waiting.push_back(static_cast<int>(i));
    const auto total = static_cast<double>(waiting.size());
    while (!waiting.empty()) {
      ReportProgress(progress, found / total, "sorting photographs along the rings");
      std::vector<Found> places(waiting.size());
      ParallelFor(std::ssize(waiting), [&](std::int64_t k) { places[k] = PlaceOf(waiting[k]); });
      const auto best =
          std::max_element(places.begin(), places.end(),
                           [](const Found& a, const Found& b) { return a.clear < b.clear; });
      const bool is_first = found == 0;
      if (best->clear < (is_first ? options_.first_clear : options_.least_clear) ||
          best->best.score < options_.min_score)
        break;
      const auto k = best - places.begin();
      Place place = best->best;
      if (place.ring_index < 0) place.ring_index = RingLike(place.ring);
      Put(waiting[k], place);
      waiting.erase(waiting.begin() + k);
      ++found;
    }
    return found;
  }

  RingOrder Order() const {
    RingOrder order;
    for (std::size_t r = 0; r < rings_.size(); ++r) {
      std::vector<std::pair<double, int>> members;  // angle, image
      for (std::size_t i = 0; i < of_image_.size(); ++i)
        if (of_image_[i].ring_index == static_cast<int>(r))
          members.emplace_back(of_image_[i].angle_rad, static_cast<int>(i));
      if (members.size() < 3) continue;
      AddRing(members, order);
    }
    std::set<int> sorted;
    for (const auto& ring : order.layout.rings)
      for (const RingLayout::Place& place : ring) sorted.insert(place.image);
    order.sorted = SizeOf(sorted);
    for (int i = 0; i < std::ssize(of_image_); ++i)
      if (!sorted.contains(i)) order.left_out.push_back(i);
    order.layout.reason += order.layout.rings.size() == 1 ? " (ring), sorted by their content"
                                                          : " (rings), sorted by their content";
    return order;
  }

 private:
  void MeasureObject(const Scene& level) {
    std::vector<Vector3d> points;
    for (const SparsePoint& point : level.points) points.push_back(point.position);
    for (int k = 0; k < 3; ++k) {
      std::vector<double> values;
      for (const Vector3d& x : points) values.push_back(x[k]);
      const auto [low, high] = TrimmedRange(std::move(values), 0.02);
      middle_[k] = 0.5 * (low + high);
    }
    std::vector<double> reach;
    for (const Vector3d& x : points) reach.push_back((x - middle_).norm());
    near_ = options_.near_surface * QuantileAbove(std::move(reach), 0.9);
    PointsX3 surface(std::ssize(points), 3);
    for (std::size_t i = 0; i < points.size(); ++i) surface.row(i) = points[i].transpose();
    surface_.emplace(surface);
  }

  /// The ring of a pose; a new one if no existing ring matches.
  int RingLike(const Rigid3& pose) {
    for (std::size_t r = 0; r < rings_.size(); ++r)
      if (SameRing(rings_[r], pose)) return static_cast<int>(r);
    rings_.push_back(pose);
    return SizeOf(rings_) - 1;
  }

  void Put(int image, const Place& place) { of_image_[image] = place; }

  struct Partner {
    Rigid3 pose;
    std::vector<SeenPair> sights;
  };

  /// The photographs with a position that share matches with an image.
  std::vector<Partner> PartnersOf(int image) const {
    std::vector<Partner> partners;
    for (const PairPoints& pair : pairs_) {
      if (pair.first != image && pair.second != image) continue;
      const bool is_first = pair.first == image;
      const Place& other = of_image_[is_first ? pair.second : pair.first];
      if (other.ring_index < 0) continue;
      Partner partner{other.CameraFromTable(), {}};
      for (Eigen::Index i = 0; i < pair.xy.rows(); ++i) {
        const Vector3d a = camera_.Unproject(pair.xy.row(i).head<2>().transpose()),
                       b = camera_.Unproject(pair.xy.row(i).tail<2>().transpose());
        partner.sights.push_back(is_first ? SeenPair{a, b} : SeenPair{b, a});
      }
      partners.push_back(std::move(partner));
    }
    return partners;
  }

  /// Whether two rays intersect in front of both cameras and near the object's surface. Along a
  /// ring the epipolar lines hardly depend on the camera's position; the match's position along the
  /// line determines it.
  bool MeetNearSurface(const Vector3d& c1, const Vector3d& d1, const Vector3d& c2,
                       const Vector3d& d2) const {
    const Vector3d between = c2 - c1;
    const double a = d1.squaredNorm(), b = d1.dot(d2), c = d2.squaredNorm(), det = a * c - b * b;
    if (det < 1e-9 * a * c) return false;
    const double s = (c * d1.dot(between) - b * d2.dot(between)) / det,
                 t = (b * d1.dot(between) - a * d2.dot(between)) / det;
    return s > 0 && t > 0 &&
           surface_->Nearest(0.5 * (c1 + s * d1 + c2 + t * d2)).squared_distance < near_ * near_;
  }

  /// Sum over the matches consistent with a pose, weighted by their distance from the epipolar
  /// line.
  double Score(const std::vector<Partner>& partners, const Rigid3& pose, double limit) const {
    const Matrix3d rotation = pose.rotation.toRotationMatrix();
    const Vector3d center = pose.Inverse().translation;
    double score = 0;
    for (const Partner& partner : partners) {
      const Matrix3d other = partner.pose.rotation.toRotationMatrix(),
                     e = EssentialOf(rotation, pose.translation, other, partner.pose.translation);
      const Vector3d other_center = partner.pose.Inverse().translation;
      for (const SeenPair& sight : partner.sights) {
        const double squared = SquaredSampson(e, sight.own, sight.other) / (limit * limit);
        if (squared < 1 && MeetNearSurface(center, rotation.transpose() * sight.own, other_center,
                                           other.transpose() * sight.other))
          score += 1 - squared;
      }
    }
    return score;
  }

  /// A ring pose with the camera moved up or down on its sphere about the object's centre.
  Rigid3 Tilted(const Rigid3& ring, double by_rad) const {
    const Vector3d aim(0, 0, middle_.z());
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(by_rad, Vector3d::UnitY()));
    return Compose(ring, {turn, aim - turn * aim});
  }

  double Elevation(const Rigid3& ring) const {
    const Vector3d c = ring.Inverse().translation - Vector3d(0, 0, middle_.z());
    return std::atan2(c.z(), c.head<2>().norm());
  }

  /// The best position.
  struct Found {
    Place best;
    double clear = 0;  ///< difference between the best position's score and any other's, in
                       ///< standard deviations of such counts
  };

  /// Among positions in the given order; positions near the best are not counted as others.
  Found BestOf(const std::vector<Place>& places) const {
    Found found;
    for (const Place& place : places)
      if (place.score > found.best.score) found.best = place;
    double rival = 0;
    const Vector3d toward = found.best.Center().normalized();
    for (const Place& place : places)
      if (place.score > rival && std::acos(std::clamp(place.Center().normalized().dot(toward), -1.0,
                                                      1.0)) > RingOrderTuning::kApart * step_)
        rival = place.score;
    found.clear = (found.best.score - rival) / std::sqrt(found.best.score + rival + 1);
    return found;
  }

  void TryRing(const std::vector<Partner>& partners, const Rigid3& ring, int ring_index,
               std::vector<Place>& tried) const {
    constexpr int kAngles = 240;
    for (int k = 0; k < kAngles; ++k) {
      Place place{ring, ring_index, 2 * kPi * k / kAngles, 0};
      if (Taken(place)) continue;
      place.score = Score(partners, place.CameraFromTable(), RingOrderTuning::kWide * limit_);
      tried.push_back(place);
    }
  }

  /// Whether another photograph has this position.
  bool Taken(const Place& place) const {
    return place.ring_index >= 0 &&
           std::any_of(of_image_.begin(), of_image_.end(), [&](const Place& other) {
             return other.ring_index == place.ring_index &&
                    std::abs(Wrapped(other.angle_rad - place.angle_rad)) <
                        RingOrderTuning::kTaken * step_;
           });
  }

  /// The smallest step between photographs on any ring, without photographs at the same position.
  double LeastStep() const {
    double least = 45 * kDegree;
    for (const Place& a : of_image_)
      for (const Place& b : of_image_) {
        const double gap = std::abs(Wrapped(a.angle_rad - b.angle_rad));
        if (a.ring_index >= 0 && a.ring_index == b.ring_index && gap > 2 * kDegree)
          least = std::min(least, gap);
      }
    return least;
  }

  /// The estimated position of an image: on one of the rings, else at a new elevation.
  Found PlaceOf(int image) const {
    const std::vector<Partner> partners = PartnersOf(image);
    std::vector<Place> tried;
    for (std::size_t r = 0; r < rings_.size(); ++r)
      TryRing(partners, rings_[r], static_cast<int>(r), tried);
    const double on_ring = BestOf(tried).best.score;
    for (double elevation = -10 * kDegree; elevation < 80 * kDegree; elevation += 3 * kDegree) {
      bool is_new = true;
      for (const Rigid3& ring : rings_)
        is_new = is_new && std::abs(Elevation(ring) - elevation) >
                               RingOrderTuning::kAnotherRing_deg * kDegree;
      // The camera rises when the table tilts towards it.
      if (is_new) TryRing(partners, Tilted(rings_[0], elevation - Elevation(rings_[0])), -1, tried);
    }
    Found found = BestOf(tried);
    // A pose close to an existing ring belongs to it: a new ring has one more unknown, and can fit
    // more matches by chance.
    if (found.best.ring_index < 0 && on_ring > RingOrderTuning::kOnRing * found.best.score) {
      std::erase_if(tried, [](const Place& place) { return place.ring_index < 0; });
      found = BestOf(tried);
    }
    if (found.best.score > 0)
      found.best = found.best.ring_index >= 0 ? RefinedAngle(partners, found.best)
                                              : RefinedRing(partners, found.best);
    return found;
  }

  Place RefinedAngle(const std::vector<Partner>& partners, Place place) const {
    for (double reach = 1.5 * kDegree; reach > 0.05 * kDegree; reach /= 3) {
      Place best = place;
      for (int k = -3; k <= 3; ++k) {
        Place near = place;
        near.angle_rad += reach * k / 3;
        near.score = Score(partners, near.CameraFromTable(), limit_);
        if (k == -3 || near.score > best.score) best = near;
      }
      place = best;
    }
    return place;
  }

  Place RefinedRing(const std::vector<Partner>& partners, const Place& place) const {
    const auto moved = [&](const Eigen::VectorXd& by) {
      Place near = place;
      near.ring = Tilted(place.ring, by(1));
      near.angle_rad += by(0);
      const Vector3d forward = near.ring.rotation * Vector3d(-1, 0, 0),
                     up = near.ring.rotation * Vector3d::UnitZ();
      near.ring.translation += place.ring.translation.norm() * (by(2) * forward + by(3) * up);
      return near;
    };
    Eigen::Vector4d at = Eigen::Vector4d::Zero();
    for (const double limit : {RingOrderTuning::kWide * limit_, limit_})
      at = MinimizeSimplex(
          [&](const Eigen::VectorXd& by) {
            return -Score(partners, moved(by).CameraFromTable(), limit);
          },
          at, Eigen::Vector4d(1.5 * kDegree, 2 * kDegree, 0.05, 0.02), 150);
    Place refined = moved(at);
    refined.score = Score(partners, refined.CameraFromTable(), limit_);
    return refined;
  }

  /// The number of even steps in a full turn that fits the angles best, each on a step of its own;
  /// 0 if none fits.
  int EvenPositions(const std::vector<std::pair<double, int>>& members, double& best_offset) const {
    const int count = SizeOf(members);
    int best = 0;
    double least = options_.max_uneven_share;
    for (int positions = std::max(4, count); positions <= 2 * count + 2; ++positions) {
      std::complex<double> sum = 0;
      for (const auto& [angle, image] : members) sum += std::polar(1.0, positions * angle);
      const double offset = std::arg(sum) / positions, step = 2 * kPi / positions;
      std::set<long> taken;
      double squares = 0;
      for (const auto& [angle, image] : members) {
        const double steps = (angle - offset) / step;
        taken.insert((std::lround(steps) % positions + positions) % positions);
        squares += std::pow(steps - std::round(steps), 2);
      }
      if (SizeOf(taken) < count || std::sqrt(squares / count) >= least) continue;
      best = positions;
      best_offset = offset;
      least = std::sqrt(squares / count);
    }
    return best;
  }

  void AddRing(std::vector<std::pair<double, int>>& members, RingOrder& order) const {
    double offset = 0;
    const int even = EvenPositions(members, offset), positions = even > 0 ? even : SizeOf(members);
    order.even = order.even && even > 0;
    const double step = 2 * kPi / positions;
    std::vector<RingLayout::Place> places;
    for (const auto& [angle, image] : members) {
      const double steps = (angle - offset) / step;
      const double index =
          even > 0 ? static_cast<double>((std::lround(steps) % positions + positions) % positions)
                   : (Wrapped(angle) + kPi) / step;
      places.push_back({image, index});
    }
    std::sort(
        places.begin(), places.end(),
        [](const RingLayout::Place& a, const RingLayout::Place& b) { return a.index < b.index; });
    order.layout.reason += (order.layout.reason.empty() ? "" : " + ") +
                           std::to_string(members.size()) + " of " + std::to_string(positions);
    order.layout.rings.push_back(std::move(places));
    order.layout.positions.push_back(positions);
  }

  const RingOrderOptions& options_;
  const std::vector<PairPoints>& pairs_;
  Camera camera_;
  double step_ = 0;   ///< approximate step of the table
  double limit_ = 0;  ///< largest distance of a match from its epipolar line, over the focal length
  Vector3d middle_ = Vector3d::Zero();  ///< of the object, on the table
  std::optional<KdTree> surface_;       ///< the part's points
  double near_ = 0;                     ///< largest distance from those points
  std::vector<Rigid3> rings_;
  std::vector<Place> of_image_;  ///< ring_index -1: no position yet
};

}  // namespace

std::optional<RingOrder> OrderOnRings(const Scene& part, const std::vector<std::string>& names,
                                      const std::vector<PairPoints>& pairs,
                                      const RingOrderOptions& options, Progress* progress) {
  if (part.views.size() < 4 || part.points.size() < 10) return std::nullopt;
  const Leveling leveling = LevelScene(part);
  if (leveling.rings < 1 || !leveling.centered_on_axis ||
      leveling.plane_rms > RingOrderTuning::kMostOffAxis ||
      leveling.circle_rms > RingOrderTuning::kMostOffAxis)
    return std::nullopt;
  Sorter sorter(part, leveling, names, pairs, options);
  if (sorter.PlaceOthers(progress) == 0) return std::nullopt;
  RingOrder order = sorter.Order();
  if (order.sorted <= std::ssize(part.views)) return std::nullopt;
  return order;
}

}  // namespace keypose::reconstruct
