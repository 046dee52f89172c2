#include "fit/bending/bend.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/levels/geodesics.h"
#include "deform/levels/levels.h"
#include "fit/bending/bend_evidence.h"
#include "fit/bending/joint_solve.h"
#include "fit/bending/schedule.h"
#include "fit/bending/unfold.h"
#include "fit/limbs/limb_search.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth). Lengths are in units of half the diagonal.
struct BendTuning {
  // A pick farther off than this, after the far rounds, contradicts what the views say.
  KEYPOSE_TUNED(double, kMostOff, 0.1);
};

constexpr int kSolverSteps = 10;
constexpr double kLimbRadius = 80;          // half the figure's diagonal where limbs are drawn [px]
constexpr Eigen::Index kMostJointly = 800;  // vertices of a level solved together with the cameras

class Bending {
 public:
  Bending(const Mesh& mesh, const Image8& texture, const Eigen::VectorXd& stiffness,
          const std::vector<BendView>& views, const BendPicks& marks, const BendOptions& options,
          Progress* progress)
      : colors_(texture.empty() ? Eigen::MatrixX3f() : VertexColors(mesh, texture)),
        texture_(mesh, texture),
        views_(views),
        options_(options),
        progress_(progress),
        rest_{mesh},
        stiffness_(stiffness) {
    Prepare(marks);
  }
  BendResult Run();

 private:
  void Prepare(const BendPicks& marks);
  void MakeLevels();
  PointsX3 FullPoints(int level);
  int LevelOf(int wanted) const { return std::min(wanted, levels_->count() - 1); }
  void RunRounds(const std::vector<Round>& rounds);
  void RunRound(const Round& round);
  void RunFar();
  void TurnLimbsRight();
  void HoldLimbs(const Round& round, std::vector<Constraint>& constraints) const;
  std::vector<FitView> FullViews() const;
  void Solve(int level, const std::vector<Constraint>& constraints, int turns);
  void KeepSize(int level);
  const std::vector<int>& CoarseOf(int level);
  void KeepPlace(PointsX3& points);
  BendResult Finish();

  const FacesX3& faces() const { return rest_.mesh.faces; }

  Eigen::MatrixX3f colors_;  // of the vertices
  SurfaceTexture texture_;
  const std::vector<BendView>& views_;
  const BendOptions& options_;
  Progress* progress_;

  Eigen::RowVector3d origin_ = Eigen::RowVector3d::Zero();
  double unit_ = 1;
  RestShape rest_;
  Eigen::VectorXd stiffness_;
  std::optional<Levels> levels_;
  std::map<int, std::vector<int>> coarse_of_;  // by level: the level's vertex of each fine vertex
  std::vector<Rigid3> poses_, first_poses_;    // in the frame of the rest shape
  std::optional<ViewEvidence> evidence_;
  std::vector<BendEvidence> last_;
  std::optional<PickConstraints> marks_;
  std::vector<std::pair<int, Eigen::Vector3d>> turned_;  // vertices of limbs, and where they belong
  int limbs_turned_ = 0;
  int at_ = 0;                 // the level in use
  int rounds_ = 1, done_ = 0;  // all, and those that were run
};

void Bending::Prepare(const BendPicks& marks) {
  if (views_.empty()) throw InputError("fit: no views");
  const PointsX3& points = rest_.mesh.points;
  unit_ = BoundingDiagonal(points) / 2;
  origin_ = points.colwise().mean();
  rest_.points = (points.rowwise() - origin_) / unit_;
  rest_.area = SurfaceArea(rest_.points, faces());
  rest_.pairs = FindFacePairs(faces());
  for (const FacePairs::Pair& pair : rest_.pairs.pairs)
    rest_.edge +=
        (rest_.points.row(pair.a) - rest_.points.row(pair.b)).norm() / SizeOf(rest_.pairs.pairs);
  MakeLevels();
  rest_.vertex_areas = (*levels_)[0].fit->vertex_areas();
  rest_.vertex_areas /= rest_.vertex_areas.sum();
  rest_.cell_of = CoarseOf(LevelOf(2));
  rest_.of_middle.assign(rest_.points.rows(), 0);
  for (const int v : (*levels_)[LevelOf(1)].fine) rest_.of_middle[v] = 1;
  for (const BendView& view : views_) {
    const Rigid3& pose = view.view.camera_from_world;
    poses_.push_back(
        {pose.rotation, (pose.rotation * origin_.transpose() + pose.translation) / unit_});
  }
  first_poses_ = poses_;
  evidence_.emplace(rest_, texture_, views_, options_, first_poses_);
  BendPicks placed = marks;
  for (LandmarkGoal& goal : placed.places)
    goal.target = (goal.target - origin_.transpose()) / unit_;
  marks_.emplace(std::move(placed), rest_.points, rest_.cell_of);
}

