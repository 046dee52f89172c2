#include "reconstruct/turntable/ring_start.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <set>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/numerics/epipolar.h"
#include "reconstruct/numerics/simplex_search.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct RingSearchTuning {
  KEYPOSE_TUNED(double, kWide_rad, 0.005);     // largest epipolar error of inliers in the search
  KEYPOSE_TUNED(double, kNarrow_rad, 0.0012);  // the same at the end
  // between the views of a pair: less has no baseline, with more nothing matches
  KEYPOSE_TUNED(double, kLeastTurn_deg, 4);
  KEYPOSE_TUNED(double, kMostTurn_deg, 75);
  // cosine: axes nearer to the line of sight are not tried
  KEYPOSE_TUNED(double, kMostAlongSight, 0.985);
  // how far a view's angle may be from even steps: in degrees, and of a step
  KEYPOSE_TUNED(double, kUneven_deg, 3);
  KEYPOSE_TUNED(double, kUnevenShare, 0.4);
  KEYPOSE_TUNED(double, kFewestJoining, 12);  // matches across rings that join them
};

/// A match as rays with z = 1.
struct Match {
  int a, b;  ///< indices of its views in the list of views
  Vector3d x, y;
};

/// Truncated squared errors of matches. Essential matrices are computed once per pair of views.
class MatchCost {
 public:
  explicit MatchCost(std::vector<Match> matches) : matches_(std::move(matches)) {
    std::map<std::pair<int, int>, int> found;
    for (const Match& m : matches_) {
      const auto [at, is_new] = found.try_emplace({m.a, m.b}, SizeOf(pairs_));
      if (is_new) pairs_.emplace_back(m.a, m.b);
      pair_of_.push_back(at->second);
    }
  }
  /// @param pose  rotation and translation of a view by its index
  template <class Pose>
  double Cost(const Pose& pose, double limit) const {
    std::vector<Matrix3d> essential(pairs_.size());
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const auto [r1, t1] = pose(pairs_[k].first);
      const auto [r2, t2] = pose(pairs_[k].second);
      essential[k] = EssentialOf(r1, t1, r2, t2);
    }
    double cost = 0;
    for (std::size_t i = 0; i < matches_.size(); ++i)
      cost += std::min(1.0, SquaredSampson(essential[pair_of_[i]], matches_[i].x, matches_[i].y) /
                                (limit * limit));
    return cost;
  }
  std::size_t size() const { return matches_.size(); }

 private:
  std::vector<Match> matches_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<int> pair_of_;
};

/// At most `count`, evenly spread over the list.
std::vector<Match> Sampled(const std::vector<Match>& matches, std::size_t count) {
  if (matches.size() <= count) return matches;
  std::vector<Match> sample;
  for (std::size_t k = 0; k < count; ++k) sample.push_back(matches[k * matches.size() / count]);
  return sample;
}

double WrappedTurn(double a, double b) { return std::abs(std::remainder(a - b, 2 * kPi)); }

/// Axis direction and position of one ring in its camera's frame.
struct Axis {
  Vector3d direction;
  double offset_rad;  ///< angle, seen from the camera, of the axis' nearest point from the plane of
                      ///< axis direction and optical axis

  /// Camera from table, whose origin is the axis' point nearest to the camera, at distance 1.
  Rigid3 Pose() const {
    const Vector3d toward = (Vector3d::UnitZ() - direction.z() * direction).normalized(),
                   side = direction.cross(toward);
    Matrix3d r;
    r << toward, side, direction;
    return {Eigen::Quaterniond(r), std::cos(offset_rad) * toward + std::sin(offset_rad) * side};
  }
};

bool Sensible(const Vector3d& direction) {
  return std::abs(direction.z()) < RingSearchTuning::kMostAlongSight;
}

/// Directions over the whole sphere at a distance of about `spacing`, on rings of latitude about y.
/// Opposite directions are both included: they differ in the direction of rotation.
std::vector<Vector3d> SphereDirections(double spacing) {
  std::vector<Vector3d> directions;
  const int latitudes = static_cast<int>(std::lround(kPi / spacing));
  for (int i = 0; i < latitudes; ++i) {
    const double polar = kPi * (i + 0.5) / latitudes;
    const int around =
        std::max(1, static_cast<int>(std::lround(2 * kPi * std::sin(polar) / spacing)));
    for (int k = 0; k < around; ++k) {
      const double turn = 2 * kPi * k / around;
      const Vector3d d(std::sin(polar) * std::cos(turn), std::cos(polar),
                       std::sin(polar) * std::sin(turn));
      if (Sensible(d)) directions.push_back(d);
    }
  }
  return directions;
}

