// keypose-fit: bends the template into a few photographs of another pose.
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/stiffness_io.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "fit/bending/bend.h"
#include "fit/cameras/cameras_around.h"
#include "fit/cameras/find_cameras.h"
#include "fit/cameras/late_cameras.h"
#include "fit/cameras/rig_motions.h"
#include "fit/contours/disagreement.h"
#include "fit/fit_options.h"
#include "fit/fit_pose.h"
#include "fit/outline_picture.h"
#include "fit/picks/pose_picks.h"
#include "views/load/prepared_views.h"

namespace keypose::fit {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "fit";
  spec.version = "10";
  spec.summary = "Bends the template into a few photographs of another pose.";
  spec.title = "Bent into photographs";
  spec.measurements = {{"matches", "features matched to the template"},
                       {"outline_gap_px", "distance of outlines and masks", "px"},
                       {"correlation", "correlation of grey values"},
                       {"volume_ratio", "volume over the template's", "", 0.9, 1.1},
                       {"unseen", "surface in no photograph", "share", -kAnyNumber, 0.4}};
  spec.inputs = {
      {"template", "file", "the unwrapped template (.obj)", ""},
      {"texture", "file",
       "the template's texture; without one, outlines and picks alone are fitted", "", true},
      {"images", "folder", "photographs of the pose, from capture", ""},
      {"rig", "folder", "the template's cameras, from sfm: the lens, and the rig", ""},
      {"stiffness", "file", "the template with painted greys (.ply), or a number for each vertex",
       "", true},
      {"landmarks", "file", "picks in photographs of the pose, after picks of the template", "",
       true, true}};
  spec.outputs = {
      {"fitted", "file", "the template in the pose (.obj or .ply)", "fitted.obj"},
      {"model", "folder", "the cameras of the pose's photographs (COLMAP)", "model", true},
      {"picture", "file", "outlines of the result over the photographs (.png)", "fitted.png",
       true}};
  spec.memory_gib = 2;
  spec.common = {"max_size"};
  return spec;
}

/// The template's lens for a photograph of this size, else of this shape.
Camera LensFor(const Scene& rig, const CapturedImage& image) {
  for (const View& view : rig.views)
    if (view.camera.width == image.width && view.camera.height == image.height) return view.camera;
  std::set<std::pair<int, int>> sizes;  // of the lenses of this shape
  Camera camera;
  for (const View& view : rig.views) {
    const double factor = static_cast<double>(image.width) / view.camera.width;
    if (std::abs(factor * view.camera.height - image.height) >= 1) continue;
    if (sizes.empty()) camera = view.camera.Scaled(factor);
    sizes.emplace(view.camera.width, view.camera.height);
  }
  camera.width = image.width;
  camera.height = image.height;
  if (sizes.size() == 1) return camera;
  if (sizes.size() > 1)
    throw InputError("fit: " + image.name + " has " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) +
                     " pixels, as no photograph of the template, and the template's lenses of this "
                     "shape are several: which of them it is of, its size does not tell; "
                     "photograph the pose with one of the template's cameras, at its own size");
  const Camera& known = rig.views[0].camera;
  throw InputError("fit: " + image.name + " has " + std::to_string(image.width) + " x " +
                   std::to_string(image.height) + " pixels, but the template's photographs have " +
                   std::to_string(known.width) + " x " + std::to_string(known.height) +
                   "; photograph all poses with one camera and one format");
}

PosePicks LoadPicks(StageContext& stage, const Mesh& mesh, const ImageSet& set) {
  if (!stage.Has("landmarks")) return {};
  CarryLog log;
  PosePicks picks = ReadPosePicks(stage.Inputs("landmarks"), mesh, set, &log);
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  if (!picks.unpaired.empty())
    stage.Warn(
        "fit: the template has no picks of these names, so those of the pose are not used: " +
        NameList(picks.unpaired));
  if (!picks.of_another.empty())
    stage.Warn(
        "fit: these picks are not used, because their photographs were shot or developed again "
        "since: " +
        NameList(picks.of_another) +
        "; pick them again, or say on the studio's page Landmarks that they still hold (or take "
        "'photograph' out of them in the file)");
  if (!picks.of_none.empty())
    stage.Warn("fit: these picks are not used, because their photographs are gone: " +
               NameList(picks.of_none));
  return picks;
}

