#include "fit/bending/bend.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "core/tuned.h"
#include "deform/levels/geodesics.h"
#include "deform/levels/levels.h"
#include "fit/bending/constraints.h"
#include "fit/bending/feature_filter.h"
#include "fit/bending/joint_solve.h"
#include "fit/bending/nearby_matches.h"
#include "fit/bending/patch_matches.h"
#include "fit/bending/schedule.h"
#include "fit/bending/unfold.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth). Lengths are in units of half the diagonal.
struct BendTuning {
  // Weight of the whole surface at stiffness 1, when every vertex is held by one view.
  KEYPOSE_TUNED(double, kSurfaceWeight, 1700);
  // Matches in one cell of the coarse level from which on they have the cell's whole weight.
  KEYPOSE_TUNED(double, kMatchesForAll, 4);
  KEYPOSE_TUNED(double, kOutlineWeight, 3);  // of outlines, relative to a vertex held by texture
  // A pick farther off than this, after the far rounds, contradicts what the views say.
  KEYPOSE_TUNED(double, kMostOff, 0.1);
  KEYPOSE_TUNED(double, kLeastFacing, 0.25);  // cosine at which a vertex is compared
};

constexpr int kSolverSteps = 10, kPhotoFeatures = 4000;
constexpr Eigen::Index kMostJointly = 800;  // vertices of a level solved together with the cameras
// From this hold on, cameras stay.
constexpr double kFixedCameras = 1e3;

/// What one view gives in one round.
struct Evidence {
  std::vector<Constraint> constraints;
  std::vector<int> held;  // vertices with a patch
  Eigen::VectorXd sure;   // V, confidence of the patch
  Rigid3 pose;
  double gap_px = 0, correlation = 0;
  double overlap = 0;  // of the render with the mask: intersection over union
};

class Bending {
 public:
  Bending(const Mesh& mesh, const Image8& texture, const Eigen::VectorXd& stiffness,
          const std::vector<BendView>& views, const BendMarks& marks, const BendOptions& options,
          Progress* progress)
      : mesh_(mesh),
        texture_(mesh, texture),
        views_(views),
        options_(options),
        progress_(progress) {
    Prepare(stiffness, marks);
  }
  BendResult Run();

 private:
  using Tuning = BendTuning;
  struct Picture {
    GreyPyramid grey;
    std::vector<Outline> outlines;  // by pyramid level
    PictureFeatures features;
    std::vector<FeatureMatch> matches;  // that can be true together
    double noise = 1;
  };

  void Prepare(const Eigen::VectorXd& stiffness, const BendMarks& marks);
  void MakeLevels();
  void PrepareViews();
  void MatchAgain(int level, double reach);
  std::vector<FeatureMatch> PatchMatches(int view, const PointsX3& points, const PointsX3& normals,
                                         const RayScene& scene, double reach) const;
  TexturedRender RenderIn(const FitView& view, const PointsX3& points, const RayScene& scene) const;
  PointsX3 FullPoints(int level);
  int LevelOf(int wanted) const { return std::min(wanted, levels_->count() - 1); }
  FitView ViewAt(int view, int pyramid) const;
  void RunRounds(const std::vector<Round>& rounds);
  void RunRound(const Round& round);
  void RunFar();
  std::vector<FitView> FullViews() const;
  Evidence EvidenceOf(int view, const Round& round, const PointsX3& points, const PointsX3& normals,
                      const RayScene* scene) const;
  void AddFeatures(int view, const Round& round, const PointsX3& points, Evidence& evidence) const;
  void AddAppearance(int view, const Round& round, const PointsX3& points, const PointsX3& normals,
                     const RayScene& scene, Evidence& evidence) const;
  void Solve(int level, const std::vector<Constraint>& constraints, int turns);
  void KeepSize(int level);
  const std::vector<int>& CoarseOf(int level);
  double MarkWeight(const Round& round) const {
    return round.marks * SurfaceWeight(round) / options_.coarse_vertices;
  }
  double SurfaceWeight(const Round& round) const {
    return Tuning::kSurfaceWeight / round.stiffness;
  }
  void KeepPlace(PointsX3& points);
  BendResult Finish();

