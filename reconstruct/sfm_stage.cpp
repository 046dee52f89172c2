// keypose-sfm: images and masks to cameras and sparse points, in an upright frame.
#include <chrono>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <numeric>

#include "core/errors.h"
#include "core/io/colmap_io.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/parallel.h"
#include "core/stage/stage.h"
#include "reconstruct/guided_matching.h"
#include "reconstruct/leveling.h"
#include "reconstruct/placed_stage.h"
#include "reconstruct/ring_picture.h"
#include "reconstruct/ring_sfm.h"
#include "reconstruct/ring_silhouettes.h"
#include "reconstruct/ring_static.h"
#include "reconstruct/sfm_colmap.h"

namespace {
namespace fs = std::filesystem;
using namespace keypose;
using namespace keypose::reconstruct;
using nlohmann::json;

/// Seconds of each part of the work.
class Stopwatch {
 public:
  void Lap(StageContext& stage, const std::string& name) {
    const auto now = std::chrono::steady_clock::now();
    stage.Report("seconds_" + name, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// The one camera: median focal length of the EXIF data, else COLMAP's guess of 1.2 times the longer side.
Camera StartCamera(const ImageSet& set, bool& focal_known) {
  std::vector<double> focals;
  for (const CapturedImage& image : set.images) {
    if (image.width != set.images[0].width || image.height != set.images[0].height)
      throw InputError("sfm: " + image.name + " is " + std::to_string(image.width) + " x " + std::to_string(image.height) + ", but " +
                       set.images[0].name + " is " + std::to_string(set.images[0].width) + " x " + std::to_string(set.images[0].height) +
                       "; one camera is assumed: run capture again");
    if (image.focal_px > 0) focals.push_back(image.focal_px);
  }
  Camera camera;
  camera.width = set.images[0].width;
  camera.height = set.images[0].height;
  std::sort(focals.begin(), focals.end());
  focal_known = !focals.empty();
  camera.fx = camera.fy = focal_known ? focals[focals.size() / 2] : 1.2 * std::max(camera.width, camera.height);
  camera.cx = camera.width / 2.0;
  camera.cy = camera.height / 2.0;
  return camera;
}

/// Raw matches, but for those on a background that stands still. @param rejected  how many those were
std::vector<PairMatches> MatchPairs(const std::vector<Features>& features, const std::vector<ImagePair>& pairs, int longer_side_px,
                                    const SfmOptions& options, int& rejected, Progress* progress) {
  std::vector<PairMatches> matches(pairs.size());
  std::vector<int> static_matches(pairs.size(), 0);
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const auto [i, j] = pairs[static_cast<std::size_t>(k)];
    PairMatches& pair = matches[static_cast<std::size_t>(k)];
    pair.first = i;
    pair.second = j;
    const Features &first = features[static_cast<std::size_t>(i)], &second = features[static_cast<std::size_t>(j)];
    pair.features = MatchDescriptors(first, second, matching);
    static_matches[static_cast<std::size_t>(k)] = RejectStaticMatches(first, second, longer_side_px, pair.features);
  });
  rejected = std::accumulate(static_matches.begin(), static_matches.end(), 0);
  std::erase_if(matches, [](const PairMatches& pair) { return pair.features.empty(); });
  return matches;
}

/// Matches verified pairs once more along their epipolar lines, and keeps what is more. @return inliers gained
int MatchAlongLines(ColmapDatabase& database, const std::vector<Features>& features, int longer_side_px, const SfmOptions& options,
                    Progress* progress) {
  constexpr double kMaxError_px = 4;  // COLMAP's own threshold
  const std::vector<VerifiedPair> pairs = database.VerifiedPairs();
  std::vector<PairMatches> guided(pairs.size());
  MatchOptions matching;
  matching.max_ratio = options.max_ratio;
  ParallelFor(static_cast<std::int64_t>(pairs.size()), [&](std::int64_t k) {
    if (progress && progress->cancelled()) throw Cancelled();
    const VerifiedPair& pair = pairs[static_cast<std::size_t>(k)];
    if (pair.geometry.kind == PairGeometry::kOther) return;
    PairMatches& found = guided[static_cast<std::size_t>(k)];
    found.first = pair.first;
    found.second = pair.second;
    const Features &first = features[static_cast<std::size_t>(pair.first)], &second = features[static_cast<std::size_t>(pair.second)];
    found.features = MatchGuided(first, second, pair.geometry, matching, kMaxError_px);
    RejectStaticMatches(first, second, longer_side_px, found.features);
    if (static_cast<int>(found.features.size()) <= pair.inliers) found.features.clear();
  });
  int gained = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    if (!guided[k].features.empty()) gained += static_cast<int>(guided[k].features.size()) - pairs[k].inliers;
  std::erase_if(guided, [](const PairMatches& pair) { return pair.features.empty(); });
  database.ReplaceInliers(guided);
  return gained;
}

json NotPlaced(const ImageSet& set, const Scene& scene) {
  json names = json::array();
  std::size_t next = 0;
  for (const CapturedImage& image : set.images) {
    while (next < scene.views.size() && scene.views[next].name < image.name) ++next;
    if (next == scene.views.size() || scene.views[next].name != image.name) names.push_back(image.name);
  }
  return names;
}

void RequirePlaced(const ImageSet& set, const Scene& scene, const SfmOptions& options) {
  if (static_cast<double>(scene.views.size()) >= options.min_placed * static_cast<double>(set.images.size())) return;
  std::string names;
  for (const json& name : NotPlaced(set, scene)) names += (names.empty() ? "" : ", ") + name.get<std::string>();
  throw InputError(
      "sfm: the photographs do not join: only " + std::to_string(scene.views.size()) + " of " + std::to_string(set.images.size()) +
      " could be placed in one model. Not placed: " + names +
      ". Take more photographs between these (15 degrees apart or less, rings 20 degrees apart), in focus and evenly lit, or give the "
      "surface more texture (speckles, fingerprints); masks that miss parts of the object also cause this (see contact_sheet.jpg)");
}

void ReportModel(StageContext& stage, const ImageSet& set, const Scene& scene, const fs::path& model) {
  stage.Report("images_total", static_cast<int>(set.images.size()));
  stage.Report("images_placed", static_cast<int>(scene.views.size()));
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

void ReportMatches(StageContext& stage, std::size_t pairs, std::size_t with_matches, const ColmapDatabase& database) {
  int inliers = 0;
  const auto verified = database.VerifiedPairs();
  for (const VerifiedPair& pair : verified) inliers += pair.inliers;
  stage.Report("pairs_tried", static_cast<int>(pairs));
  stage.Report("pairs_matched", static_cast<int>(with_matches));
  stage.Report("pairs_verified", static_cast<int>(verified.size()));
  stage.Report("verified_matches", inliers);
}

std::vector<std::string> NamesOf(const ImageSet& set) {
  std::vector<std::string> names;
  for (const CapturedImage& image : set.images) names.push_back(image.name);
  return names;
}

/// What was seen in the photographs.
struct Seen {
  Camera camera;  ///< as assumed before any adjustment
  bool focal_known = false;
  std::vector<Features> features;
  std::vector<PairMatches> matches;  ///< raw, however few a pair has
};

/// Features, matches and verified matches of the set, the last in a COLMAP database.
Seen BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, Stopwatch& watch) {
  Seen seen;
  seen.camera = StartCamera(set, seen.focal_known);
  const std::vector<std::string> names = NamesOf(set);
  ColmapDatabase::Create(files.database, seen.camera, seen.focal_known, names);
  ExtractFeatures(stage, set, files, options);
  watch.Lap(stage, "features");
  std::vector<Features>& features = seen.features;
  {
    const ColmapDatabase database(files.database);
    for (std::size_t i = 0; i < names.size(); ++i) features.push_back(database.ReadFeatures(static_cast<int>(i)));
  }
  double count = 0;
  for (const Features& f : features) count += f.count();
  stage.Report("mean_features", count / static_cast<double>(features.size()));
  Step(stage.progress(), 0.4, "choosing pairs");
  const auto pairs = ChoosePairs(features, options.PairList(), stage.progress());
  watch.Lap(stage, "pairs");
  Step(stage.progress(), 0.45, "matching");
  const int longer_side_px = std::max(seen.camera.width, seen.camera.height);
  int static_matches = 0;
  seen.matches = MatchPairs(features, pairs, longer_side_px, options, static_matches, stage.progress());
  stage.Report("static_matches_rejected", static_matches);
  if (static_matches > 0)
    stage.Note("warning: " + std::to_string(static_matches) +
               " matches lie on a background that stands still while the object turns; they are left out (better masks would spare them)");
  watch.Lap(stage, "matching");
  Step(stage.progress(), 0.6, "verifying matches");
  std::vector<PairMatches> enough = seen.matches;
  std::erase_if(enough, [&](const PairMatches& pair) { return static_cast<int>(pair.features.size()) < options.min_inliers; });
  VerifyMatches(stage, files, enough, options);
  watch.Lap(stage, "verification");
  ColmapDatabase database(files.database);
  if (options.guided_matching) {
    Step(stage.progress(), 0.65, "matching along epipolar lines");
    stage.Report("guided_gain", MatchAlongLines(database, features, longer_side_px, options, stage.progress()));
    watch.Lap(stage, "guided_matching");
  }
  ReportMatches(stage, pairs.size(), enough.size(), database);
  return seen;
}

/// The model adjusted once more, with a robust loss; known poses stay, and so does what shows neither points nor a plate.
Scene Refined(StageContext& stage, const PlacedModel& model, const SfmOptions& options) {
  if (model.fixed || (model.observations.empty() && model.bodies.observations.empty())) return model.scene;
  BundleResult result = AdjustBundle(model.scene, model.observations, BundleFor(model, options), stage.progress(), model.bodies);
  stage.Report("colmap_reprojection_error_px", result.before_px);
  stage.Report("refined_reprojection_error_px", result.after_px);
  stage.Report("observations_dropped", result.dropped);
  if (!model.bodies.observations.empty()) stage.Report("board_rms_px", result.bodies_rms_px);
  return std::move(result.scene);
}

Scene Leveled(StageContext& stage, const Scene& scene) {
  const Leveling leveling = LevelScene(scene);
  stage.Report("rings", leveling.rings);
  stage.Report("centered_on_axis", leveling.centered_on_axis);
  stage.Report("ring_plane_rms", leveling.plane_rms);
  stage.Report("ring_circle_rms", leveling.circle_rms);
  return reconstruct::Transformed(leveling.level_from_model, scene);
}

/// Colours of points that a model of ours has, each from the first photograph that shows it.
void ColorPoints(const ImageSet& set, Scene& scene) {
  std::vector<std::vector<std::size_t>> of_view(scene.views.size());
  for (std::size_t p = 0; p < scene.points.size(); ++p)
    if (!scene.points[p].views.empty()) of_view[static_cast<std::size_t>(scene.points[p].views[0])].push_back(p);
  ParallelFor(static_cast<std::int64_t>(scene.views.size()), [&](std::int64_t v) {
    const View& view = scene.views[static_cast<std::size_t>(v)];
    if (of_view[static_cast<std::size_t>(v)].empty()) return;
    const Image8 image = ReadImage(set.ImagePath(set.Find(view.name)), 3);
    for (const std::size_t p : of_view[static_cast<std::size_t>(v)]) {
      const Eigen::Vector2d pixel = view.Project(scene.points[p].position);
      const int x = std::clamp(static_cast<int>(pixel.x()), 0, image.width - 1),
                y = std::clamp(static_cast<int>(pixel.y()), 0, image.height - 1);
      scene.points[p].color = Eigen::Map<const Eigen::Matrix<std::uint8_t, 3, 1>>(image.at(x, y));
    }
  });
}

/// Cameras and the method that found them.
struct Placed {
  Scene scene;
  std::string method;
  std::string scale_source = "none";  ///< of a frame that must stay: "plate" or "poses"
};

Placed PlaceKnown(StageContext& stage, const PlacedModel& model, const std::string& method, const SfmOptions& options) {
  Step(stage.progress(), 0.85, "bundle adjustment");
  return {Refined(stage, model, options), method, model.scale_source};
}

Placed PlaceByFeatures(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
                       const SetBoards& boards) {
  Step(stage.progress(), 0.7, "mapping");
  const auto models = MapImages(stage, files, options);
  Placed placed{{}, "features"};
  json sizes = json::array();
  for (const fs::path& model : models) sizes.push_back(ReadColmapModel(model).views.size());
  stage.ReportJson("model_sizes", sizes.dump());
  if (models.empty()) return placed;
  const PlacedModel model = ModelFromMapper(stage, set, files, {seen.features, seen.matches}, models, boards, options);
  if (model.scene.views.size() < 3) return {model.scene, "features"};
  return PlaceKnown(stage, model, "features", options);
}

void ReportRing(StageContext& stage, const RingSfmResult& ring) {
  stage.Report("ring_layout", ring.layout.reason);
  stage.Report("ring_matches", ring.start.matches);
  stage.Report("ring_inliers", ring.start.inliers);
  stage.Report("ring_inlier_share", ring.start.inlier_share);
  if (!ring.found) return;
  stage.Report("ring_error_px", ring.ring_error_px);
  stage.Report("ring_free_chi2_ratio", ring.chi2_ratio);
  stage.Report("ring_freed", ring.freed);
  stage.ReportJson("ring_slop_deg", json(ring.slop_deg).dump());
  stage.ReportJson("placed_by_step_only", json(ring.by_step_only).dump());
}

Placed PlaceByRing(StageContext& stage, const ImageSet& set, const SfmOptions& options, const Seen& seen) {
  const std::vector<std::string> names = NamesOf(set);
  RingSfmOptions ring;
  ring.matching.max_ratio = options.max_ratio;
  ring.bundle.refine_principal_point = options.refine_principal_point;
  ring.bundle.refine_distortion = options.refine_distortion;
  if (!seen.focal_known) ring.ring.focal_prior = 0.15;
  SubProgress part(stage.progress(), 0.88, 0.97);
  RingSfmResult result = ReconstructRing(seen.camera, names, seen.features, seen.matches, options.Layouts(names), ring, &part);
  ReportRing(stage, result);
  if (!result.found) return {{}, "ring"};
  ColorPoints(set, result.scene);
  return {std::move(result.scene), "ring"};
}

std::vector<Image8> ReadMasks(const ImageSet& set) {
  std::vector<Image8> masks(set.images.size());
  ParallelFor(static_cast<std::int64_t>(masks.size()), [&](std::int64_t i) {
    if (!set.images[static_cast<std::size_t>(i)].mask.empty())
      masks[static_cast<std::size_t>(i)] = ReadImage(set.MaskPath(static_cast<int>(i)), 1);
  });
  return masks;
}

/// The last rung: no feature counts, only outlines. Of the layouts the one whose outlines agree best.
Placed PlaceBySilhouettes(StageContext& stage, const ImageSet& set, const SfmOptions& options, const Seen& seen) {
  const std::vector<std::string> names = NamesOf(set);
  const std::vector<Image8> masks = ReadMasks(set);
  const std::vector<RingLayout> layouts = options.Layouts(names);
  RingSilhouettes best;
  std::string reason;
  for (std::size_t k = 0; k < layouts.size(); ++k) {
    const double share = 0.09 / static_cast<double>(layouts.size());
    SubProgress part(stage.progress(), 0.88 + share * static_cast<double>(k), 0.88 + share * static_cast<double>(k + 1));
    RingSilhouettes fit = FitRingToSilhouettes(seen.camera, layouts[k], masks, {}, &part);
    if (fit.view_error_px.empty() || (!best.view_error_px.empty() && fit.error_px >= 0.9 * best.error_px)) continue;
    best = std::move(fit);
    reason = layouts[k].reason;
  }
  if (best.view_error_px.empty()) return {{}, "silhouettes"};
  stage.Report("silhouette_layout", reason);
  stage.Report("silhouette_error_px", best.error_px);
  if (!best.found) return {{}, "silhouettes"};
  Placed placed{SceneOf(best.model, names, best.points), "silhouettes"};
  ColorPoints(set, placed.scene);
  return placed;
}

/// Down the ladder until a rung holds all photographs; else the rung that holds most.
Placed Place(StageContext& stage, const ImageSet& set, const SfmFiles& files, const SfmOptions& options, const Seen& seen,
             Stopwatch& watch) {
  if (stage.Has("poses")) return PlaceKnown(stage, ModelFromPoses(stage, set, files, seen.features, options), "poses", options);
  const SetBoards boards = PlaceBoards(stage, set, seen.camera, seen.focal_known, options);
  Placed best;
  if (options.method == "auto" || options.method == "board") {
    const auto model = ModelFromBoards(stage, set, files, {seen.features, seen.matches}, boards, options);
    if (model) best = PlaceKnown(stage, *model, "plate", options);
    watch.Lap(stage, "board");
    if (best.scene.views.size() >= options.min_placed * static_cast<double>(set.images.size()) && !best.scene.views.empty()) return best;
  }
  const auto all = [&] { return best.scene.views.size() == set.images.size(); };
  if (options.method == "auto" || options.method == "features") {
    Placed features = PlaceByFeatures(stage, set, files, options, seen, boards);
    if (features.scene.views.size() > best.scene.views.size()) best = std::move(features);
    watch.Lap(stage, "mapping");
  }
  // A figure that was turned over between two halves stands on no one turntable: what the other rungs would find for both is wrong.
  if (boards.groups.size() > 1) return best;
  if (!all() && (options.method == "auto" || options.method == "ring")) {
    Placed ring = PlaceByRing(stage, set, options, seen);
    watch.Lap(stage, "ring");
    if (ring.scene.views.size() > best.scene.views.size()) best = std::move(ring);
  }
  const bool too_few = static_cast<double>(best.scene.views.size()) < options.min_placed * static_cast<double>(set.images.size());
  if (options.method == "silhouettes" || (options.method == "auto" && too_few)) {
    Placed outlines = PlaceBySilhouettes(stage, set, options, seen);
    watch.Lap(stage, "silhouettes");
    if (outlines.scene.views.size() > best.scene.views.size()) best = std::move(outlines);
  }
  return best;
}

/// The cameras, coloured by the rings that they form about one axis.
Image8 Picture(const Scene& scene) {
  std::vector<int> rings(scene.views.size(), -1);
  if (scene.views.size() >= 3 && scene.points.size() >= 10) rings = LevelScene(scene).ring_of_view;
  return DrawCameras(scene, rings);
}

void Run(StageContext& stage, const SfmOptions& options) {
  Stopwatch watch;
  const ImageSet set = ReadImageSet(stage.Input("images"));
  if (set.images.size() < 3)
    throw InputError("sfm: " + set.folder.string() + " has " + std::to_string(set.images.size()) + " photographs; at least 3 are needed");
  options.Layouts(NamesOf(set));  // a wrong option is told before the work
  const fs::path scratch = stage.Scratch();
  const SfmFiles files{scratch, set.folder, scratch / "database.db"};
  Step(stage.progress(), 0, "features");
  const Seen seen = BuildDatabase(stage, set, files, options, watch);
  auto [scene, method, scale_source] = Place(stage, set, files, options, seen, watch);
  RequirePlaced(set, scene, options);
  stage.Report("method", method);
  stage.Report("scale_source", scale_source);
  if (options.level && scale_source == "none") scene = Leveled(stage, scene);
  const fs::path output = stage.Output("model");
  WriteColmapModel(output, scene);
  if (const fs::path picture = stage.Output("picture"); !picture.empty()) WriteImage(picture, Picture(scene));
  ReportModel(stage, set, scene, output);
}

const StageSpec kSpec = {
    .name = "sfm",
    .version = "3",
    .summary = "Finds where each photograph was taken from, with COLMAP, and turns the result upright.",
    .inputs = {{.name = "images", .kind = "folder", .help = "images folder of capture", .file = ""},
               {.name = "poses",
                .kind = "path",
                .help = "cameras that are known: a folder with a COLMAP model, or a transforms.json",
                .file = "",
                .optional = true}},
    .outputs = {{.name = "model", .kind = "folder", .help = "COLMAP binary model: cameras.bin, images.bin, points3D.bin", .file = "model"},
                {.name = "picture",
                 .kind = "file",
                 .help = "the placed cameras from above and from the side (.png)",
                 .file = "cameras.png",
                 .optional = true}},
    .tools = {"colmap"},
    .cores = 0,
    .memory_gib = 3};

}  // namespace

int main(int argc, char** argv) { return RunStage<SfmOptions>(argc, argv, kSpec, Run); }
