#include "register/auto/auto_registration.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <optional>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/solvers/sparse_pattern.h"
#include "register/auto/auto_fit.h"
#include "register/auto/rigid_parts.h"
#include "register/auto/whole_area.h"
#include "register/intrinsic/suggest.h"
#include "register/skeleton/skeleton_start.h"

namespace keypose::registration {

namespace {

// Chosen on tentacle seeds 0 to 9 (docs/results/tentacle.md) and the seven registration pairs
// (docs/results/registration.md), the scale on damaged copies of these pairs
// (docs/algorithms/register.md); sensitivity: docs/results/sensitivity.md.
// Lengths assume a target whose diagonal is 2.
struct AutoRegistrationTuning {
  // Stiffness of the shape term, relative to the surface.
  KEYPOSE_TUNED(double, kFirstStiffness, 3);     // in the first round on the coarse level
  KEYPOSE_TUNED(double, kCoarseStiffness, 1);    // in the last round on the coarse level
  KEYPOSE_TUNED(double, kMiddleStiffness, 0.5);  // at the end of a rigid shape on the middle level
  KEYPOSE_TUNED(double, kSoftStiffness, 0.02);   // at the end of a softened shape
  KEYPOSE_TUNED(double, kFineStiffness, 0.2);    // on the finer levels, when the shape stays rigid
  // Rigidity, see ArapFit.
  KEYPOSE_TUNED(double, kSofter, 0.3);  // of the softer starts
  KEYPOSE_TUNED(double, kSoft, 0.1);    // of a softened shape
  // Distance at which a surface pull has a quarter of its weight, in the first and the last round.
  KEYPOSE_TUNED(double, kRobustFirst, 0.4);
  KEYPOSE_TUNED(double, kRobustLast, 0.02);
  KEYPOSE_TUNED(double, kMatchesFirst, 150);  // weight of all matches together in the first round
  KEYPOSE_TUNED(double, kMatchesFall, 0.7);   // its factor from round to round
  KEYPOSE_TUNED(double, kDoubt, 0.2);         // mismatch of an intrinsic match without confidence
  // Share of the last movement that is repeated when maps are soft, since sliding along the surface
  // converges slowly.
  KEYPOSE_TUNED(double, kMomentum, 0.95);
  // Weights in the score of a start. The gap over the diagonal has weight 1.
  KEYPOSE_TUNED(double, kStrainWeight, 0.02);    // of the mean squared strain
  KEYPOSE_TUNED(double, kRejectedWeight, 0.02);  // of the share of area that faces nothing
  KEYPOSE_TUNED(double, kHopeless, 1.3);  // of poor_fit: even a softer shape came nowhere near
  // Share of the area from which on rigid pieces alone decide the scale, as the rest may stretch.
  KEYPOSE_TUNED(double, kPiecesDecide, 0.1);
  // Area of discs over the boundary loops, as a share; above this the surface counts as open.
  KEYPOSE_TUNED(double, kOpenShare, 0.06);
  // A target whose share of discs is this much larger, with landmarks this factor further apart, is
  // cut.
  KEYPOSE_TUNED(double, kCutShare, 0.01);
  KEYPOSE_TUNED(double, kCutGrowth, 1.04);
};

// Distances along the surface are measured on meshes of about this size.
constexpr int kProxyVertices = 3000;
constexpr int kFewestForDistances = 4;  // landmarks that tell places apart by distance
// The middle level has at least this share of middle_vertices.
constexpr double kMiddleOfCoarse = 0.5;
constexpr double kRigid = 1e300;
constexpr int kCoarseSamples = 1500, kSamples = 6000;  // target vertices that pull back
// Above this number of vertices a level gets two searches instead of four.
constexpr int kLargeLevel = 30000;
// A result that has slid is tried again from the parts that moved as rigid bodies.
constexpr double kPinWeight = 1000;    // of each pin of a part, in units of the shape term
constexpr double kStaysInPlace = 0.7;  // share of a part from which on a result has not slid
constexpr double kFurther = 1.25;      // factor by which the gap may grow
constexpr double kFirstRun = 0.95;     // of the progress

/// The rounds on one level. Stiffness falls geometrically from round to round; so do the weights of
/// landmarks and matches and the robust distance.
struct Schedule {
  int rounds, searches, turns;
  double from, to;  ///< stiffness
};
const Schedule kCoarse{6, 4, 6, AutoRegistrationTuning::kFirstStiffness,
                       AutoRegistrationTuning::kCoarseStiffness};
const Schedule kMiddle{3, 2, 6, AutoRegistrationTuning::kCoarseStiffness,
                       AutoRegistrationTuning::kMiddleStiffness};
const Schedule kSoftened{5, 4, 2, AutoRegistrationTuning::kMiddleStiffness,
                         AutoRegistrationTuning::kSoftStiffness};
const Schedule kSettled{5, 2, 3, AutoRegistrationTuning::kMiddleStiffness,
                        AutoRegistrationTuning::kMiddleStiffness};
const int kAllRounds = kCoarse.rounds + kMiddle.rounds + kSoftened.rounds;

/// Repeats a share of the last movement of each vertex. Only vertices held by the surface move;
/// others would oscillate.
class Momentum {
 public:
  explicit Momentum(const Level& level)
      : before_(level.moved), seen_(Eigen::VectorXd::Zero(level.moved.rows())) {}
  void CarryOn(Level& level) {
    PointsX3 now = level.moved;
    level.moved += (AutoRegistrationTuning::kMomentum * seen_).asDiagonal() * (now - before_);
    before_ = std::move(now);
  }
  Eigen::VectorXd* seen() { return &seen_; }