  const Mesh& mesh_;
  SurfaceTexture texture_;
  const std::vector<BendView>& views_;
  const BendOptions& options_;
  Progress* progress_;

  Eigen::RowVector3d origin_ = Eigen::RowVector3d::Zero();
  double unit_ = 1;
  PointsX3 rest_;          // normalised
  Eigen::VectorXd areas_;  // of the vertices, over the whole area
  double area_ = 0, edge_ = 0;
  FacePairs pairs_;
  std::optional<Levels> levels_;
  std::map<int, std::vector<int>> coarse_of_;  // by level: the level's vertex of each fine vertex
  std::vector<Picture> pictures_;
  std::vector<Rigid3> poses_, first_poses_;  // normalised
  std::vector<Evidence> last_;
  std::optional<Marks> marks_;
  Eigen::VectorXd stiffness_;
  std::vector<char> of_middle_;  // for each vertex, whether the middle level has it
  int at_ = 0;                   // the level in use
  int rounds_ = 1, done_ = 0;    // all, and those that were run
};

void Bending::Prepare(const Eigen::VectorXd& stiffness, const BendMarks& marks) {
  if (views_.empty()) throw InputError("fit: no views");
  unit_ = BoundingDiagonal(mesh_.points) / 2;
  origin_ = mesh_.points.colwise().mean();
  rest_ = (mesh_.points.rowwise() - origin_) / unit_;
  area_ = SurfaceArea(rest_, mesh_.faces);
  pairs_ = FindFacePairs(mesh_.faces);
  for (const FacePairs::Pair& pair : pairs_.pairs)
    edge_ += (rest_.row(pair.a) - rest_.row(pair.b)).norm() / SizeOf(pairs_.pairs);
  stiffness_ = stiffness;
  MakeLevels();
  areas_ = (*levels_)[0].fit->vertex_areas();
  areas_ /= areas_.sum();
  PrepareViews();
  BendMarks placed = marks;
  for (LandmarkGoal& goal : placed.places)
    goal.target = (goal.target - origin_.transpose()) / unit_;
  marks_.emplace(std::move(placed), rest_, CoarseOf(LevelOf(2)));
}

void Bending::MakeLevels() {
  std::vector<int> counts;
  for (const int count : {options_.middle_vertices, options_.coarse_vertices})
    if (count < 0.7 * mesh_.vertex_count()) counts.push_back(count);
  const double smoothing = 2 * options_.smoothing;
  levels_.emplace(rest_, mesh_.faces, counts, stiffness_, smoothing * smoothing,
                  std::vector<LandmarkGoal>());
  of_middle_.assign(rest_.rows(), 0);
  for (const int v : (*levels_)[LevelOf(1)].fine) of_middle_[v] = 1;
}

void Bending::PrepareViews() {
  pictures_.resize(views_.size());
  for (const BendView& view : views_) {
    const Rigid3& pose = view.view.camera_from_world;
    poses_.push_back(
        {pose.rotation, (pose.rotation * origin_.transpose() + pose.translation) / unit_});
  }
  first_poses_ = poses_;
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    const PreparedView& view = views_[v].view;
    Picture& picture = pictures_[v];
    picture.grey = MakeGreyPyramid(view.color, SizeOf(view.levels));
    for (int level = 0; level < SizeOf(view.levels); ++level)
      picture.outlines.push_back(MakeOutline(view, level));
    picture.features = FindFeatures(view.color, MaskOf(view), kPhotoFeatures);
    picture.noise = std::max(view.noise, 0.5);
    for (const int i :
         ConsistentMatches(rest_, views_[v].matches, view.camera(), poses_[v].translation.norm()))
      picture.matches.push_back(views_[v].matches[i]);
  });
}

