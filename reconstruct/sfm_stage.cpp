// keypose-sfm: images and masks to cameras and sparse points, in an upright frame.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "core/values/size_of.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/evidence_check.h"
#include "reconstruct/sfm/final_adjustment.h"
#include "reconstruct/sfm/ground_by_outlines.h"
#include "reconstruct/sfm/matched_features.h"
#include "reconstruct/sfm/posed_model.h"
#include "reconstruct/sfm/strategies.h"
#include "reconstruct/sfm/surroundings.h"
#include "reconstruct/turntable/leveling.h"
#include "reconstruct/turntable/ring_picture.h"

namespace {
namespace fs = std::filesystem;
using namespace keypose;
using namespace keypose::reconstruct;
using nlohmann::json;

json NotPlaced(const ImageSet& set, const Scene& scene) {
  json names = json::array();
  std::size_t next = 0;
  for (const CapturedImage& image : set.images) {
    while (next < scene.views.size() && scene.views[next].name < image.name) ++next;
    if (next == scene.views.size() || scene.views[next].name != image.name)
      names.push_back(image.name);
  }
  return names;
}

void RequirePlaced(const ImageSet& set, const Scene& scene, const SfmOptions& options) {
  if (static_cast<double>(scene.views.size()) >=
      options.min_placed * static_cast<double>(set.images.size()))
    return;
  std::string names;
  for (const json& name : NotPlaced(set, scene))
    names += (names.empty() ? "" : ", ") + name.get<std::string>();
  throw InputError(
      "sfm: the photographs do not join: only " + std::to_string(scene.views.size()) + " of " +
      std::to_string(set.images.size()) + " could be placed in one model. Not placed: " + names +
      ". Take more photographs between these (15 degrees apart or less, rings 20 "
      "degrees apart), in focus and evenly lit, or give the "
      "surface more texture (speckles, fingerprints); masks that miss parts of the "
      "object also cause this (see contact_sheet.jpg, in a project out/POSE/masks.jpg), and "
      "photographs of different figures");
}

/// Advice on the number of photographs and their distance, for any figure.
const char* kWhatToShoot =
    "Shoot more photographs, closer together (15 degrees or less from one to the next, rings 20 "
    "degrees apart), with one zoom, in the "
    "order "
    "of the turn; give the surface more texture (speckles, fingerprints), or put the printed "
    "calibration board under the figure (keypose capture "
    "--print-board)";

/// Checks whether the cameras can be right. Cameras from a board or from the user are assumed to be
/// right; then the masks must be wrong.
void RequireRight(StageContext& stage, const StrategyResult& found, const CameraEvidence& evidence,
                  const SfmOptions& options) {
  if (evidence.by_surroundings) {
    if (IsPlausible(evidence)) return;
    throw InputError("sfm: no cameras fit these photographs: of " + std::to_string(evidence.pairs) +
                     " pairs of photographs that share places only " +
                     std::to_string(evidence.pairs_agree) +
                     " agree with the best cameras that were found. The figure must not move "
                     "against the table or mat that it stands on, and nothing else may move with "
                     "the camera. " +
                     kWhatToShoot);
  }
  if (!evidence.outlines || evidence.hull_iou >= options.min_hull_overlap) return;
  char overlap[64];
  std::snprintf(overlap, sizeof overlap, "%.2f, at least %.2f is required", evidence.hull_iou,
                options.min_hull_overlap);
  if (found.model.scale_source != "none") {
    stage.Warn("the outlines do not fit the cameras (overlap of masks and their hull " +
               std::string(overlap) + "); the cameras come from the " + found.model.scale_source +
               ", so look at the masks (contact_sheet.jpg, in a project out/POSE/masks.jpg)");
    return;
  }
  throw InputError("sfm: no cameras fit these photographs: under the best ones that were found (" +
                   found.method +
                   ") the outlines do not belong to one figure (overlap of masks and their hull " +
                   overlap + "). " + kWhatToShoot +
                   ". Masks that contain other things or miss parts also cause this: look at "
                   "contact_sheet.jpg, in a project "
                   "at out/POSE/masks.jpg");
}

void ReportModel(StageContext& stage, const ImageSet& set, const Scene& scene,
                 const fs::path& model) {
  stage.Report("images_total", SizeOf(set.images));
  stage.Report("images_placed", SizeOf(scene.views));
  stage.ReportJson("not_placed", NotPlaced(set, scene).dump());
  for (const auto& [name, value] : AnalyzeModel(stage, model)) {
    if (name == "mean_reprojection_error")
      stage.Report("reprojection_error_px", value);
    else
      stage.Report(name, value);
  }
  const Camera& camera = scene.views.at(0).camera;
  stage.ReportJson("camera", json{{"model", "OPENCV"},
                                  {"width", camera.width},
                                  {"height", camera.height},
                                  {"fx", camera.fx},
                                  {"fy", camera.fy},
                                  {"cx", camera.cx},
                                  {"cy", camera.cy},
                                  {"k1", camera.k1},
                                  {"k2", camera.k2},
                                  {"p1", camera.p1},
                                  {"p2", camera.p2}}
                                 .dump());
}

/// The views that define which way is up: for a figure that was also shot lying, those of the
/// upright placement (else of the first placement).
Scene UprightViews(const ImageSet& set, const Scene& scene) {
  const auto group = [&](const View& view) { return set.images[set.Find(view.name)].group; };
  std::set<std::string> groups;
  for (const View& view : scene.views) groups.insert(group(view));
  Scene upright = scene;
  const std::string wanted = groups.contains("upright") ? "upright" : *groups.begin();
  std::erase_if(upright.views, [&](const View& view) { return group(view) != wanted; });
  return upright.views.size() < 3 ? scene : upright;
}

Scene Leveled(StageContext& stage, const ImageSet& set, const Scene& scene) {
  const Leveling leveling = LevelScene(UprightViews(set, scene));
  stage.Report("rings", leveling.rings);
  stage.Report("centered_on_axis", leveling.centered_on_axis);
  stage.Report("ring_plane_rms", leveling.plane_rms);
  stage.Report("ring_circle_rms", leveling.circle_rms);
  Scene level = Transformed(leveling.level_from_model, scene);
  const auto ground = GroundOf(set, UprightViews(set, level));
  stage.Report("ground_told_by_outlines", ground.has_value());
  if (!ground) return level;
  stage.Report("ground_spread", ground->spread);
  Similarity3 down;
  down.translation.z() = -ground->height;
  return Transformed(down, level);
}

/// As Leveled, on the plane that the figure stands on where the points show one.
Scene LeveledInRoom(StageContext& stage, const ImageSet& set, const Scene& scene) {
  const auto support = FindSupportPlane(scene);
  stage.Report("support_plane", support.has_value());
  if (!support) return Leveled(stage, set, scene);
  stage.Report("support_plane_points", support->points);
  return Transformed(LevelBySupport(*support, scene.views), scene);
}

/// The cameras, coloured by the rings that they form about one axis.
Image8 Picture(const Scene& scene) {
  std::vector<int> rings(scene.views.size(), -1);
  if (scene.views.size() >= 3 && scene.points.size() >= 10) rings = LevelScene(scene).ring_of_view;
  return DrawCameras(scene, rings);
}

/// Before hours of matching: all photographs and masks are held at once when points are tracked by
/// grey values, cropped to the figure.
void RequireMemoryFor(const ImageSet& set, const SfmOptions& options) {
  constexpr double kBytesAPixel = 2.5;  // measured on figures that fill half of the picture
  std::vector<View> views(set.images.size());
  int longest = 1;
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].camera.width = set.images[i].width;
    views[i].camera.height = set.images[i].height;
    longest = std::max({longest, set.images[i].width, set.images[i].height});
  }
  RequireMemoryForViews("sfm", views, std::min(1.0, 1.0 * options.max_image_size / longest),
                        kBytesAPixel);
}