/// An axis near `axis`, by two rotations of its direction and one change of its position.
Axis Nudged(const Axis& axis, const Eigen::VectorXd& by) {
  const Rigid3 pose = axis.Pose();
  const Vector3d turned = axis.direction + by(0) * (pose.rotation * Vector3d::UnitX()) +
                          by(1) * (pose.rotation * Vector3d::UnitY());
  return {turned.normalized(), axis.offset_rad + by(2)};
}

class Finder {
 public:
  Finder(const Camera& camera, const RingLayout& layout, const std::vector<PairPoints>& pairs) {
    result_.model.camera = camera;
    for (std::size_t r = 0; r < layout.rings.size(); ++r) {
      result_.model.step_rad.push_back(2 * kPi / layout.positions[r]);
      for (const RingLayout::Place& place : layout.rings[r])
        views().push_back({place.image, static_cast<int>(r), place.index,
                           place.index * result_.model.step_rad[r]});
    }
    result_.model.rings.resize(layout.rings.size());
    std::sort(views().begin(), views().end(),
              [](const RingView& a, const RingView& b) { return a.image < b.image; });
    ReadMatches(pairs);
  }

  RingStart Run(Progress* progress) {
    for (int r = 0; r < rings(); ++r) {
      ReportProgress(progress, 0.6 * r / rings(), "searching the table's axis");
      FindAxis(r);
    }
    std::set<int> joined{0};
    for (int round = 1; round < rings(); ++round) {
      ReportProgress(progress, 0.6 + 0.3 * round / rings(), "connecting rings");
      result_.joined = Join(joined) && result_.joined;
    }
    RelaxAngles(matches_, RingSearchTuning::kNarrow_rad);
    Count();
    return std::move(result_);
  }

 private:
  std::vector<RingView>& views() { return result_.model.views; }
  int rings() const { return SizeOf(result_.model.rings); }
  const RingView& view(int place) const { return result_.model.views[place]; }

  void ReadMatches(const std::vector<PairPoints>& pairs) {
    std::map<int, int> place_of;
    for (std::size_t v = 0; v < views().size(); ++v)
      place_of[views()[v].image] = static_cast<int>(v);
    for (const PairPoints& pair : pairs) {
      const auto a = place_of.find(pair.first), b = place_of.find(pair.second);
      if (a == place_of.end() || b == place_of.end()) continue;
      for (Eigen::Index i = 0; i < pair.xy.rows(); ++i)
        matches_.push_back({a->second, b->second,
                            result_.model.camera.Unproject(pair.xy.row(i).head<2>().transpose()),
                            result_.model.camera.Unproject(pair.xy.row(i).tail<2>().transpose())});
    }
  }

  /// Matches within one ring, of views neither too close for a baseline nor too far apart to match.
  std::vector<Match> RingMatches(int ring) const {
    std::vector<Match> found;
    for (const Match& m : matches_) {
      if (view(m.a).ring != ring || view(m.b).ring != ring) continue;
      const double turn = WrappedTurn(view(m.a).angle_rad, view(m.b).angle_rad);
      if (turn > RingSearchTuning::kLeastTurn_deg * kDegree &&
          turn < RingSearchTuning::kMostTurn_deg * kDegree)
        found.push_back(m);
    }
    return found;
  }

  double AxisCost(const MatchCost& match_cost, const Axis& axis, double limit) const {
    const Rigid3 pose = axis.Pose();
    const Matrix3d r = pose.rotation.toRotationMatrix();
    return match_cost.Cost(
        [&](int v) {
          return std::pair<Matrix3d, Vector3d>(r * RotationAboutZ(view(v).angle_rad),
                                               pose.translation);
        },
        limit);
  }