/// Looks for features again, now that the mesh is near, and takes them in place of the first ones.
void Bending::MatchAgain(int level, double reach) {
  if (texture_.blank()) return;
  const PointsX3 points = FullPoints(level), normals = VertexNormals(points, mesh_.faces);
  const RayScene scene(points, mesh_.faces);
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    const FitView at = ViewAt(static_cast<int>(v), 0);
    const double reach_px = reach * at.camera.fx / at.camera_from_world.translation.norm();
    std::vector<FeatureMatch> found = MatchNearby(mesh_.faces, scene, RenderIn(at, points, scene),
                                                  at, pictures_[v].features, reach_px);
    const std::vector<FeatureMatch> patches =
        PatchMatches(static_cast<int>(v), points, normals, scene, reach);
    found.insert(found.end(), patches.begin(), patches.end());
    pictures_[v].matches = NearbyMatches(rest_, points, found, at.camera, at.camera_from_world);
  });
}

/// Those of the middle level's vertices.
std::vector<FeatureMatch> Bending::PatchMatches(int view, const PointsX3& points,
                                                const PointsX3& normals, const RayScene& scene,
                                                double reach) const {
  constexpr int kFine = 1, kCoarse = 2;  // half of it: patches are found there first
  if (SizeOf(views_[view].view.levels) <= kCoarse) return {};
  const auto at = [&](int level) {
    const FitView shown = ViewAt(view, level);
    return PatchView{shown, RenderIn(shown, points, scene), pictures_[view].grey[level],
                     views_[view].view.levels[level].grey};
  };
  const PatchView fine = at(kFine), coarse = at(kCoarse);
  std::vector<SeenVertex> seen;
  for (const SeenVertex& one : SeenVertices(points, normals, fine.render, fine.view.camera,
                                            fine.view.camera_from_world, Tuning::kLeastFacing))
    if (of_middle_[one.vertex]) seen.push_back(one);
  return MatchPatches(seen, points, fine, coarse, views_[view].view.camera(), reach);
}

TexturedRender Bending::RenderIn(const FitView& view, const PointsX3& points,
                                 const RayScene& scene) const {
  const double footprint = view.camera_from_world.translation.norm() / view.camera.fx;
  return RenderGrey(points, mesh_.faces, texture_, texture_.LevelFor(area_, footprint), scene,
                    view.camera, view.camera_from_world);
}

const std::vector<int>& Bending::CoarseOf(int level) {
  std::vector<int>& of = coarse_of_[level];
  if (of.empty()) {
    const GeodesicGraph graph(rest_, mesh_.faces, GeodesicGraph::kEdgesOnly);
    graph.From((*levels_)[level].fine, &of);
  }
  return of;
}

PointsX3 Bending::FullPoints(int level) {
  for (int l = level; l > 0; --l) levels_->Descend(l);
  return (*levels_)[0].moved;
}

FitView Bending::ViewAt(int view, int pyramid) const {
  const PreparedView& prepared = views_[view].view;
  const int level = std::min(pyramid, SizeOf(prepared.levels) - 1);
  return {view, prepared.camera(level), poses_[view]};
}

void Bending::AddFeatures(int view, const Round& round, const PointsX3& points,
                          Evidence& evidence) const {
  const FitView at = ViewAt(view, 0);
  const std::vector<int>& cell = coarse_of_.at(LevelOf(2));
  std::map<int, int> in_cell;
  for (const FeatureMatch& match : pictures_[view].matches)
    ++in_cell[cell[match.point.vertices[0]]];
  const double cells = static_cast<double>(std::max<std::size_t>(in_cell.size(), 1));
  const double weight =
      round.features * SurfaceWeight(round) / std::max<double>(options_.coarse_vertices, cells);
  for (const FeatureMatch& match : pictures_[view].matches) {
    int corner = 0;
    match.point.weights.maxCoeff(&corner);
    const int vertex = match.point.vertices[corner];
    const Eigen::Vector3d arm = PositionOf(match.point, rest_) - rest_.row(vertex).transpose();
    const int others = in_cell[cell[match.point.vertices[0]]];
    const double w = weight / std::max<double>(others, Tuning::kMatchesForAll);
    evidence.constraints.push_back(
        PullToPixel(at, vertex, arm, PositionOf(match.point, points), match.pixel, w, round.scale));
  }
}