/// For each view, its picks as matches.
std::vector<std::vector<FeatureMatch>> PicksByView(const PosePicks& picks,
                                                   const std::vector<PreparedView>& views,
                                                   const Scene& scene) {
  std::vector<std::vector<FeatureMatch>> by_view(views.size());
  for (int v = 0; v < SizeOf(views); ++v)
    for (const PhotoPick& pick : picks.pixels)
      if (pick.image == views[v].scene_index)
        by_view[v].push_back({pick.point, PreparedPixel(views[v], scene, pick.pixel), 1, 0});
  return by_view;
}

void WarnOfUnusedPicks(StageContext& stage, const PosePicks& picks,
                       const std::vector<BendView>& views, const Scene& scene) {
  std::vector<std::string> lost;
  MarksOf(picks, views, scene, &lost);
  if (!lost.empty())
    stage.Warn("fit: these picks are not used, because their photographs are left out: " +
               NameList(lost));
}

/// The pose's photographs with the template's lens; their places are not known yet.
Scene UnplacedScene(const ImageSet& set, const Scene& rig) {
  if (rig.views.empty())
    throw InputError("fit: the template's model has no images; run sfm of the template again");
  Scene scene;
  for (const CapturedImage& image : set.images)
    scene.views.push_back({image.name, LensFor(rig, image), {}});
  return scene;
}

void ReportCameras(StageContext& stage, const std::vector<PreparedView>& views,
                   const std::vector<FoundCamera>& cameras) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (int v = 0; v < SizeOf(views); ++v)
    list.push_back({{"image", views[v].name},
                    {"matches", cameras[v].matches.size()},
                    {"inliers", cameras[v].inliers},
                    {"rms_px", cameras[v].rms_px}});
  stage.ReportJson("cameras", list.dump());
}

/// @throws InputError  fewer than two are placed
void RequirePlaced(StageContext& stage, const std::vector<PreparedView>& views,
                   const std::vector<FoundCamera>& cameras) {
  std::vector<std::string> missing;
  for (int v = 0; v < SizeOf(views); ++v)
    if (!cameras[v].found) missing.push_back(views[v].name);
  if (!missing.empty())
    stage.Warn(
        "fit: these photographs do not show enough of the template to find where they were taken "
        "from; they are left out: " +
        NameList(missing));
  const int placed = SizeOf(views) - SizeOf(missing);
  if (placed < 2)
    throw InputError("fit: only " + std::to_string(placed) + " of " +
                     std::to_string(cameras.size()) +
                     " photographs could be placed by the template; check that they show the "
                     "same character as the template");
}

Scene SceneOf(const Scene& unplaced, const std::vector<BendView>& views,
              const std::vector<Rigid3>& poses) {
  Scene scene;
  for (int v = 0; v < SizeOf(views); ++v) {
    View view = unplaced.views[views[v].view.scene_index];
    view.camera_from_world = poses[v];
    scene.views.push_back(view);
  }
  return scene;
}

