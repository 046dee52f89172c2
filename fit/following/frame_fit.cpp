#include "fit/following/frame_fit.h"

#include <algorithm>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "deform/arap/arap_fit.h"
#include "fit/bending/unfold.h"
#include "fit/bending/view_constraints.h"
#include "fit/contours/outline.h"
#include "fit/following/cross_view.h"

namespace keypose::fit {
namespace {

// The first two are those of the fit of photographs. Lengths are in units of half the diagonal.
struct FrameFitTuning {
  // Weight of the whole surface at stiffness 1, when every vertex is held by one view.
  KEYPOSE_TUNED(double, kSurfaceWeight, 1700);
  KEYPOSE_TUNED(double, kOutlineWeight, 3);   // of outlines, relative to a vertex held by one view
  KEYPOSE_TUNED(double, kHold, 0.05);         // of where bending begins, relative to the same
  KEYPOSE_TUNED(double, kSmoothing, 0.04);    // maps vary little over this distance
  KEYPOSE_TUNED(double, kLeastFacing, 0.35);  // cosine at which a vertex is compared
};

struct FollowRound {
  double stiffness, outlines, grey;  // factors
  double scale;                      // robust distance of outlines
  int pyramid, repeats;
};

std::vector<FollowRound> RoundsOf(bool second) {
  if (second) return {{0.2, 1, 1, 0.02, 0, 2}};
  return {{1, 1, 0, 0.06, 1, 2}, {0.5, 1, 1, 0.04, 1, 2}, {0.2, 1, 1, 0.02, 0, 2}};
}

constexpr int kTurns = 6, kSolverSteps = 10;
constexpr double kStill = 1e-5, kTextureShift = 6;

class FrameFitting {
 public:
  FrameFitting(const FollowedMesh& mesh, const PointsX3& base,
               const std::vector<PreparedView>& views, const SurfaceTexture* texture,
               const FrameFitOptions& options)
      : mesh_(mesh),
        views_(views),
        texture_(texture),
        options_(options),
        unit_(mesh.unit()),
        origin_(base.colwise().mean()),
        rest_((base.rowwise() - origin_) / unit_),
        coarse_rest_(mesh.Coarse(rest_)),
        fit_(coarse_rest_, mesh.coarse_faces(), {}, Tuning::kSmoothing * Tuning::kSmoothing) {
    const double whole = fit_.vertex_areas().sum();
    areas_ = fit_.vertex_areas() / whole;
    area_ = whole;
    for (const FacePairs::Pair& pair : mesh.pairs().pairs)
      edge_ += (rest_.row(pair.a) - rest_.row(pair.b)).norm() / SizeOf(mesh.pairs().pairs);
  }

  /// @param start  C x 3; where what no view holds stays
  void Run(bool second, const PointsX3& start) {
    start_ = moved_ = (start.rowwise() - origin_) / unit_;
    fit_.FitMaps(moved_);
    for (const FollowRound& round : RoundsOf(second))
      for (int k = 0; k < round.repeats; ++k) RunRound(round);
  }
  PointsX3 moved() const { return (moved_ * unit_).rowwise() + origin_; }  ///< C x 3
  Eigen::VectorXd sure() const { return known_.array() / (1 + known_.array()); }

 private:
  using Tuning = FrameFitTuning;

  double SurfaceWeight(const FollowRound& round) const {
    return Tuning::kSurfaceWeight / (round.stiffness * options_.stiffness);
  }

  FitView ViewAt(int view, int level) const {
    const Rigid3& pose = views_[view].camera_from_world;
    return {view,
            views_[view].camera(level),
            {pose.rotation, (pose.rotation * origin_.transpose() + pose.translation) / unit_}};
  }

  std::vector<Constraint> Outlines(const FollowRound& round, const PointsX3& points,
                                   const RayScene& scene) const;
  std::vector<Constraint> Greys(const FollowRound& round, const PointsX3& points,
                                const RayScene& scene) const;
  std::vector<ShownView> ShownViews(int pyramid, const PointsX3& points, const PointsX3& normals,
                                    const RayScene& scene, std::vector<GreyPyramid>& greys) const;
  void AddTexture(const FollowRound& round, const PointsX3& points, const RayScene& scene,
                  const ShownView& view, std::vector<Constraint>& all) const;
  Pulls PullsOf(const std::vector<Constraint>& constraints) const;
  void RunRound(const FollowRound& round);
  void Solve(const FollowRound& round, const std::vector<Constraint>& constraints);