void Bending::AddAppearance(int view, const Round& round, const PointsX3& points,
                            const PointsX3& normals, const RayScene& scene,
                            Evidence& evidence) const {
  FitView at = ViewAt(view, round.pyramid);
  const int level = std::min(round.pyramid, SizeOf(views_[view].view.levels) - 1);
  const TexturedRender render = RenderIn(at, points, scene);
  evidence.overlap = Overlap(render, views_[view].view.levels[level].grey);
  if (texture_.blank()) return;
  const std::vector<SeenVertex> seen =
      SeenVertices(points, normals, render, at.camera, at.camera_from_world, Tuning::kLeastFacing);
  std::vector<PatchShift> shifts =
      FindShifts(seen, render, pictures_[view].grey[level], views_[view].view.levels[level].grey,
                 at.camera.fx, pictures_[view].noise, {});
  std::vector<Eigen::Vector2d> goals;
  std::vector<double> weights;
  PointsX3 places(SizeOf(seen), 3);
  int count = 0;
  evidence.sure = Eigen::VectorXd::Zero(points.rows());
  for (int i = 0; i < SizeOf(seen); ++i) {
    if (!shifts[i].found) continue;
    places.row(count++) = points.row(seen[i].vertex);
    const Eigen::Vector2d goal = seen[i].pixel + shifts[i].shift;
    const Eigen::Vector2d first =
        at.camera.Project(first_poses_[view] * points.row(seen[i].vertex).transpose());
    goals.push_back((goal + options_.hold_cameras * first) / (1 + options_.hold_cameras));
    weights.push_back(shifts[i].confidence.trace() * areas_[seen[i].vertex]);
    evidence.held.push_back(seen[i].vertex);
    evidence.sure[seen[i].vertex] = shifts[i].confidence.trace() / 2;
    evidence.correlation += shifts[i].correlation;
  }
  if (count > 0) evidence.correlation /= count;
  places.conservativeResize(count, 3);
  constexpr int kLeastForPose = 50;
  if (options_.hold_cameras < kFixedCameras && count >= kLeastForPose) {
    at.camera_from_world = RefinePose(at.camera, at.camera_from_world, places, goals, weights, 2);
    evidence.pose = at.camera_from_world;
    for (int i = 0; i < SizeOf(seen); ++i)
      if (shifts[i].found)
        shifts[i].shift +=
            seen[i].pixel -
            at.camera.Project(at.camera_from_world * points.row(seen[i].vertex).transpose());
  }
  const std::vector<Constraint> found = AppearanceConstraints(
      points, seen, shifts, areas_, at, round.appearance * SurfaceWeight(round), 6);
  evidence.constraints.insert(evidence.constraints.end(), found.begin(), found.end());
}

Evidence Bending::EvidenceOf(int view, const Round& round, const PointsX3& points,
                             const PointsX3& normals, const RayScene* scene) const {
  Evidence evidence;
  evidence.pose = poses_[view];
  if (round.features > 0) AddFeatures(view, round, points, evidence);
  marks_->AddPixels(ViewAt(view, 0), points, MarkWeight(round), MarkScale(round),
                    evidence.constraints);
  if (round.outlines > 0) {
    const FitView at = ViewAt(view, round.pyramid);
    const int level = std::min(round.pyramid, SizeOf(views_[view].view.levels) - 1);
    const std::vector<ContourPoint> contour =
        FindSilhouette(points, mesh_.faces, pairs_, *scene, at.camera, at.camera_from_world);
    OutlineTerms terms;
    terms.weight = Tuning::kOutlineWeight * round.outlines * SurfaceWeight(round) /
                   static_cast<double>(rest_.rows());
    terms.edge = edge_;
    terms.scale = round.scale;
    terms.reach_px = 2 * round.scale * at.camera.fx / at.camera_from_world.translation.norm();
    const std::vector<Constraint> found = OutlineConstraints(
        points, contour, pictures_[view].outlines[level], at, terms, &evidence.gap_px);
    evidence.constraints.insert(evidence.constraints.end(), found.begin(), found.end());
  }
  if (round.appearance > 0) AddAppearance(view, round, points, normals, *scene, evidence);
  return evidence;
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
          rest_.row(c.vertex).transpose() + c.arm - level.rest.row(v).transpose();
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
  CoarseOf(LevelOf(2));
  const PointsX3 points = FullPoints(level);
  std::optional<RayScene> scene;
  PointsX3 normals;
  if (round.outlines > 0 || round.appearance > 0) {
    scene.emplace(points, mesh_.faces);
    normals = VertexNormals(points, mesh_.faces);
  }
  last_.assign(views_.size(), {});
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    last_[v] = EvidenceOf(static_cast<int>(v), round, points, normals, scene ? &*scene : nullptr);
  });
  std::vector<Constraint> all;
  for (int v = 0; v < SizeOf(views_); ++v) {
    poses_[v] = last_[v].pose;
    all.insert(all.end(), last_[v].constraints.begin(), last_[v].constraints.end());
  }
  marks_->AddPlaces(points, MarkWeight(round), MarkScale(round), all);
  Solve(level, all, round.turns);
  if (options_.hold_cameras == 0) KeepSize(level);
}