/// Which of the rig's cameras took the photographs, if they were taken by them.
void ReportRig(StageContext& stage, const Scene& rig, const std::vector<PreparedView>& views,
               const std::vector<RigMotion>& motions, const std::optional<RigMotion>& on_rig) {
  stage.Report("rig", on_rig.has_value());
  int agreeing = motions.empty() ? 0 : motions.front().agreeing;
  if (on_rig) agreeing = on_rig->agreeing;
  stage.Report("rig_agreeing", agreeing);
  if (!on_rig) {
    if (!motions.empty())
      stage.Warn(fmt::format(
          "fit: the photographs were not taken from the template's camera places ({} of {} agree), "
          "so each camera is found by itself, and the pose may stand wrongly although outlines "
          "agree; if tripod and lens stood as for the template, compare the pose with the "
          "template, or scan it",
          agreeing, views.size()));
    return;
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (int i = 0; i < SizeOf(views); ++i)
    if (on_rig->rig_view[i] >= 0)
      list.push_back({{"image", views[i].name},
                      {"rig_image", rig.views[on_rig->rig_view[i]].name},
                      {"inliers", on_rig->inliers[i]}});
  stage.ReportJson("rig_cameras", list.dump());
}

/// Without a texture, and where picks have not found the rig: its cameras by outlines.
/// @return nothing if none was found so
std::optional<Start> StartByOutlines(StageContext& stage, const Scene& rig,
                                     const std::vector<PreparedView>& views,
                                     const std::vector<FoundCamera>& cameras, const Mesh& mesh) {
  Start start{cameras, {}};
  const int found = PlaceByOutlines(mesh, views, rig.views, start.cameras);
  stage.Report("placed_by_outlines", found);
  if (found == 0) return {};
  start.on_rig.emplace();
  start.on_rig->rig_view.assign(views.size(), -1);
  return start;
}

/// Empty without one.
Image8 LoadTexture(StageContext& stage) {
  stage.Report("textured", stage.Has("texture"));
  if (stage.Has("texture")) return ReadImage(stage.Input("texture"), 3);
  stage.Warn(
      "fit: without a texture only outlines and picks say where the surface is: what turned about "
      "its own axis, or lies before the figure, is not found; cameras are taken from the "
      "template's by outlines, as if the figure stood where the template did: look at the picture");
  return {};
}

Eigen::VectorXd LoadStiffness(StageContext& stage, const Mesh& mesh) {
  if (!stage.Has("stiffness")) return {};
  CarryLog log;
  const Eigen::VectorXd stiffness = ReadStiffness(stage.Input("stiffness"), mesh, &log);
  for (const std::string& note : log.notes) stage.Note(note);
  for (const std::string& warning : log.warnings) stage.Warn(warning);
  return stiffness;
}

/// In each photograph, where result and mask are farthest apart: there a pick helps most.
std::vector<nlohmann::ordered_json> WorstPlaces(const Mesh& fitted,
                                                const std::vector<BendView>& views,
                                                const std::vector<Rigid3>& cameras,
                                                const Scene& photographs) {
  const RayScene scene(fitted.points, fitted.faces);
  const FacePairs pairs = FindFacePairs(fitted.faces);
  std::vector<nlohmann::ordered_json> places(views.size());
  for (int v = 0; v < SizeOf(views); ++v) {
    const Pinhole& pinhole = views[v].view.camera();
    const Camera& camera = photographs.views[views[v].view.scene_index].camera;
    const Disagreement worst = WorstDisagreement(
        FindSilhouette(fitted.points, fitted.faces, pairs, scene, pinhole, cameras[v]),
        MakeOutline(views[v].view, 0));
    if (worst.distance_px <= 0) continue;
    const Eigen::Vector2d pixel = camera.Project(pinhole.Ray(worst.pixel.x(), worst.pixel.y()));
    places[v] = {{"pixel", {pixel.x(), pixel.y()}},
                 {"distance_px", worst.distance_px * camera.fx / pinhole.fx},
                 {"beyond", worst.mask_beyond ? "mask" : "model"}};
  }
  return places;
}

/// @return mean overlap of silhouettes and masks
double ReportViews(StageContext& stage, const std::vector<BendView>& views,
                   const BendResult& result, const std::vector<nlohmann::ordered_json>& worst) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  double overlap = 0, least = 1, gap = 0, correlation = 0;
  int matches = 0;
  const double share = 1.0 / SizeOf(views);
  for (int v = 0; v < SizeOf(views); ++v) {
    const ViewQuality& q = result.view_quality[v];
    list.push_back({{"image", views[v].view.name},
                    {"matches", q.matches},
                    {"outline_gap_px", q.outline_gap_px},
                    {"correlation", q.correlation},
                    {"iou", q.overlap},
                    {"worst", worst[v]}});
    overlap += share * q.overlap;
    gap += share * q.outline_gap_px;
    correlation += share * q.correlation;
    least = std::min(least, q.overlap);
    matches += q.matches;
  }
  stage.ReportJson("views", list.dump());
  stage.Report("matches", matches);
  stage.Report("iou_mean", overlap);
  stage.Report("iou_least", least);
  stage.Report("outline_gap_px", gap);
  stage.Report("correlation", correlation);
  return overlap;
}

/// The other photographs in which a mark was picked.
std::string OtherPicks(const BendPicks& marks, int mark, const std::vector<BendView>& views) {
  std::vector<std::string> others;
  for (int i = 0; i < SizeOf(marks.pixels); ++i)
    if (i != mark && marks.pixels[i].name == marks.pixels[mark].name)
      others.push_back(views[marks.pixels[i].view].view.name);
  return others.empty() ? "" : ", and its picks in " + NameList(others);
}