 private:
  PointsX3 before_;
  Eigen::VectorXd seen_;
};

double Between(double from, double to, double x) { return from * std::pow(to / from, x); }

PointsX3 MarkPositions(const std::vector<LandmarkGoal>& landmarks, const PointsX3* source) {
  PointsX3 points(std::ssize(landmarks), 3);
  for (std::size_t k = 0; k < landmarks.size(); ++k)
    points.row(k) = source ? PositionOf(landmarks[k].source, *source) : landmarks[k].target;
  return points;
}

class AutoRegistration {
 public:
  AutoRegistration(const Mesh& source, const Mesh& target,
                   const std::vector<LandmarkGoal>& landmarks, const Eigen::VectorXd& stiffness,
                   const AutoOptions& options, const std::vector<RigidPart>& parts,
                   Progress* progress)
      : source_(source),
        target_(target),
        landmarks_(landmarks),
        stiffness_(stiffness),
        options_(options),
        progress_(progress),
        parts_(parts) {}
  AutoResult Run();

 private:
  using Tuning = AutoRegistrationTuning;
  struct Start {
    PointsX3 moved;
    std::vector<Eigen::Matrix3d> maps;
    std::vector<LandmarkCoordinates::Match> matches[2];  // for the coarse and the middle level
    double rigidity = kRigid;
    double scale = 1;                        // of the rest shape
    const PointsX3* match_points = nullptr;  // the points that matches index
  };
  /// A start after the rounds on the coarse level (or none if it failed), and its measures.
  struct Attempt {
    std::optional<Start> start;
    StartTrial trial;
  };

  void Align();
  void Prepare();
  void MeasureDistances();
  void TryStarts();
  Attempt FromLandmarks(double rigidity, const std::string& name);
  Attempt FromIntrinsicMap(double rigidity, const std::string& name);
  Attempt FromSkeleton();
  Attempt BendCoarse(Start start, StartTrial trial);
  static Attempt Unusable(StartTrial trial);
  void Compete(Attempt attempt);
  void Reset(Level& level);
  void SetRestScale(double scale);
  SurfaceGap RunRounds(int level, const Schedule& schedule, int rounds_before,
                       const PointsX3* match_points);
  void Finish();
  Level& coarse() { return (*levels_)[levels_->count() - 1]; }
  PointsX3 Back(const PointsX3& points) const { return (points * unit_).rowwise() + origin_; }

