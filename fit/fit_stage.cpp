// keypose-fit: bends the template into a few photographs of another pose.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/colmap_io.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/mesh_io.h"
#include "core/mesh_checks.h"
#include "core/size_of.h"
#include "core/stage/stage.h"
#include "fit/bending/bend.h"
#include "fit/cameras/find_cameras.h"
#include "views/load/prepared_views.h"

namespace keypose::fit {
namespace {

struct FitStageOptions {
  int max_size = 1600;

  void Describe(OptionVisitor& visit) {
    visit("max_size", max_size,
          {"photographs are scaled down to this longer side", "px", 128, 16384});
  }
};

StageSpec Spec() {
  StageSpec spec;
  spec.name = "fit";
  spec.version = "1";
  spec.summary = "Bends the template into a few photographs of another pose.";
  spec.inputs = {
      {"template", "file", "the unwrapped template (.obj)", ""},
      {"texture", "file", "the template's texture", ""},
      {"images", "folder", "photographs of the pose, from capture", ""},
      {"rig", "folder", "the template's cameras, from sfm: the lens, and the rig", ""}};
  spec.outputs = {
      {"fitted", "file", "the template in the pose (.obj or .ply)", "fitted.obj"},
      {"model", "folder", "the cameras of the pose's photographs (COLMAP)", "model", true}};
  spec.memory_gib = 2;
  spec.common = {"max_size"};
  return spec;
}

/// The template's lens for a photograph of this size.
Camera LensFor(const Scene& rig, const CapturedImage& image) {
  for (const View& view : rig.views) {
    const double factor = static_cast<double>(image.width) / view.camera.width;
    if (std::abs(factor * view.camera.height - image.height) < 1) {
      Camera camera = view.camera.Scaled(factor);
      camera.width = image.width, camera.height = image.height;
      return camera;
    }
  }
  const Camera& known = rig.views[0].camera;
  throw InputError("fit: " + image.name + " has " + std::to_string(image.width) + " x " +
                   std::to_string(image.height) + " pixels, but the template's photographs have " +
                   std::to_string(known.width) + " x " + std::to_string(known.height) +
                   "; photograph all poses with one camera and one format");
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

std::vector<BendView> PlacedViews(StageContext& stage, std::vector<PreparedView> views,
                                  const std::vector<FoundCamera>& cameras) {
  std::vector<BendView> placed;
  std::vector<std::string> missing;
  for (int v = 0; v < SizeOf(views); ++v) {
    if (!cameras[v].found) {
      missing.push_back(views[v].name);
      continue;
    }
    views[v].camera_from_world = cameras[v].camera_from_world;
    placed.push_back({std::move(views[v]), cameras[v].matches});
  }
  if (!missing.empty())
    stage.Warn("fit: these photographs do not show enough of the template's texture to find "
               "where they were taken from; they are left out: " + NameList(missing));
  if (SizeOf(placed) < 2)
    throw InputError("fit: only " + std::to_string(placed.size()) + " of " +
                     std::to_string(cameras.size()) +
                     " photographs could be placed by the template's texture; check that they "
                     "show the same character as the template");
  return placed;
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

void Run(StageContext& stage, const FitStageOptions& options) {
  const Mesh mesh = ReadMesh(stage.Input("template"));
  const Image8 texture = ReadImage(stage.Input("texture"), 3);
  const ImageSet set = ReadImageSet(stage.Input("images"));
  const Scene unplaced = UnplacedScene(set, ReadColmapModel(stage.Input("rig")));
  constexpr int kLevels = 3;
  std::vector<PreparedView> views =
      LoadPreparedViews(stage, "fit", unplaced, options.max_size, kLevels);
  SubProgress finding(stage.progress(), 0.02, 0.3), bending(stage.progress(), 0.3, 0.97);
  const SurfaceFeatures features(mesh, texture, {}, &finding);
  const std::vector<FoundCamera> cameras = FindCameras(mesh, features, views, &finding);
  ReportCameras(stage, views, cameras);
  const std::vector<BendView> placed = PlacedViews(stage, std::move(views), cameras);
  const BendResult result = BendToViews(mesh, texture, {}, placed, {}, {}, &bending);
  stage.Report("matches", result.matches_used);
  stage.Report("outline_gap_px", result.outline_gap_px);
  stage.Report("correlation", result.correlation);
  stage.Report("volume_ratio", result.volume_ratio);
  stage.Report("unseen", static_cast<double>((result.views.array() == 0).count()) /
                             static_cast<double>(mesh.vertex_count()));
  Mesh fitted = mesh;
  fitted.points = result.points;
  fitted.normals.resize(0, 3);
  WriteMesh(stage.Output("fitted"), fitted);
  if (const auto path = stage.Output("model"); !path.empty())
    WriteColmapModel(path, SceneOf(unplaced, placed, result.cameras));
}

}  // namespace
}  // namespace keypose::fit

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::fit::FitStageOptions>(argc, argv, keypose::fit::Spec(),
                                                          keypose::fit::Run);
}