  /// Axes over all directions with what they cost, the cheapest first.
  std::vector<std::pair<double, Axis>> LikelyAxes(const MatchCost& few) const {
    const std::vector<Vector3d> directions = SphereDirections(5 * kDegree);
    // -12 to 12 degrees: the table's axis passes through the picture's middle part
    constexpr int kOffsets = 9;
    constexpr std::size_t kKept = 24;
    std::vector<std::pair<double, Axis>> tried(directions.size());
    ParallelFor(
        std::ssize(directions),
        [&](std::int64_t k) {
          auto& best = tried[k];
          best.first = 1e300;
          for (int o = 0; o < kOffsets; ++o) {
            const Axis axis{directions[k], 3 * kDegree * (o - kOffsets / 2)};
            const double c = AxisCost(few, axis, 2 * RingSearchTuning::kWide_rad);
            if (c < best.first) best = {c, axis};
          }
        },
        8);
    std::stable_sort(tried.begin(), tried.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    tried.resize(std::min(tried.size(), kKept));
    return tried;
  }

  void FindAxis(int ring) {
    const std::vector<Match> matches = RingMatches(ring);
    const MatchCost few(Sampled(matches, 400)), many(Sampled(matches, 4000));
    const auto refined = [&](const Axis& axis, const MatchCost& by, double limit, int evaluations) {
      const auto cost = [&](const Axis& a) { return AxisCost(by, a, limit); };
      return Refined(axis, cost, evaluations);
    };
    std::vector<std::pair<double, Axis>> tried = LikelyAxes(few);
    ParallelFor(std::ssize(tried), [&](std::int64_t k) {
      auto& [c, axis] = tried[k];
      for (const double limit : {2 * RingSearchTuning::kWide_rad, RingSearchTuning::kWide_rad})
        axis = refined(axis, few, limit, 120);
      c = AxisCost(many, axis, RingSearchTuning::kWide_rad);
    });
    Axis axis = std::min_element(tried.begin(), tried.end(), [](const auto& a, const auto& b) {
                  return a.first < b.first;
                })->second;
    axis = refined(axis, many, RingSearchTuning::kWide_rad, 150);
    for (const double limit : {RingSearchTuning::kWide_rad, 0.5 * RingSearchTuning::kWide_rad,
                               RingSearchTuning::kNarrow_rad}) {
      result_.model.rings[ring] = axis.Pose();
      RelaxAngles(matches, limit);
      axis = refined(axis, many, limit, 150);
    }
    result_.model.rings[ring] = axis.Pose();
  }

  template <class Cost>
  static Axis Refined(const Axis& axis, const Cost& cost, int evaluations) {
    const Eigen::Vector3d step(1.5 * kDegree, 1.5 * kDegree, 1 * kDegree);
    const auto bounded = [&](const Eigen::VectorXd& by) {
      const Axis nudged = Nudged(axis, by);
      return Sensible(nudged.direction) ? cost(nudged) : 1e300;
    };
    return Nudged(axis, MinimizeSimplex(bounded, Eigen::Vector3d::Zero(), step, evaluations));
  }

  /// Adjusts the table's angle at each view with the others fixed: a few sweeps over views, each a
  /// search around the present angle.
  void RelaxAngles(const std::vector<Match>& matches, double limit) {
    std::vector<std::vector<const Match*>> of(views().size());
    for (const Match& m : matches) {
      of[m.a].push_back(&m);
      of[m.b].push_back(&m);
    }
    for (int sweep = 0; sweep < 3; ++sweep)
      for (std::size_t v = 0; v < views().size(); ++v)
        if (of[v].size() >= 5) RelaxAngle(static_cast<int>(v), of[v], limit);
  }

  void RelaxAngle(int v, const std::vector<const Match*>& all, double limit) {
    RingView& moving = views()[v];
    std::vector<Match> matches;
    for (std::size_t k = 0; k < std::min<std::size_t>(all.size(), 300); ++k) {
      const Match& m = *all[k * all.size() / std::min<std::size_t>(all.size(), 300)];
      matches.push_back(m);
    }
    const MatchCost match_cost(std::move(matches));
    const auto cost = [&](double angle) {
      moving.angle_rad = angle;
      return match_cost.Cost(
          [&](int at) {
            const Rigid3 pose = result_.model.CameraFromTable(view(at));
            return std::pair<Matrix3d, Vector3d>(pose.rotation.toRotationMatrix(),
                                                 pose.translation);
          },
          limit);
    };
    const double start = moving.angle_rad, least = cost(start);
    double best = start, best_cost = least;
    double reach =
        std::min(RingSearchTuning::kUneven_deg * kDegree,
                 RingSearchTuning::kUnevenShare * std::abs(result_.model.step_rad[moving.ring]));
    for (int level = 0; level < 4; ++level, reach /= 4) {
      const double middle = best;
      for (int k = -4; k <= 4; ++k)
        if (const double c = cost(middle + reach * k / 4); c < best_cost) {
          best_cost = c;
          best = middle + reach * k / 4;
        }
    }
    moving.angle_rad = best;
  }

  /// Rotates, lifts and scales the ring with most matches relative to the joined ones.
  /// @return whether the matches are conclusive
  bool Join(std::set<int>& joined) {
    std::vector<std::vector<Match>> across(static_cast<std::size_t>(rings()));
    for (const Match& m : matches_) {
      const int ra = view(m.a).ring, rb = view(m.b).ring;
      if (joined.contains(ra) != joined.contains(rb))
        across[joined.contains(ra) ? rb : ra].push_back(m);
    }
    const auto most =
        std::max_element(across.begin(), across.end(),
                         [](const auto& a, const auto& b) { return a.size() < b.size(); });
    const int ring = static_cast<int>(most - across.begin());
    if (most->empty()) return false;
    joined.insert(ring);
    return Place(ring, *most);
  }

  /// A ring turned about the table's axis, moved along it and scaled: x = (turn, height, log
  /// scale).
  static Rigid3 Moved(const Rigid3& ring, const Eigen::VectorXd& x) {
    const Vector3d axis = ring.rotation * Vector3d::UnitZ();
    return {ring.rotation * Eigen::Quaterniond(RotationAboutZ(x(0))),
            std::exp(x(2)) * ring.translation + x(1) * axis};
  }

  double MoveCost(const MatchCost& match_cost, int ring, const Eigen::VectorXd& x,
                  double limit) const {
    RingModel model = result_.model;
    model.rings[ring] = Moved(model.rings[ring], x);
    return match_cost.Cost(
        [&](int v) {
          const Rigid3 pose = model.CameraFromTable(view(v));
          return std::pair<Matrix3d, Vector3d>(pose.rotation.toRotationMatrix(), pose.translation);
        },
        limit);
  }

  /// Moves of a ring over all turns with what they cost, the cheapest first.
  std::vector<std::pair<double, Eigen::VectorXd>> LikelyMoves(int ring,
                                                              const MatchCost& few) const {
    constexpr int kTurns = 120, kHeights = 13, kScales = 7, kKept = 12;
    const Rigid3& own = result_.model.rings[ring];
    std::vector<std::pair<double, Eigen::VectorXd>> tried(kTurns);
    // Both cameras look at the same object, so the height follows from where both see its centre,
    // within a tolerance.
    const double middle = AimHeight(own, 1), first = AimHeight(result_.model.rings[0], 1);
    ParallelFor(kTurns, [&](std::int64_t k) {
      tried[k] = {1e300, Eigen::Vector3d::Zero()};
      for (int s = 0; s < kScales; ++s)
        for (int h = 0; h < kHeights; ++h) {
          const double scale = 0.1 * (s - kScales / 2) + LogDistanceRatio(own);
          const Eigen::Vector3d x(2 * kPi * static_cast<double>(k) / kTurns,
                                  std::exp(scale) * middle - first + 0.04 * (h - kHeights / 2),
                                  scale);
          const double c = MoveCost(few, ring, x, 2 * RingSearchTuning::kWide_rad);
          if (c < tried[k].first) tried[k] = {c, x};
        }
    });
    std::stable_sort(tried.begin(), tried.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    tried.resize(kKept);
    return tried;
  }

  bool Place(int ring, const std::vector<Match>& matches) {
    // Samples for the rest of the search.
    const MatchCost few(Sampled(matches, 300)), many(Sampled(matches, 3000));
    std::vector<std::pair<double, Eigen::VectorXd>> tried = LikelyMoves(ring, few);
    ParallelFor(std::ssize(tried), [&](std::int64_t k) {
      auto& [c, x] = tried[k];
      for (const double limit : {2 * RingSearchTuning::kWide_rad, RingSearchTuning::kWide_rad,
                                 RingSearchTuning::kNarrow_rad})
        x = MinimizeSimplex(
            [&](const Eigen::VectorXd& y) {
              return MoveCost(limit == RingSearchTuning::kNarrow_rad ? many : few, ring, y, limit);
            },
            x, Eigen::Vector3d(2 * kDegree, 0.03, 0.06), 120);
      c = MoveCost(many, ring, x, RingSearchTuning::kNarrow_rad);
    });
    const auto best = *std::min_element(
        tried.begin(), tried.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    result_.model.rings[ring] = Moved(result_.model.rings[ring], best.second);
    return static_cast<double>(many.size()) - best.first >= RingSearchTuning::kFewestJoining;
  }

  /// Height on the axis, in units of the distance to it, of the point nearest to the camera's
  /// optical axis. Moving the origin there adds the returned number, times the axis, to the
  /// translation.
  static double AimHeight(const Rigid3& ring, double scale) {
    // On the axis: own.translation + h * axis is nearest to the optical axis z.
    const Vector3d a = ring.rotation * Vector3d::UnitZ(), t = ring.translation;
    const double across = a.head<2>().squaredNorm();
    return across < 1e-9 ? 0 : -scale * a.head<2>().dot(t.head<2>()) / across;
  }

  /// Rings are shot from about the same distance to the object: log of the scale of the distance to
  /// the axis for which that holds.
  double LogDistanceRatio(const Rigid3& own) const {
    const auto distance = [](const Rigid3& ring) {
      return (ring.translation + AimHeight(ring, 1) * (ring.rotation * Vector3d::UnitZ())).norm();
    };
    return std::log(distance(result_.model.rings[0]) / distance(own));
  }

  void Count() {
    const double limit = RingStartTuning::kInlier_px / result_.model.camera.fx;
    for (const Match& m : matches_) {
      const Rigid3 a = result_.model.CameraFromTable(view(m.a)),
                   b = result_.model.CameraFromTable(view(m.b));
      const Matrix3d e = EssentialOf(a.rotation.toRotationMatrix(), a.translation,
                                     b.rotation.toRotationMatrix(), b.translation);
      ++result_.matches;
      if (SquaredSampson(e, m.x, m.y) <= limit * limit) ++result_.inliers;
    }
    result_.inlier_share =
        result_.matches > 0 ? result_.inliers / static_cast<double>(result_.matches) : 0;
  }

  RingStart result_;
  std::vector<Match> matches_;
};

}  // namespace

std::vector<PairPoints> PointsOf(const std::vector<PairMatches>& matches,
                                 const std::vector<Features>& features) {
  std::vector<PairPoints> points;
  for (const PairMatches& pair : matches) {
    PairPoints p{pair.first, pair.second, {}};
    p.xy.resize(std::ssize(pair.features), 4);
    for (std::size_t k = 0; k < pair.features.size(); ++k)
      p.xy.row(k) << features[pair.first].positions.row(pair.features[k].first).cast<double>(),
          features[pair.second].positions.row(pair.features[k].second).cast<double>();
    points.push_back(std::move(p));
  }
  return points;
}

RingStart FindRingModel(const Camera& camera, const RingLayout& layout,
                        const std::vector<PairPoints>& pairs, Progress* progress) {
  return Finder(camera, layout, pairs).Run(progress);
}

std::vector<int> RingInliers(const RingModel& model, const RingView& first, const RingView& second,
                             const PairPoints& pair, double max_error_px) {
  const Rigid3 a = model.CameraFromTable(first), b = model.CameraFromTable(second);
  const Matrix3d e = EssentialOf(a.rotation.toRotationMatrix(), a.translation,
                                 b.rotation.toRotationMatrix(), b.translation);
  const double limit = max_error_px / model.camera.fx;
  std::vector<int> rows;
  for (Eigen::Index i = 0; i < pair.xy.rows(); ++i)
    if (SquaredSampson(e, model.camera.Unproject(pair.xy.row(i).head<2>().transpose()),
                       model.camera.Unproject(pair.xy.row(i).tail<2>().transpose())) <=
        limit * limit)
      rows.push_back(static_cast<int>(i));
  return rows;
}

}  // namespace keypose::reconstruct
