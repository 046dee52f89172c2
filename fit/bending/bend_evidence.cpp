#include "fit/bending/bend_evidence.h"

#include <algorithm>
#include <map>
#include <utility>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "fit/bending/feature_filter.h"
#include "fit/bending/nearby_matches.h"
#include "fit/bending/patch_matches.h"
#include "views/placement/picture_pose.h"

namespace keypose::fit {
namespace {

// Chosen on the clay creature's seeds 1 to 4 (synth).
struct EvidenceTuning {
  // Weight of the whole surface at stiffness 1, when every vertex is held by one view.
  KEYPOSE_TUNED(double, kSurfaceWeight, 1700);
  // Matches in one cell of the coarse level from which on they have the cell's whole weight.
  KEYPOSE_TUNED(double, kMatchesForAll, 4);
  KEYPOSE_TUNED(double, kOutlineWeight, 3);   // of outlines, relative to a vertex held by texture
  KEYPOSE_TUNED(double, kPlacedReach, 0.05);  // of features on vertices that stand nearly right
  KEYPOSE_TUNED(double, kLeastFacing, 0.25);  // cosine at which a vertex is compared
};
using Tuning = EvidenceTuning;

constexpr int kPhotoFeatures = 4000;
// From this hold on, cameras stay.
constexpr double kFixedCameras = 1e3;

}  // namespace

double SurfaceWeight(const Round& round) { return Tuning::kSurfaceWeight / round.stiffness; }

double MarkWeight(const Round& round, const BendOptions& options) {
  return round.marks * SurfaceWeight(round) / options.coarse_vertices;
}

BentShape::BentShape(PointsX3 at, const FacesX3& faces, bool visible) : points(std::move(at)) {
  if (!visible) return;
  scene.emplace(points, faces);
  normals = VertexNormals(points, faces);
}

ViewEvidence::ViewEvidence(const RestShape& rest, const SurfaceTexture& texture,
                           const std::vector<BendView>& views, const BendOptions& options,
                           std::vector<Rigid3> first_poses)
    : rest_(rest),
      texture_(texture),
      views_(views),
      options_(options),
      first_poses_(std::move(first_poses)),
      pictures_(views.size()) {
  ParallelFor(SizeOf(views_),
              [&](std::int64_t v) { pictures_[v] = PictureOf(static_cast<int>(v)); });
}

ViewEvidence::Picture ViewEvidence::PictureOf(int v) const {
  const PreparedView& view = views_[v].view;
  Picture picture;
  picture.grey = MakeGreyPyramid(view.color, SizeOf(view.levels));
  for (int level = 0; level < SizeOf(view.levels); ++level)
    picture.outlines.push_back(MakeOutline(view, level));
  picture.features = FindFeatures(view.color, MaskOf(view), kPhotoFeatures);
  picture.noise = std::max(view.noise, 0.5);
  for (const int i : ConsistentMatches(rest_.points, views_[v].matches, view.camera(),
                                       first_poses_[v].translation.norm()))
    picture.matches.push_back(views_[v].matches[i]);
  return picture;
}

void ViewEvidence::MatchAgain(const BentShape& shape, const std::vector<Rigid3>& poses,
                              double reach) {
  ParallelFor(SizeOf(views_), [&](std::int64_t v) {
    const int view = static_cast<int>(v);
    const FitView at = ViewAt(view, 0, poses[v]);
    const double reach_px = reach * at.camera.fx / at.camera_from_world.translation.norm();
    std::vector<FeatureMatch> found = MatchNearby(
        rest_.mesh.faces, *shape.scene, RenderIn(at, shape), at, pictures_[v].features, reach_px);
    const std::vector<FeatureMatch> patches = PatchMatches(view, shape, poses[v], reach);
    found.insert(found.end(), patches.begin(), patches.end());
    DropFar(at, shape, found);
    pictures_[v].matches =
        NearbyMatches(rest_.points, shape.points, found, at.camera, at.camera_from_world);
  });
}

/// Those that would pull vertices away from where they were put.
void ViewEvidence::DropFar(const FitView& at, const BentShape& shape,
                           std::vector<FeatureMatch>& matches) const {
  if (placed_.empty()) return;
  const double reach_px =
      Tuning::kPlacedReach * at.camera.fx / at.camera_from_world.translation.norm();
  std::erase_if(matches, [&](const FeatureMatch& match) {
    const Eigen::Vector3d x = PositionOf(match.point, shape.points);
    return placed_[match.point.vertices[0]] &&
           (at.camera.Project(at.camera_from_world * x) - match.pixel).norm() > reach_px;
  });
}

/// Those of the middle level's vertices.
std::vector<FeatureMatch> ViewEvidence::PatchMatches(int view, const BentShape& shape,
                                                     const Rigid3& pose, double reach) const {
  constexpr int kFine = 1, kCoarse = 2;  // half of it: patches are found there first
  if (SizeOf(views_[view].view.levels) <= kCoarse) return {};
  const auto at = [&](int level) {
    const FitView shown = ViewAt(view, level, pose);
    return PatchView{shown, RenderIn(shown, shape), pictures_[view].grey[level],
                     views_[view].view.levels[level].grey};
  };
  const PatchView fine = at(kFine), coarse = at(kCoarse);
  std::vector<SeenVertex> seen;
  for (const SeenVertex& one :
       SeenVertices(shape.points, shape.normals, fine.render, fine.view.camera,
                    fine.view.camera_from_world, Tuning::kLeastFacing))
    if (rest_.of_middle[one.vertex]) seen.push_back(one);
  return MatchPatches(seen, shape.points, fine, coarse, views_[view].view.camera(), reach);
}

TexturedRender ViewEvidence::RenderIn(const FitView& view, const BentShape& shape) const {
  const double footprint = view.camera_from_world.translation.norm() / view.camera.fx;
  return RenderGrey(shape.points, rest_.mesh.faces, texture_,
                    texture_.LevelFor(rest_.area, footprint), *shape.scene, view.camera,
                    view.camera_from_world);
}

int ViewEvidence::LevelIn(int view, int pyramid) const {
  return std::min(pyramid, SizeOf(views_[view].view.levels) - 1);
}

FitView ViewEvidence::ViewAt(int view, int pyramid, const Rigid3& pose) const {
  return {view, views_[view].view.camera(LevelIn(view, pyramid)), pose};
}

void ViewEvidence::AddFeatures(const FitView& at, const Round& round, const BentShape& shape,
                               BendEvidence& evidence) const {
  const std::vector<FeatureMatch>& matches = pictures_[at.index].matches;
  std::map<int, int> in_cell;
  for (const FeatureMatch& match : matches) ++in_cell[rest_.cell_of[match.point.vertices[0]]];
  const double cells = static_cast<double>(std::max<std::size_t>(in_cell.size(), 1));
  const double weight =
      round.features * SurfaceWeight(round) / std::max<double>(options_.coarse_vertices, cells);
  for (const FeatureMatch& match : matches) {
    int corner = 0;
    match.point.weights.maxCoeff(&corner);
    const int vertex = match.point.vertices[corner];
    const Eigen::Vector3d arm =
        PositionOf(match.point, rest_.points) - rest_.points.row(vertex).transpose();
    const int others = in_cell[rest_.cell_of[match.point.vertices[0]]];
    const double w = weight / std::max<double>(others, Tuning::kMatchesForAll);
    evidence.constraints.push_back(PullToPixel(
        at, vertex, arm, PositionOf(match.point, shape.points), match.pixel, w, round.scale));
  }
}

void ViewEvidence::AddOutlines(const FitView& at, const Round& round, const BentShape& shape,
                               BendEvidence& evidence) const {
  const std::vector<ContourPoint> contour = FindSilhouette(
      shape.points, rest_.mesh.faces, rest_.pairs, *shape.scene, at.camera, at.camera_from_world);
  OutlineTerms terms;
  terms.weight = Tuning::kOutlineWeight * round.outlines * SurfaceWeight(round) /
                 static_cast<double>(rest_.points.rows());
  terms.edge = rest_.edge;
  terms.scale = round.scale;
  terms.reach_px = 2 * round.scale * at.camera.fx / at.camera_from_world.translation.norm();
  const Outline& outline = pictures_[at.index].outlines[LevelIn(at.index, round.pyramid)];
  const std::vector<Constraint> found =
      OutlineConstraints(shape.points, contour, outline, at, terms, &evidence.gap_px);
  evidence.constraints.insert(evidence.constraints.end(), found.begin(), found.end());
}

void ViewEvidence::AddAppearance(FitView at, const Round& round, const BentShape& shape,
                                 BendEvidence& evidence) const {
  const int level = LevelIn(at.index, round.pyramid);
  const auto& mask = views_[at.index].view.levels[level].grey;
  const TexturedRender render = RenderIn(at, shape);
  evidence.overlap = Overlap(render, mask);
  if (texture_.blank()) return;
  const Picture& picture = pictures_[at.index];
  const std::vector<SeenVertex> seen = SeenVertices(shape.points, shape.normals, render, at.camera,
                                                    at.camera_from_world, Tuning::kLeastFacing);
  std::vector<PatchShift> shifts =
      FindShifts(seen, render, picture.grey[level], mask, at.camera.fx, picture.noise, {});
  ImprovePose(seen, shape, at, shifts, evidence);
  const std::vector<Constraint> found =
      AppearanceConstraints(shape.points, seen, shifts, rest_.vertex_areas, at,
                            round.appearance * SurfaceWeight(round), 6);
  evidence.constraints.insert(evidence.constraints.end(), found.begin(), found.end());
}

/// Notes what the patches hold. Where cameras may move and enough patches were found, the camera is
/// improved, and the shifts are of what it then shows.
void ViewEvidence::ImprovePose(const std::vector<SeenVertex>& seen, const BentShape& shape,
                               FitView& at, std::vector<PatchShift>& shifts,
                               BendEvidence& evidence) const {
  std::vector<Eigen::Vector2d> goals;
  std::vector<double> weights;
  PointsX3 places(SizeOf(seen), 3);
  int count = 0;
  evidence.sure = Eigen::VectorXd::Zero(shape.points.rows());
  for (int i = 0; i < SizeOf(seen); ++i) {
    if (!shifts[i].found) continue;
    const int vertex = seen[i].vertex;
    places.row(count++) = shape.points.row(vertex);
    const Eigen::Vector2d goal = seen[i].pixel + shifts[i].shift;
    const Eigen::Vector2d first =
        at.camera.Project(first_poses_[at.index] * shape.points.row(vertex).transpose());
    goals.push_back((goal + options_.hold_cameras * first) / (1 + options_.hold_cameras));
    weights.push_back(shifts[i].confidence.trace() * rest_.vertex_areas[vertex]);
    evidence.held.push_back(vertex);
    evidence.sure[vertex] = shifts[i].confidence.trace() / 2;
    evidence.correlation += shifts[i].correlation;
  }
  if (count > 0) evidence.correlation /= count;
  places.conservativeResize(count, 3);
  constexpr int kLeastForPose = 50;
  if (options_.hold_cameras >= kFixedCameras || count < kLeastForPose) return;
  at.camera_from_world = RefinePose(at.camera, at.camera_from_world, places, goals, weights, 2);
  evidence.pose = at.camera_from_world;
  for (int i = 0; i < SizeOf(seen); ++i)
    if (shifts[i].found)
      shifts[i].shift +=
          seen[i].pixel -
          at.camera.Project(at.camera_from_world * shape.points.row(seen[i].vertex).transpose());
}

BendEvidence ViewEvidence::Of(int view, const Round& round, const BentShape& shape,
                              const Rigid3& pose, const PickConstraints& marks) const {
  BendEvidence evidence;
  evidence.pose = pose;
  const FitView full = ViewAt(view, 0, pose), at = ViewAt(view, round.pyramid, pose);
  if (round.features > 0) AddFeatures(full, round, shape, evidence);
  marks.AddPixels(full, shape.points, MarkWeight(round, options_), MarkScale(round),
                  evidence.constraints);
  if (round.outlines > 0) AddOutlines(at, round, shape, evidence);
  if (round.appearance > 0) AddAppearance(at, round, shape, evidence);
  return evidence;
}

}  // namespace keypose::fit