  const FollowedMesh& mesh_;
  const std::vector<PreparedView>& views_;
  const SurfaceTexture* texture_;
  const FrameFitOptions& options_;
  double unit_;
  Eigen::RowVector3d origin_;
  PointsX3 rest_, coarse_rest_;  // normalised
  PointsX3 start_, moved_;       // normalised, coarse
  ArapFit fit_;
  Eigen::VectorXd areas_;  // of the coarse vertices, over the whole area
  double area_ = 0, edge_ = 0;
  Eigen::VectorXd known_;  // C: weight of what views say along the normal, over one view's
};

std::vector<Constraint> FrameFitting::Outlines(const FollowRound& round, const PointsX3& points,
                                               const RayScene& scene) const {
  std::vector<Constraint> all;
  for (int v = 0; v < SizeOf(views_); ++v) {
    const int level = std::min(round.pyramid, SizeOf(views_[v].levels) - 1);
    const FitView at = ViewAt(v, level);
    const std::vector<ContourPoint> contour = FindSilhouette(
        points, mesh_.faces(), mesh_.pairs(), scene, at.camera, at.camera_from_world);
    OutlineTerms terms;
    terms.weight = Tuning::kOutlineWeight * round.outlines * SurfaceWeight(round) /
                   static_cast<double>(points.rows());
    terms.edge = edge_;
    terms.scale = round.scale;
    terms.reach_px = 2 * round.scale * at.camera.fx / at.camera_from_world.translation.norm();
    const std::vector<Constraint> found =
        OutlineConstraints(points, contour, MakeOutline(views_[v], level), at, terms);
    all.insert(all.end(), found.begin(), found.end());
  }
  return all;
}

/// Comparing every vertex of a fine mesh would say little more: patches overlap.
std::vector<ShownView> FrameFitting::ShownViews(int pyramid, const PointsX3& points,
                                                const PointsX3& normals, const RayScene& scene,
                                                std::vector<GreyPyramid>& greys) const {
  const PointsX3 coarse = mesh_.Coarse(points), coarse_normals = mesh_.Coarse(normals);
  std::vector<ShownView> shown(views_.size());
  greys.resize(views_.size());
  for (int v = 0; v < SizeOf(views_); ++v) {
    const int level = std::min(pyramid, SizeOf(views_[v].levels) - 1);
    greys[v] = MakeGreyPyramid(views_[v].color, level + 1);
    ShownView& view = shown[v];
    view.at = ViewAt(v, level);
    view.grey = &greys[v][std::min(level, SizeOf(greys[v]) - 1)];
    view.mask = &views_[v].levels[level].grey;
    view.noise = std::max(views_[v].noise, 0.5);
    view.shape = RenderShape(points, scene, view.at.camera, view.at.camera_from_world);
    view.seen = SeenVertices(coarse, coarse_normals, view.shape, view.at.camera,
                             view.at.camera_from_world, Tuning::kLeastFacing);
  }
  return shown;
}

void FrameFitting::AddTexture(const FollowRound& round, const PointsX3& points,
                              const RayScene& scene, const ShownView& view,
                              std::vector<Constraint>& all) const {
  const Pinhole& camera = view.at.camera;
  const double footprint = view.at.camera_from_world.translation.norm() / camera.fx;
  const TexturedRender render =
      RenderGrey(points, mesh_.faces(), *texture_, texture_->LevelFor(area_, footprint), scene,
                 camera, view.at.camera_from_world);
  const std::vector<PatchShift> shifts =
      FindShifts(view.seen, render, *view.grey, *view.mask, camera.fx, view.noise, {});
  const std::vector<Constraint> found =
      AppearanceConstraints(mesh_.Coarse(points), view.seen, shifts, areas_, view.at,
                            round.grey * SurfaceWeight(round), kTextureShift);
  all.insert(all.end(), found.begin(), found.end());
}

std::vector<Constraint> FrameFitting::Greys(const FollowRound& round, const PointsX3& points,
                                            const RayScene& scene) const {
  const PointsX3 normals = VertexNormals(points, mesh_.faces());
  std::vector<GreyPyramid> greys;
  const std::vector<ShownView> views = ShownViews(round.pyramid, points, normals, scene, greys);
  const PointsX3 coarse = mesh_.Coarse(points), coarse_normals = mesh_.Coarse(normals);
  std::vector<Constraint> all;
  for (const auto& [a, b] : NeighbouringViews(views, points.colwise().mean())) {
    const std::vector<Constraint> found = CrossViewConstraints(
        coarse, coarse_normals, views[a], views[b], areas_, round.grey * SurfaceWeight(round));
    all.insert(all.end(), found.begin(), found.end());
  }
  if (texture_)
    for (const ShownView& view : views) AddTexture(round, points, scene, view, all);
  for (Constraint& constraint : all) constraint.vertex = mesh_.fine_of()[constraint.vertex];
  return all;
}

/// The constraints on vertices as pulls of the coarse vertices that these follow.
Pulls FrameFitting::PullsOf(const std::vector<Constraint>& constraints) const {
  Pulls pulls(coarse_rest_.rows());
  for (const Constraint& c : constraints) {
    const int v = mesh_.cell_of()[c.vertex];
    const Eigen::Vector3d arm =
        fit_.maps()[v] * (rest_.row(c.vertex) - coarse_rest_.row(v)).transpose();
    pulls.q[v] += c.q;
    pulls.b.row(v) += (c.q * (c.goal - arm)).transpose();
  }
  return pulls;
}

void FrameFitting::Solve(const FollowRound& round, const std::vector<Constraint>& constraints) {
  const double hold = Tuning::kHold * SurfaceWeight(round);
  for (int turn = 0; turn < kTurns; ++turn) {
    Pulls pulls = PullsOf(constraints);
    for (Eigen::Index v = 0; v < start_.rows(); ++v)
      pulls.AddPoint(v, hold * areas_[v], start_.row(v));
    if (turn == 0) fit_.SetWeights(pulls.MeanWeights());
    const PointsX3 next = fit_.FitPositions(pulls, moved_, kSolverSteps);
    const double move = std::sqrt((next - moved_).rowwise().squaredNorm().maxCoeff());
    moved_ = next;
    fit_.FitMaps(moved_);
    if (move < kStill) break;
  }
}

void FrameFitting::RunRound(const FollowRound& round) {
  const PointsX3 points = mesh_.Fine(rest_, moved_, fit_.maps());
  const RayScene scene(points, mesh_.faces());
  std::vector<Constraint> constraints = Outlines(round, points, scene);
  if (round.grey > 0 && options_.grey) {
    const std::vector<Constraint> greys = Greys(round, points, scene);
    constraints.insert(constraints.end(), greys.begin(), greys.end());
  }
  const PointsX3 normals = VertexNormals(moved_, mesh_.coarse_faces());
  const Pulls pulls = PullsOf(constraints);
  known_.resize(moved_.rows());
  for (Eigen::Index v = 0; v < moved_.rows(); ++v) {
    const Eigen::Vector3d normal = normals.row(v);
    known_[v] = normal.dot(pulls.q[v] * normal) / (SurfaceWeight(round) * areas_[v] + 1e-300);
  }
  Solve(round, constraints);
}

PointsX3 Displaced(const PointsX3& coarse, const std::vector<Eigen::Matrix3d>& turns,
                   const PointsX3& offsets) {
  PointsX3 moved = coarse;
  for (Eigen::Index v = 0; v < coarse.rows(); ++v)
    moved.row(v) += (turns[v] * offsets.row(v).transpose()).transpose();
  return moved;
}

}  // namespace

Offsets FitFrame(const FollowedMesh& mesh, const PointsX3& base,
                 const std::vector<PreparedView>& views, const SurfaceTexture* texture,
                 const FollowStart& start, const FrameFitOptions& options) {
  const PointsX3 coarse = mesh.Coarse(base);
  const std::vector<Eigen::Matrix3d> turns = mesh.TurnsOf(coarse);
  const bool second = start.offsets != nullptr;
  FrameFitting fitting(mesh, second ? Bent(mesh, base, *start.shape).points : base, views, texture,
                       options);
  fitting.Run(second, second ? Displaced(coarse, turns, *start.offsets) : coarse);
  const PointsX3 moves = fitting.moved() - coarse;
  Offsets offsets{PointsX3(moves.rows(), 3), fitting.sure()};
  for (Eigen::Index v = 0; v < moves.rows(); ++v)
    offsets.local.row(v) = moves.row(v) * turns[v];  // the inverse of the turn
  return offsets;
}

BentFrame Bent(const FollowedMesh& mesh, const PointsX3& base, const PointsX3& offsets) {
  const PointsX3 rest = mesh.Coarse(base), moved = Displaced(rest, mesh.TurnsOf(rest), offsets);
  const double smoothing = FrameFitTuning::kSmoothing * mesh.unit();
  ArapFit fit(rest, mesh.coarse_faces(), {}, smoothing * smoothing, false);
  fit.FitMaps(moved);
  BentFrame bent{mesh.Fine(base, moved, fit.maps()), 0};
  const std::vector<Eigen::Matrix3d> maps = mesh.FineMaps(fit.maps());
  Unfold(base, mesh.faces(), maps, bent.points);
  bent.flipped = FlippedFaces(base, mesh.faces(), maps, bent.points);
  return bent;
}

double MeanOverlap(const PointsX3& points, const FacesX3& faces,
                   const std::vector<PreparedView>& views) {
  if (views.empty()) return 1;
  const RayScene scene(points, faces);
  double sum = 0;
  for (const PreparedView& view : views)
    sum += Overlap(RenderShape(points, scene, view.camera(), view.camera_from_world),
                   view.levels[0].grey);
  return sum / SizeOf(views);
}

}  // namespace keypose::fit