/// Rotates and shifts figure and cameras together to where the template stands: pictures do not
/// tell where that is.
void Bending::KeepPlace(PointsX3& points) {
  const Similarity3 back = FitSimilarity(points, rest_, areas_, false);
  points = Transformed(back, points);
  const Rigid3 now_from_place{Eigen::Quaterniond(back.rotation.transpose()),
                              -(back.rotation.transpose() * back.translation)};
  for (Rigid3& pose : poses_) pose = Compose(pose, now_from_place);
}

BendResult Bending::Finish() {
  BendResult result;
  PointsX3 points = FullPoints(0);
  result.unfolded = Unfold(rest_, mesh_.faces, (*levels_)[0].fit->maps(), points);
  if (options_.hold_cameras == 0) KeepPlace(points);
  result.marks = marks_->Quality(FullViews(), points);
  for (MarkQuality& mark : result.marks) mark.off *= unit_;
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
        {SizeOf(pictures_[v].matches), last_[v].gap_px, last_[v].correlation, last_[v].overlap});
  }
  result.confidence = 1 - doubt.array();
  result.volume_ratio =
      SignedVolume(points, mesh_.faces) / std::max(1e-300, SignedVolume(rest_, mesh_.faces));
  return result;
}

std::vector<FitView> Bending::FullViews() const {
  std::vector<FitView> views;
  for (int v = 0; v < SizeOf(views_); ++v) views.push_back(ViewAt(v, 0));
  return views;
}

void Bending::RunRounds(const std::vector<Round>& rounds) {
  for (const Round& round : rounds) {
    while (at_ > LevelOf(round.level)) levels_->Descend(at_--);
    if (round.rematch > 0) MatchAgain(at_, round.rematch);
    for (int k = 0; k < round.repeats; ++k) {
      ReportProgress(progress_, std::min(1.0, static_cast<double>(done_++) / rounds_),
                     texture_.blank()       ? "outlines"
                     : round.appearance > 0 ? "texture"
                                            : "features and outlines");
      RunRound(round);
    }
  }
}

/// The far rounds; again from the start without picks that contradict the rest, which would leave
/// the shape bent.
void Bending::RunFar() {
  const std::vector<Round> rounds = FarRounds(options_.hold_cameras > 0);
  constexpr int kMostTries = 4;
  for (int attempt = 1;; ++attempt) {
    at_ = LevelOf(rounds.front().level);
    RunRounds(rounds);
    if (marks_->count() == 0 || attempt == kMostTries) return;
    if (!marks_->Refuse(FullViews(), FullPoints(at_), Tuning::kMostOff)) return;
    MakeLevels();
    poses_ = first_poses_;
  }
}

BendResult Bending::Run() {
  const std::vector<Round> near = texture_.blank() ? UntexturedRounds() : NearRounds();
  rounds_ = 0;
  for (const auto& rounds : {FarRounds(options_.hold_cameras > 0), near})
    for (const Round& round : rounds) rounds_ += round.repeats;
  RunFar();
  if (!options_.only_far) RunRounds(near);
  return Finish();
}

}  // namespace

BendResult BendToViews(const Mesh& mesh, const Image8& texture, const Eigen::VectorXd& stiffness,
                       const std::vector<BendView>& views, const BendMarks& marks,
                       const BendOptions& options, Progress* progress) {
  return Bending(mesh, texture, stiffness, views, marks, options, progress).Run();
}

}  // namespace keypose::fit
