// keypose-dense: photographs and cameras to an oriented, coloured cloud.
#include <malloc.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/colmap_io.h"
#include "core/pictures/cloud_picture.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/numerics/cpu_seconds.h"
#include "reconstruct/stereo/dense.h"
#include "reconstruct/stereo/dense_colmap.h"
#include "views/hull/visual_hull.h"
#include "views/load/prepared_views.h"
#include "views/stereo/patch_match_cost.h"

namespace keypose::reconstruct {
namespace {
namespace fs = std::filesystem;

constexpr int kPictureWidth = 360, kPictureHeight = 400;  // of each of the four sides

// COLMAP's cloud includes the background: points outside of the visual hull are removed.
PointCloud WithinHull(const PointCloud& cloud, const VisualHull& hull) {
  std::vector<int> kept;
  for (int i = 0; i < cloud.points.rows(); ++i)
    if (hull.Contains(cloud.points.row(i))) kept.push_back(i);
  PointCloud out;
  out.points = cloud.points(kept, Eigen::all);
  if (cloud.normals.rows()) out.normals = cloud.normals(kept, Eigen::all);
  if (cloud.colors.rows()) out.colors = cloud.colors(kept, Eigen::all);
  if (cloud.confidence.rows()) out.confidence = cloud.confidence(kept);
  return out;
}

PointCloud RunColmap(StageContext& stage, const std::vector<PreparedView>& views,
                     const DenseOptions& options) {
  VisualHullOptions hull;
  hull.resolution = options.hull_resolution;
  const PointCloud cloud =
      RunColmapDense(stage, stage.Input("images"), stage.Input("model"), options.max_size);
  return WithinHull(cloud, CarveVisualHull(views, hull));
}

void ReportHullCheck(StageContext& stage, const std::vector<PreparedView>& views,
                     const HullCheck& check) {
  nlohmann::json overlaps = nlohmann::json::object();
  for (std::size_t i = 0; i < views.size(); ++i)
    overlaps[views[i].name] = std::round(check.iou[i] * 1e4) / 1e4;
  stage.Report("hull_iou_mean", check.mean);
  stage.ReportJson("hull_iou", overlaps.dump());
  stage.ReportJson("views_disagreeing", nlohmann::json(check.disagreeing).dump());
  if (!check.disagreeing.empty())
    stage.Note(
        "masks that disagree with what the other views allow, because of the mask or the camera: " +
        NameList(check.disagreeing));
}

void ReportMatching(StageContext& stage, const std::vector<PreparedView>& views,
                    const DenseResult& result) {
  nlohmann::json completeness = nlohmann::json::object();
  double mean = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    completeness[views[i].name] = std::round(result.completeness[i] * 1e4) / 1e4;
    mean += result.completeness[i] / static_cast<double>(views.size());
  }
  stage.Report("stereo_points", result.stereo_points);
  stage.Report("gap_points", result.gap_points);
  stage.Report("hull_points", static_cast<int>(result.cloud.points.rows()) - result.stereo_points -
                                  result.gap_points - result.frontier_points);
  stage.Report("frontier_points", result.frontier_points);
  stage.Report("points_against_outlines", result.contradicted_points);
  stage.Report("ncc_evaluations", result.evaluations);
  stage.Report("ncc_per_cpu_second",
               result.matching_cpu_seconds > 0
                   ? static_cast<double>(result.evaluations) / result.matching_cpu_seconds
                   : 0.0);
  stage.Report("matching_cpu_seconds", result.matching_cpu_seconds);
  stage.Report("hull_volume", result.hull_volume);
  stage.Report("completeness_mean", mean);
  stage.Report("points_outside_masks", result.outside_points);
  ReportHullCheck(stage, views, result.hull_check);
  stage.ReportJson("completeness", completeness.dump());
  stage.ReportJson("views_without_sources", nlohmann::json(result.views_without_sources).dump());
  if (!result.views_without_sources.empty())
    stage.Note("dense: views without neighbours, not matched: " +
               NameList(result.views_without_sources));
}

void Run(StageContext& stage, const DenseOptions& options) {
  // By default, the size limit above which freed memory returns to the system grows with the first
  // large images, so unused maps would stay in memory.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  const Scene scene = ReadColmapModel(stage.Input("model"));
  const std::vector<PreparedView> views =
      LoadPreparedViews(stage, "dense", scene, options.max_size, options.levels);
  double masked = 0;
  for (const PreparedView& view : views) masked += 1e-6 * static_cast<double>(view.masked_pixels);
  PointCloud cloud;
  if (options.backend == "colmap_cuda") {
    cloud = RunColmap(stage, views, options);
    if (cloud.points.rows() == 0)
      throw InputError(
          "dense: COLMAP found no points on the object; look at the masks and at the model");
  } else {
    stage.Report("kernel", stereo::BestPatchCostKernel().name);
    DenseResult result = ReconstructDense(views, scene, options, stage.progress());
    ReportMatching(stage, views, result);
    cloud = std::move(result.cloud);
  }
  const double cpu = CpuSeconds();
  stage.Report("points", static_cast<int>(cloud.points.rows()));
  stage.Report("views", SizeOf(views));
  stage.Report("cpu_seconds", cpu);
  stage.Report("masked_megapixels", masked);
  stage.Report("cpu_seconds_per_masked_megapixel", cpu / std::max(masked, 1e-6));
  WritePointCloud(stage.Output("cloud"), cloud);
  if (const fs::path picture = stage.Output("picture"); !picture.empty())
    WritePng(picture, RenderCloudSides(cloud, kPictureWidth, kPictureHeight));
}

}  // namespace
}  // namespace keypose::reconstruct

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "dense";
  spec.version = "10";
  spec.summary =
      "Matches the photographs pixel by pixel and fuses their depths to an oriented, coloured "
      "cloud.";
  spec.title = "Depth";
  spec.measurements = {{"points", "dense points"},
                       {"cpu_seconds", "CPU time", "s"},
                       {"completeness_mean", "completeness"}};
  spec.inputs = {{"images", "folder", "photographs and masks, as capture makes them"},
                 {"model", "folder", "COLMAP model of the cameras, as sfm makes it"}};
  spec.outputs = {{"cloud", "file", "points with normals, colours and confidence", "cloud.ply"},
                  {.name = "picture",
                   .kind = "file",
                   .help = "the cloud from four sides",
                   .file = "cloud.png",
                   .optional = true}};
  spec.tools = {};
  spec.memory_gib = 2;
  spec.common = {"max_size", "sources"};
  return keypose::RunStage<keypose::reconstruct::DenseOptions>(argc, argv, spec,
                                                               keypose::reconstruct::Run);
}