void Bending::MakeLevels() {
  std::vector<int> counts;
  for (const int count : {options_.middle_vertices, options_.coarse_vertices})
    if (count < 0.7 * rest_.mesh.vertex_count()) counts.push_back(count);
  const double smoothing = 2 * options_.smoothing;
  levels_.emplace(rest_.points, faces(), counts, stiffness_, smoothing * smoothing,
                  std::vector<LandmarkGoal>());
}

const std::vector<int>& Bending::CoarseOf(int level) {
  std::vector<int>& of = coarse_of_[level];
  if (of.empty()) {
    const GeodesicGraph graph(rest_.points, faces(), GeodesicGraph::kEdgesOnly);
    graph.From((*levels_)[level].fine, &of);
  }
  return of;
}

PointsX3 Bending::FullPoints(int level) {
  for (int l = level; l > 0; --l) levels_->Descend(l);
  return (*levels_)[0].moved;
}

void Bending::Solve(int at, const std::vector<Constraint>& constraints, int turns) {
  const std::vector<int>& coarse_of = CoarseOf(at);
  Level& level = (*levels_)[at];
  const bool jointly = options_.hold_cameras == 0 && level.rest.rows() <= kMostJointly;
  constexpr double kStill = 1e-5;
  const std::vector<Rigid3> before = poses_;
  std::vector<LevelConstraint> on_level(constraints.size());
  for (int turn = 0; turn < turns; ++turn) {
    for (int i = 0; i < SizeOf(constraints); ++i) {
      const Constraint& c = constraints[i];
      const int v = coarse_of[c.vertex];
      const Eigen::Vector3d arm =
          rest_.points.row(c.vertex).transpose() + c.arm - level.rest.row(v).transpose();
      on_level[i] = {c.view, v, level.fit->maps()[v] * arm, c.q, c.goal};
    }
    Pulls pulls(level.rest.rows());
    for (const LevelConstraint& c : on_level) {
      if (jointly && c.view >= 0) continue;
      pulls.q[c.vertex] += c.q;
      pulls.b.row(c.vertex) += (c.q * (c.goal - c.arm)).transpose();
    }
    PointsX3 next;
    if (jointly) {
      poses_ = before;  // constraints are linear about these
      next = SolveJointly(*level.fit, level.moved, on_level, pulls, 0.01, poses_);
    } else {
      if (turn == 0) level.fit->SetWeights(pulls.MeanWeights());
      next = level.fit->FitPositions(pulls, level.moved, kSolverSteps);
    }
    const double move = std::sqrt((next - level.moved).rowwise().squaredNorm().maxCoeff());
    level.moved = std::move(next);
    level.fit->FitMaps(level.moved);
    if (move < kStill) break;
  }
}

/// Pictures do not tell how large and how far away a figure is, and errors are smaller on a smaller
/// one. So figure and cameras are scaled together to the template's size.
void Bending::KeepSize(int at) {
  Level& level = (*levels_)[at];
  const double size = level.fit->BestScale(level.moved);
  level.moved /= size;
  for (Rigid3& pose : poses_) pose.translation /= size;
}

void Bending::RunRound(const Round& round) {
  const int level = LevelOf(round.level);
  const BentShape shape(FullPoints(level), faces(), round.outlines > 0 || round.appearance > 0);
  last_.assign(views_.size(), {});
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    last_[v] = evidence_->Of(static_cast<int>(v), round, shape, poses_[v], *marks_);
  });
  std::vector<Constraint> all;
  for (int v = 0; v < SizeOf(views_); ++v) {
    poses_[v] = last_[v].pose;
    all.insert(all.end(), last_[v].constraints.begin(), last_[v].constraints.end());
  }
  marks_->AddPlaces(shape.points, MarkWeight(round, options_), MarkScale(round), all);
  HoldLimbs(round, all);
  Solve(level, all, round.turns);
  if (options_.hold_cameras == 0) KeepSize(level);
}

/// Rotates and shifts figure and cameras together to where the template stands: pictures do not
/// tell where that is.
void Bending::KeepPlace(PointsX3& points) {
  const Similarity3 back = FitSimilarity(points, rest_.points, rest_.vertex_areas, false);
  points = Transformed(back, points);
  const Rigid3 now_from_place{Eigen::Quaterniond(back.rotation.transpose()),
                              -(back.rotation.transpose() * back.translation)};
  for (Rigid3& pose : poses_) pose = Compose(pose, now_from_place);
}