void Run(StageContext& stage, const SfmOptions& options) {
  Stopwatch watch;
  const ImageSet set = ReadImageSet(stage.Input("images"));
  if (set.images.size() < 3)
    throw InputError("sfm: " + set.folder.string() + " has " + std::to_string(set.images.size()) +
                     " photographs; at least 3 are needed");
  options.Layouts(NamesOf(set));                   // reports a wrong option before the work
  if (stage.Has("poses")) KnownViews(stage, set);  // and wrong cameras
  RequireMemoryFor(set, options);
  ReportProgress(stage.progress(), 0, "features");
  const EvidenceCheck check(set);
  MatchedFeatures matched;
  const StrategyResult found =
      FindCameras({stage, set, options, check, watch}, stage.Scratch(), matched);
  RequirePlaced(set, found.model.scene, options);
  stage.Report("method", found.method);
  stage.Report("scale_source", found.model.scale_source);
  found.measurements.Report(stage);
  Scene scene = RefineByPatches(stage, set, found.model, matched, options);
  watch.Lap(stage, "patches");
  if (matched.in_room) {
    scene = check.WithoutContradicted(scene, matched.features, matched.verified);
    RequirePlaced(set, scene, options);
  }
  const CameraEvidence evidence =
      matched.in_room ? check.EvaluateSurroundings(scene, matched.features, matched.verified)
                      : check.Evaluate(scene, matched.features, matched.verified);
  ReportEvidence(stage, evidence);
  watch.Lap(stage, "hull_check");
  RequireRight(stage, found, evidence, options);
  if (options.level && found.model.scale_source == "none")
    scene = matched.in_room ? LeveledInRoom(stage, set, scene) : Leveled(stage, set, scene);
  const fs::path output = stage.Output("model");
  WriteColmapModel(output, scene);
  if (const fs::path picture = stage.Output("picture"); !picture.empty())
    WriteImage(picture, Picture(scene));
  ReportModel(stage, set, scene, output);
}

const StageSpec kSpec = {
    .name = "sfm",
    .version = "18",
    .summary =
        "Finds where each photograph was taken from, with COLMAP, and turns the result upright.",
    .title = "Cameras",
    .measurements = {{"method", "cameras from"},
                     {"images_placed", "photographs placed"},
                     {"reprojection_error_px", "reprojection error", "px", -kAnyNumber, 1.0},
                     {"points", "sparse points"},
                     {"mean_track_length", "mean track length"}},
    .inputs = {{.name = "images", .kind = "folder", .help = "images folder of capture", .file = ""},
               {.name = "poses",
                .kind = "path",
                .help = "cameras that are known: a COLMAP model's folder, a transforms.json, or "
                        "Metashape's XML",
                .file = "",
                .optional = true}},
    .outputs = {{.name = "model",
                 .kind = "folder",
                 .help = "COLMAP binary model: cameras.bin, images.bin, points3D.bin",
                 .file = "model"},
                {.name = "picture",
                 .kind = "file",
                 .help = "the placed cameras from above and from the side (.png)",
                 .file = "cameras.png",
                 .optional = true}},
    .tools = {"colmap"},
    .cores = 0,
    .memory_gib = 3,
    .common = {"method", "rings", "max_image_size", "min_placed", "level"}};

}  // namespace

int main(int argc, char** argv) { return RunStage<SfmOptions>(argc, argv, kSpec, Run); }