  const Mesh& source_;
  const Mesh& target_;
  const std::vector<LandmarkGoal>& landmarks_;
  const Eigen::VectorXd& stiffness_;
  const AutoOptions& options_;
  Progress* progress_;

  Similarity3 place_;
  Eigen::RowVector3d origin_ = Eigen::RowVector3d::Zero();
  double unit_ = 1;
  std::vector<LandmarkGoal> goals_;  // landmarks in the normalised frame
  std::optional<SurfacePull> surface_;
  std::optional<Levels> levels_;
  int middle_ = 0;
  double more_open_ = 0;  // how much more open the target is than the source: the difference of
                          // `filled` in WholeArea
  double first_scale_ = 1, rest_scale_ = 1;
  PointsX3 goal_points_;   // the target's points, normalised
  PointsX3 proxy_points_;  // those of the target's proxy, which matches by distance index
  std::vector<LandmarkCoordinates::Match> distance_matches_[2];
  std::optional<Suggestion> suggestion_;  // computed once, for all starts that use it
  std::optional<Start> best_;
  AutoResult result_;
  const std::vector<RigidPart>& parts_;  ///< where parts of the source lie, if that is known
};

void AutoRegistration::Align() {
  if (!parts_.empty()) {
    place_ = parts_[0].target_from_source;
    result_.alignment = {.target_from_source = place_, .method = "unmoved part"};
    return;
  }
  result_.alignment = AlignGlobally(source_, target_, MarkPositions(landmarks_, &source_.points),
                                    MarkPositions(landmarks_, nullptr));
  place_ = result_.alignment.target_from_source;
  double filled_source = 0, filled_target = 0;
  const double areas = WholeArea(target_, filled_target) / WholeArea(source_, filled_source);
  more_open_ = filled_target - filled_source;
  if (filled_target > Tuning::kOpenShare && landmarks_.size() == 3) return;
  // Folded limbs bring landmarks closer together, so Procrustes would shrink the source. The area
  // hardly changes, so it gives the size.
  const PointsX3 pivots =
      landmarks_.empty() ? source_.points : MarkPositions(landmarks_, &source_.points);
  const Eigen::Vector3d pivot = pivots.colwise().mean().transpose();
  const Eigen::Vector3d kept = place_ * pivot;
  place_.scale = std::sqrt(areas);
  place_.translation += kept - place_ * pivot;
}

void AutoRegistration::Prepare() {
  unit_ = BoundingDiagonal(target_.points) / 2;
  origin_ = target_.points.colwise().mean();
  goal_points_ = (target_.points.rowwise() - origin_) / unit_;
  goals_ = landmarks_;
  AddPins(parts_, goals_);
  for (LandmarkGoal& goal : goals_) goal.target = (goal.target - origin_.transpose()) / unit_;
  surface_.emplace(goal_points_, target_.faces);
  std::vector<int> counts;
  for (int c = options_.middle_vertices; c < 0.7 * source_.vertex_count(); c *= 4)
    counts.insert(counts.begin(), c);
  if (options_.coarse_vertices < 0.7 * source_.vertex_count())
    counts.push_back(options_.coarse_vertices);
  const PointsX3 rest = (Transformed(place_, source_.points).rowwise() - origin_) / unit_;
  const double smoothing = 2 * options_.smoothing;
  levels_.emplace(rest, source_.faces, counts, stiffness_, smoothing * smoothing, goals_);
  middle_ = levels_->count() - 1;
  while (middle_ > 0 &&
         (*levels_)[middle_].rest.rows() < kMiddleOfCoarse * options_.middle_vertices)
    --middle_;
  result_.levels = levels_->count();
}

Mesh ProxyOf(const PointsX3& points, const FacesX3& faces) {
  Mesh proxy;
  proxy.points = points;
  proxy.faces = faces;
  if (proxy.vertex_count() <= 1.5 * kProxyVertices) return proxy;
  const std::vector<CoarseLevel> decimated = MakeHierarchy(points, faces, {kProxyVertices});
  if (decimated.empty()) return proxy;
  proxy.points = decimated[0].points;
  proxy.faces = decimated[0].faces;
  return proxy;
}

void AutoRegistration::MeasureDistances() {
  if (!parts_.empty() || SizeOf(goals_) < kFewestForDistances) return;
  // Distances need no more detail than the levels that use them, so proxies are enough.
  int at = 0;
  while (at < middle_ && (*levels_)[at].rest.rows() > kProxyVertices * 1.5) ++at;
  const Mesh proxy = ProxyOf(goal_points_, target_.faces);
  std::vector<int> from, to;
  for (const Mark& mark : (*levels_)[at].marks) {
    from.push_back(mark.vertex);
    Eigen::Index nearest = 0;
    (proxy.points.rowwise() - mark.target.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    to.push_back(static_cast<int>(nearest));
  }
  const Level& level = (*levels_)[at];
  LandmarkCoordinates coordinates(level.rest, level.faces, from, proxy.points, proxy.faces, to);
  // When a part of the target is cut off, its area is too small, but distances between landmarks
  // are right. When it only has holes, the discs replace the lost area, and both agree.
  if (const double growth = coordinates.Growth();
      more_open_ > Tuning::kCutShare && growth > Tuning::kCutGrowth) {
    first_scale_ = growth;
    coordinates.GrowSource(growth);
  }
  proxy_points_ = proxy.points;
  std::vector<int> index(source_.vertex_count(), -1);
  for (std::size_t k = 0; k < level.fine.size(); ++k) index[level.fine[k]] = static_cast<int>(k);
  const int levels[2] = {levels_->count() - 1, middle_};
  for (int k = 0; k < 2; ++k) {
    std::vector<int> vertices;
    for (int v : (*levels_)[levels[k]].fine) vertices.push_back(index[v]);
    if (k == 0 || levels[1] != levels[0])
      distance_matches_[k] = coordinates.MatchVertices(vertices);
  }
}

void AutoRegistration::SetRestScale(double scale) {
  levels_->ScaleRest(scale / rest_scale_);
  rest_scale_ = scale;
}

void AutoRegistration::Reset(Level& level) {
  SetRestScale(first_scale_);
  level.moved = level.rest;
  level.fit->SetMaps(std::vector<Eigen::Matrix3d>(level.rest.rows(), Eigen::Matrix3d::Identity()));
  level.fit->SetRigidity(kRigid);
}

AutoRegistration::Attempt AutoRegistration::BendCoarse(Start start, StartTrial trial) {
  Level& level = coarse();
  level.moved = start.moved;
  level.fit->SetMaps(start.maps);
  level.fit->SetRigidity(start.rigidity);
  SetRestScale(first_scale_);
  level.matches = start.matches[0];
  const SurfaceGap gap = RunRounds(levels_->count() - 1, kCoarse, 0, start.match_points);
  trial.gap = (gap.forward + gap.backward) / 4;
  trial.strain = level.fit->Strain(level.moved).dot(level.fit->vertex_areas()) /
                 level.fit->vertex_areas().sum();
  trial.score =
      trial.gap + Tuning::kStrainWeight * trial.strain + Tuning::kRejectedWeight * gap.rejected;
  start.moved = level.moved;
  start.maps = level.fit->maps();
  start.scale = rest_scale_;
  return {std::move(start), std::move(trial)};
}

AutoRegistration::Attempt AutoRegistration::Unusable(StartTrial trial) {
  trial.score = trial.gap = 1;
  return {std::nullopt, std::move(trial)};
}

/// Keeps the attempt's start if it is the best so far. Its trial is always kept.
void AutoRegistration::Compete(Attempt attempt) {
  const bool better = !best_ || attempt.trial.score < result_.starts[result_.chosen].score;
  if (attempt.start && better) {
    best_ = std::move(attempt.start);
    result_.chosen = SizeOf(result_.starts);
  }
  result_.starts.push_back(std::move(attempt.trial));
}

AutoRegistration::Attempt AutoRegistration::FromLandmarks(double rigidity,
                                                          const std::string& name) {
  Level& level = coarse();
  Reset(level);
  Start start;
  start.rigidity = rigidity;
  start.match_points = &proxy_points_;
  if (!goals_.empty()) FitToLandmarks(level, options_.landmark_weight);
  if (!distance_matches_[0].empty()) {
    level.matches = distance_matches_[0];
    FitToMatches(level, proxy_points_, options_.landmark_weight);
    for (int k = 0; k < 2; ++k) start.matches[k] = distance_matches_[k];
  }
  start.moved = level.moved;
  start.maps = level.fit->maps();
  return BendCoarse(std::move(start), {.name = name});
}

AutoRegistration::Attempt AutoRegistration::FromIntrinsicMap(double rigidity,
                                                             const std::string& name) {
  if (!suggestion_) suggestion_ = SuggestLandmarks(source_, target_, landmarks_, {});
  const Suggestion& suggestion = *suggestion_;
  StartTrial trial{.name = name, .words = suggestion.explanation};
  int known = 0;
  for (int v : suggestion.dense) known += v >= 0;
  if (known < source_.vertex_count() / 4) {
    trial.words = "not usable: " + trial.words;
    return Unusable(std::move(trial));
  }
  Start start;
  start.rigidity = rigidity;
  start.match_points = &goal_points_;
  const int levels[2] = {levels_->count() - 1, middle_};
  for (int k = 0; k < 2; ++k)
    for (int v : (*levels_)[levels[k]].fine)
      start.matches[k].push_back(
          {suggestion.dense[v], Tuning::kDoubt * (1 - suggestion.confidence[v])});
  Level& level = coarse();
  Reset(level);
  level.matches = start.matches[0];
  FitToMatches(level, goal_points_, options_.landmark_weight);
  start.moved = level.moved;
  start.maps = level.fit->maps();
  return BendCoarse(std::move(start), std::move(trial));
}

AutoRegistration::Attempt AutoRegistration::FromSkeleton() {
  const SkeletonStart skeleton =
      StartFromSkeletons(source_, target_, landmarks_, place_, {}, progress_);
  StartTrial trial{.name = "skeleton", .words = skeleton.words};
  if (!skeleton.usable()) return Unusable(std::move(trial));
  Level& level = coarse();
  Reset(level);
  for (std::size_t k = 0; k < level.fine.size(); ++k)
    level.moved.row(k) = (skeleton.points.row(level.fine[k]) - origin_) / unit_;
  for (int k = 0; k < 10; ++k) level.fit->FitMaps(level.moved);
  Start start;
  start.moved = level.moved;
  start.maps = level.fit->maps();
  return BendCoarse(std::move(start), std::move(trial));
}

void AutoRegistration::TryStarts() {
  if (!parts_.empty()) return Compete(FromLandmarks(kRigid, "unmoved part"));
  const auto poor = [&] { return result_.starts[result_.chosen].gap > options_.poor_fit; };
  Compete(FromLandmarks(kRigid, landmarks_.empty() ? "as aligned" : "landmarks"));
  ReportProgress(progress_, 0.4, "start");
  if (options_.suggest && SizeOf(goals_) < kFewestForDistances)
    Compete(FromIntrinsicMap(kRigid, "intrinsic map"));
  ReportProgress(progress_, 0.5, "start");
  if (options_.skeleton && SizeOf(goals_) < kFewestForDistances && poor()) Compete(FromSkeleton());
  ReportProgress(progress_, 0.55, "start");
  if (poor() && !goals_.empty()) Compete(FromLandmarks(Tuning::kSofter, "landmarks, softer"));
  if (!goals_.empty() && options_.suggest &&
      result_.starts[result_.chosen].gap > Tuning::kHopeless * options_.poor_fit)
    Compete(FromIntrinsicMap(Tuning::kSofter, "intrinsic map, softer"));
}

SurfaceGap AutoRegistration::RunRounds(int at, const Schedule& schedule, int rounds_before,
                                       const PointsX3* match_points) {
  Level& level = (*levels_)[at];
  SurfaceGap gap;
  Momentum momentum(level);
  for (int k = 0; k < schedule.rounds; ++k) {
    const double all = static_cast<double>(rounds_before + k) / (kAllRounds - 1);
    // The first schedule begins at its first stiffness. A later one begins one step below, because
    // the schedule before ended at its first stiffness.
    const double own = rounds_before == 0 ? static_cast<double>(k) / (schedule.rounds - 1)
                                          : static_cast<double>(k + 1) / schedule.rounds;
    FitTerms terms;
    terms.stiffness = Between(schedule.from, schedule.to, own);
    terms.robust = Between(Tuning::kRobustFirst, Tuning::kRobustLast, all);
    terms.landmarks = Between(options_.landmark_weight, options_.landmark_weight_end, all);
    terms.matches = level.matches.empty() || !match_points
                        ? 0
                        : Tuning::kMatchesFirst * std::pow(Tuning::kMatchesFall, rounds_before + k);
    terms.turns = schedule.turns;
    terms.samples = at == middle_ ? kSamples : kCoarseSamples;
    for (int i = 0; i < schedule.searches; ++i) {
      if (!level.fit->rigid()) momentum.CarryOn(level);
      terms.measure = k + 1 == schedule.rounds && i + 1 == schedule.searches;
      gap = FitToSurface(level, *surface_, match_points ? *match_points : goal_points_, terms,
                         momentum.seen());
    }
    // Noise and ragged holes change the areas, so the first scale is not exact; refine it. Parts
    // that were found give it exactly.
    const bool refine = parts_.empty();
    if (refine && level.fit->pieces().area_share() > Tuning::kPiecesDecide)
      SetRestScale(rest_scale_ * level.growth);
    else if (refine && level.fit->rigid())
      SetRestScale(rest_scale_ * level.fit->BestScale(level.moved));
    ReportProgress(progress_, 0.6 + 0.2 * all, "bending");
  }
  return gap;
}

void AutoRegistration::Finish() {
  const int last = levels_->count() - 1;
  SetRestScale(best_->scale);
  coarse().moved = best_->moved;
  coarse().fit->SetMaps(best_->maps);
  for (int l = last; l > middle_; --l) levels_->Descend(l);
  Level& level = (*levels_)[middle_];
  level.matches = best_->matches[middle_ == last ? 0 : 1];
  level.fit->SetRigidity(best_->rigidity);
  SurfaceGap gap = RunRounds(middle_, kMiddle, kCoarse.rounds, best_->match_points);
  result_.softened =
      best_->rigidity < kRigid || (gap.forward + gap.backward) / 4 > options_.good_fit;
  if (result_.softened) {
    level.fit->SetRigidity(Tuning::kSoft);
    gap = RunRounds(middle_, kSoftened, kCoarse.rounds + kMiddle.rounds, best_->match_points);
  } else {
    gap = RunRounds(middle_, kSettled, kCoarse.rounds + kMiddle.rounds, best_->match_points);
  }
  FitTerms terms;
  terms.stiffness = result_.softened ? kSoftened.to : Tuning::kFineStiffness;
  terms.robust = Tuning::kRobustLast;
  terms.landmarks = options_.landmark_weight_end;
  terms.samples = kSamples;
  for (int l = middle_; l-- > 0;) {
    levels_->Descend(l + 1);
    Level& finer = (*levels_)[l];
    if (result_.softened) finer.fit->SetRigidity(Tuning::kSoft);
    const int searches = finer.rest.rows() > kLargeLevel ? 2 : 4;
    Momentum momentum(finer);
    for (int k = 0; k < searches; ++k) {
      momentum.CarryOn(finer);
      terms.measure = k + 1 == searches;
      gap = FitToSurface(finer, *surface_, goal_points_, terms, momentum.seen());
    }
    ReportProgress(progress_, 0.95 - 0.15 * l / std::max(1, middle_), "fine detail");
  }
  result_.gap = (gap.forward + gap.backward) / 4;
}

AutoResult AutoRegistration::Run() {
  ReportProgress(progress_, 0, "alignment");
  Align();
  ReportProgress(progress_, 0.1, "levels of detail");
  Prepare();
  ReportProgress(progress_, 0.3, "distances to landmarks");
  MeasureDistances();
  TryStarts();
  Finish();
  const Level& level = (*levels_)[0];
  result_.points = Back(level.moved);
  result_.scale = place_.scale * rest_scale_;
  const Eigen::Matrix3d linear = result_.scale * place_.rotation;
  for (const Eigen::Matrix3d& map : level.fit->maps()) result_.transforms.push_back(map * linear);
  return std::move(result_);
}

/// Registers again from the parts that moved as rigid bodies, if `result` has left the first: with
/// all of them or, where that does not reach the target, with the first alone.
void FromRigidParts(const Mesh& source, const Mesh& target,
                    const std::vector<LandmarkGoal>& landmarks, const Eigen::VectorXd& stiffness,
                    const AutoOptions& options, Progress* progress, AutoResult& result) {
  if (SizeOf(landmarks) >= kFewestForDistances) return;
  const double diagonal = BoundingDiagonal(target.points);
  std::vector<RigidPart> parts = FindRigidParts(source, target, result.points);
  if (parts.empty() || ShareInPlace(parts[0], source, result.points, diagonal) > kStaysInPlace)
    return;
  if (Contradict(landmarks, parts, source.points, diagonal)) return;
  AutoOptions pinned = options;
  pinned.landmark_weight = pinned.landmark_weight_end = kPinWeight;
  const double farthest = std::max(kFurther * result.gap, options.good_fit);
  for (bool more = true; more; parts.resize(1)) {
    more = parts.size() > 1;
    const Eigen::VectorXd stiff = Stiffened(stiffness, source.points.rows(), parts);
    AutoResult again =
        AutoRegistration(source, target, landmarks, stiff, pinned, parts, progress).Run();
    result.starts.push_back(again.starts[0]);
    if (again.gap > farthest ||
        ShareInPlace(parts[0], source, again.points, diagonal) < kStaysInPlace)
      continue;
    again.chosen = SizeOf(result.starts) - 1;
    again.starts = std::move(result.starts);
    again.rigid_parts = SizeOf(parts);
    again.unmoved_share = parts[0].share;
    result = std::move(again);
    return;
  }
}

}  // namespace

std::vector<std::string> AutoOptions::Problems() const {
  std::vector<std::string> problems;
  if (coarse_vertices > middle_vertices)
    problems.push_back("coarse_vertices must not be above middle_vertices");
  if (good_fit > poor_fit) problems.push_back("good_fit must not be above poor_fit");
  return problems;
}

AutoResult RegisterSurface(const Mesh& source, const Mesh& target,
                           const std::vector<LandmarkGoal>& landmarks,
                           const Eigen::VectorXd& stiffness, const AutoOptions& options,
                           Progress* progress) {
  SubProgress first(progress, 0, kFirstRun), second(progress, kFirstRun, 1);
  AutoResult result =
      AutoRegistration(source, target, landmarks, stiffness, options, {}, &first).Run();
  FromRigidParts(source, target, landmarks, stiffness, options, &second, result);
  return result;
}

}  // namespace keypose::registration