BendResult Bending::Finish() {
  BendResult result;
  PointsX3 points = FullPoints(0);
  const std::vector<Eigen::Matrix3d>& maps = (*levels_)[0].fit->maps();
  result.unfolded = Unfold(rest_.points, faces(), maps, points);
  result.flipped = FlippedFaces(rest_.points, faces(), maps, points);
  result.limbs_turned = limbs_turned_;
  if (options_.hold_cameras == 0) KeepPlace(points);
  result.marks = marks_->Quality(FullViews(), points);
  for (PickQuality& mark : result.marks) mark.off *= unit_;
  result.points = (points * unit_).rowwise() + origin_;
  result.views = Eigen::VectorXi::Zero(points.rows());
  Eigen::VectorXd doubt = Eigen::VectorXd::Ones(points.rows());
  for (int v = 0; v < SizeOf(views_); ++v) {
    const Rigid3& pose = poses_[v];
    result.cameras.push_back(
        {pose.rotation, pose.translation * unit_ - pose.rotation * origin_.transpose()});
    for (const int i : last_[v].held) ++result.views[i];
    if (last_[v].sure.size() > 0) doubt.array() *= 1 - last_[v].sure.array();
    result.view_quality.push_back(
        {evidence_->matches(v), last_[v].gap_px, last_[v].correlation, last_[v].overlap});
  }
  result.confidence = 1 - doubt.array();
  result.volume_ratio =
      SignedVolume(points, faces()) / std::max(1e-300, SignedVolume(rest_.points, faces()));
  return result;
}

std::vector<FitView> Bending::FullViews() const {
  std::vector<FitView> views;
  for (int v = 0; v < SizeOf(views_); ++v) views.push_back(evidence_->ViewAt(v, 0, poses_[v]));
  return views;
}

void Bending::RunRounds(const std::vector<Round>& rounds) {
  for (const Round& round : rounds) {
    while (at_ > LevelOf(round.level)) levels_->Descend(at_--);
    if (round.rematch > 0 && !texture_.blank())
      evidence_->MatchAgain({FullPoints(at_), faces(), true}, poses_, round.rematch);
    for (int k = 0; k < round.repeats; ++k) {
      const char* by = round.appearance > 0 ? "texture" : "features and outlines";
      ReportProgress(progress_, std::min(1.0, static_cast<double>(done_++) / rounds_),
                     texture_.blank() ? "outlines" : by);
      RunRound(round);
    }
  }
}

/// The far rounds; again from the start without picks that contradict the rest, which would leave
/// the shape bent.
void Bending::RunFar() {
  std::vector<Round> rounds = FarRounds(options_.hold_cameras > 0);
  // A few picks alone would draw the whole figure along.
  if (texture_.blank() && options_.hold_cameras > 0)
    std::erase_if(rounds, [](const Round& round) { return round.outlines == 0; });
  constexpr int kMostTries = 4;
  for (int attempt = 1;; ++attempt) {
    at_ = LevelOf(rounds.front().level);
    RunRounds(rounds);
    if (marks_->count() == 0 || attempt == kMostTries) return;
    if (!marks_->Refuse(FullViews(), FullPoints(at_), BendTuning::kMostOff)) return;
    MakeLevels();
    poses_ = first_poses_;
  }
}

/// A limb that turned about itself shows another side, so features do not find it, and outlines
/// draw it to a wrong place near by.
void Bending::TurnLimbsRight() {
  std::vector<SmallPicture> pictures;
  for (int v = 0; v < SizeOf(views_); ++v)
    pictures.push_back(MakeSmallPicture(views_[v].view, poses_[v], kLimbRadius));
  const double done = static_cast<double>(done_) / rounds_;
  SubProgress standing(progress_, done, done);
  const TurnedLimbs found =
      TurnLimbs(rest_.points, faces(), colors_, pictures, FullPoints(at_), &standing);
  limbs_turned_ = found.count;
  if (found.count == 0) return;
  Level& level = (*levels_)[at_];
  level.moved = found.points(level.fine, Eigen::all);
  level.fit->FitMaps(level.moved);
  evidence_->HoldNear(found.turned);
  for (int v = 0; v < SizeOf(found.turned); ++v)
    if (found.turned[v]) turned_.emplace_back(v, found.points.row(v).transpose());
}

/// Grey values of the coarse rounds would draw a limb away from where it was turned to.
void Bending::HoldLimbs(const Round& round, std::vector<Constraint>& constraints) const {
  const double weight = round.limbs * SurfaceWeight(round) / SizeOf(rest_.cell_of);
  if (weight > 0)
    for (const auto& [vertex, place] : turned_)
      constraints.push_back(
          {-1, vertex, Eigen::Vector3d::Zero(), weight * Eigen::Matrix3d::Identity(), place});
}

BendResult Bending::Run() {
  const std::vector<Round> near = texture_.blank() ? UntexturedRounds() : NearRounds();
  rounds_ = 0;
  for (const auto& rounds : {FarRounds(options_.hold_cameras > 0), near})
    for (const Round& round : rounds) rounds_ += round.repeats;
  RunFar();
  if (options_.only_far) return Finish();
  if (!texture_.blank()) TurnLimbsRight();
  RunRounds(near);
  return Finish();
}

}  // namespace

BendResult BendToViews(const Mesh& mesh, const Image8& texture, const Eigen::VectorXd& stiffness,
                       const std::vector<BendView>& views, const BendPicks& marks,
                       const BendOptions& options, Progress* progress) {
  return Bending(mesh, texture, stiffness, views, marks, options, progress).Run();
}

}  // namespace keypose::fit