/// @param off_px  in the photograph
void WarnOfRefused(StageContext& stage, const BendPicks& marks, int mark, double off_px,
                   const std::vector<BendView>& views) {
  const int pixels = SizeOf(marks.pixels);
  if (mark >= pixels)
    return stage.Warn(
        fmt::format("fit: landmark '{}' contradicts what the photographs show; it is "
                    "left out: check its position",
                    marks.places[mark - pixels].name));
  const PixelPick& pick = marks.pixels[mark];
  stage.Warn(
      fmt::format("fit: landmark '{}' in photograph {} contradicts what the photographs "
                  "show{}: it is {:.0f} pixels beside where the pose has it. It is left out; "
                  "pick it again",
                  pick.name, views[pick.view].view.name, OtherPicks(marks, mark, views), off_px));
}

/// @param photographs  the placed ones
/// @param diagonal     of the template
void ReportMarks(StageContext& stage, const BendPicks& marks, const BendResult& result,
                 const std::vector<BendView>& views, const Scene& photographs, double diagonal) {
  if (result.marks.empty()) return;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  int refused = 0;
  for (int i = 0; i < SizeOf(result.marks); ++i) {
    const PickQuality& quality = result.marks[i];
    const bool in_picture = i < SizeOf(marks.pixels);
    double off_px = 0;
    nlohmann::ordered_json entry = {
        {"name", in_picture ? marks.pixels[i].name : marks.places[i - SizeOf(marks.pixels)].name}};
    if (in_picture) {
      const int view = marks.pixels[i].view;
      off_px = quality.off_px * photographs.views[view].camera.fx / views[view].view.camera().fx;
      entry["image"] = views[view].view.name;
      entry["off_px"] = off_px;
    }
    entry["off_over_diag"] = quality.off / diagonal;
    entry["refused"] = quality.refused;
    list.push_back(entry);
    refused += quality.refused;
    if (quality.refused) WarnOfRefused(stage, marks, i, off_px, views);
  }
  stage.Report("landmarks", SizeOf(result.marks) - refused);
  stage.Report("landmarks_refused", refused);
  stage.ReportJson("landmarks_off", list.dump());
}

void ReportShape(StageContext& stage, const BendResult& result) {
  const double count = static_cast<double>(result.views.size());
  stage.Report("limbs_turned", result.limbs_turned);
  stage.Report("unfolded", result.unfolded);
  stage.Report("flipped", result.flipped);
  stage.Report("volume_ratio", result.volume_ratio);
  stage.Report("unseen", static_cast<double>((result.views.array() == 0).count()) / count);
  stage.Report("confidence_mean", result.confidence.mean());
}

void WriteResult(StageContext& stage, Mesh mesh, const Scene& unplaced,
                 const std::vector<BendView>& views, const BendPicks& marks,
                 const BendResult& result) {
  mesh.points = result.points;
  mesh.normals.resize(0, 3);
  WriteMesh(stage.Output("fitted"), mesh);
  if (const auto path = stage.Output("model"); !path.empty())
    WriteColmapModel(path, SceneOf(unplaced, views, result.cameras));
  if (const auto path = stage.Output("picture"); !path.empty())
    WriteImage(path, OutlinePicture(mesh, views, result.cameras, marks.pixels));
}

/// @return mean overlap of silhouettes and masks
double ReportAttempt(StageContext& stage, const Mesh& mesh, const Scene& unplaced,
                     const Attempt& attempt) {
  const BendResult& result = attempt.result;
  Mesh fitted = mesh;
  fitted.points = result.points;
  const double overlap = ReportViews(stage, attempt.placed, result,
                                     WorstPlaces(fitted, attempt.placed, result.cameras, unplaced));
  ReportMarks(stage, attempt.marks, result, attempt.placed,
              SceneOf(unplaced, attempt.placed, result.cameras), BoundingDiagonal(mesh.points));
  ReportShape(stage, result);
  return overlap;
}

/// Fits from all starts that are worth a try, and reports where the cameras of the best one are.
Attempt FitFromStarts(StageContext& stage, const FitInput& in, const Scene& rig,
                      const std::vector<FoundCamera>& cameras, Progress* progress) {
  // Outlines that agree like this need no further starts. Real masks reach 0.987.
  constexpr double kAgreesWell = 0.98;
  const std::vector<RigMotion> motions = FindRigMotions(in.mesh, cameras, in.views, rig.views);
  std::vector<Start> starts = StartsOf(motions, rig.views, cameras);
  // Motions are empty where no camera was found. Picks may have found some that are none of the
  // rig's.
  if (in.texture.empty() && motions.empty())
    if (const auto start = StartByOutlines(stage, rig, in.views, cameras, in.mesh))
      starts = {*start};
  SubProgress first(progress, 0, 0.6), second(progress, 0.6, 1);
  Attempt attempt = FitPose(in, starts, &first);
  const bool clear = !motions.empty() && motions.front().clear;
  if (!clear && !in.texture.empty() && attempt.Agreement() < kAgreesWell) {
    SubProgress looking(&second, 0, 0.1), bending(&second, 0.1, 0.4), again(&second, 0.4, 1);
    const auto around = FindCamerasAround(in.mesh, in.texture, in.views, cameras, &looking);
    const std::vector<Start> further = StartsAround(in, around, starts);
    stage.Report("cameras_around", std::count_if(around.begin(), around.end(),
                                                 [](const auto& one) { return one.found; }));
    attempt = FitAgain(in, FitPose(in, further, &bending, std::move(attempt)), &again);
    starts.insert(starts.end(), further.begin(), further.end());
  }
  stage.Report("starts", SizeOf(starts));
  ReportRig(stage, rig, in.views, motions, attempt.on_rig);
  return attempt;
}

void Run(StageContext& stage, const FitStageOptions& options) {
  const Mesh mesh = ReadMesh(stage.Input("template"));
  RequireUsable(mesh, "fit: template");
  const Eigen::VectorXd stiffness = LoadStiffness(stage, mesh);
  const Image8 texture = LoadTexture(stage);
  const ImageSet set = ReadImageSet(stage.Input("images"));
  const PosePicks picks = LoadPicks(stage, mesh, set);
  const Scene rig = ReadColmapModel(stage.Input("rig"));
  const Scene unplaced = UnplacedScene(set, rig);
  constexpr int kLevels = 3, kFewest = 2;
  std::vector<PreparedView> views =
      LoadPreparedViews(stage, "fit", unplaced, options.max_size, kLevels, kFewest);
  SubProgress rendering(stage.progress(), 0.05, 0.15), finding(stage.progress(), 0.15, 0.3),
      bending(stage.progress(), 0.3, 0.97);
  std::optional<SurfaceFeatures> features;
  if (!texture.empty()) features.emplace(mesh, texture, SurfaceFeatureOptions(), &rendering);
  const auto picked = PicksByView(picks, views, unplaced);
  const std::vector<FoundCamera> cameras =
      FindCameras(mesh, features ? &*features : nullptr, views, picked, &finding);
  ReportCameras(stage, views, cameras);
  const FitInput in{mesh, texture, stiffness, views, rig.views, picks, unplaced};
  const Attempt attempt = FitFromStarts(stage, in, rig, cameras, &bending);
  if (attempt.doubtful_dropped) stage.Report("doubtful_cameras_dropped", *attempt.doubtful_dropped);
  if (attempt.late) stage.Report("images_placed_late", *attempt.late);
  RequirePlaced(stage, views, attempt.cameras);
  WarnOfUnusedPicks(stage, picks, attempt.placed, unplaced);
  stage.Report("images_total", SizeOf(set.images));
  stage.Report("images_placed", SizeOf(attempt.placed));
  const double overlap = ReportAttempt(stage, mesh, unplaced, attempt);
  WriteResult(stage, mesh, unplaced, attempt.placed, attempt.marks, attempt.result);
  if (overlap < options.min_iou)
    throw QualityError(fmt::format(
        "fit: the bent template overlaps with the photographs' masks by {:.2f} only (IoU; "
        "--min_iou is {:.2f}); look at the masks, add photographs of the limbs that moved "
        "farthest, or scan this pose with 24 photographs or more",
        overlap, options.min_iou));
}

}  // namespace
}  // namespace keypose::fit

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::fit::FitStageOptions>(argc, argv, keypose::fit::Spec(),
                                                          keypose::fit::Run);
}
