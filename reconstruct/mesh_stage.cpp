// keypose-mesh: an oriented point cloud becomes a coloured surface.
#include <memory>
#include <utility>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/sight_io.h"
#include "core/io/project/colmap_io.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "reconstruct/meshing/surface.h"
#include "views/hull/silhouettes.h"
#include "views/load/prepared_views.h"

namespace {

using keypose::reconstruct::MeshOptions;

using keypose::reconstruct::OutsideField;
using keypose::reconstruct::WindowEvidence;

/// Evidence for windows from the masks; none without photographs.
WindowEvidence EvidenceOf(keypose::StageContext& stage) {
  if (stage.Has("images") != stage.Has("model"))
    throw keypose::UsageError("mesh: images and model belong together; give both, or neither");
  if (!stage.Has("images")) return {};
  const keypose::Scene scene = keypose::ReadColmapModel(stage.Input("model"));
  WindowEvidence evidence{
      keypose::ReadSight(keypose::ReadImageSet(stage.Input("images")), scene).lines, {}};
  evidence.read_outside = [&stage, scene]() -> OutsideField {
    constexpr int kLongerSide = 1024;
    const auto views = keypose::LoadPreparedViews(stage, "mesh", scene, kLongerSide, 1);
    const auto outlines =
        std::make_shared<keypose::Silhouettes>(views, keypose::OutsideVotes(views.size()));
    return [outlines](const Eigen::Vector3d& x) { return outlines->Outside(x); };
  };
  return evidence;
}

void Run(keypose::StageContext& stage, const MeshOptions& options) {
  const auto path = stage.Input("cloud");
  keypose::PointCloud cloud = keypose::ReadPointCloud(path);
  const auto points = static_cast<std::int64_t>(cloud.points.rows());
  constexpr std::int64_t kBytesAPoint = 800;  // measured
  keypose::RequireMemory(kBytesAPoint * points, "mesh: the surface of " + std::to_string(points) +
                                                    " points (" + path.string() + ")");
  const auto result = keypose::reconstruct::ReconstructSurface(
      std::move(cloud), options, path.filename().string(), stage.progress(), EvidenceOf(stage));
  keypose::WriteMesh(stage.Output("surface"), result.mesh);
  stage.Report("points", points);
  stage.Report("points_used", static_cast<std::int64_t>(result.used.cloud.points.rows()));
  stage.Report("points_merged", result.used.merged);
  stage.Report("points_unsure", result.used.removed_unsure);
  stage.Report("points_outliers", result.used.removed_outliers);
  stage.Report("points_thinned", result.used.removed_thinned);
  stage.Report("points_contrary_normals", result.used.removed_contrary);
  stage.Report("normals_flipped", result.used.normals_flipped);
  stage.Report("spacing", result.used.median_spacing);
  stage.Report("depth", result.depth);
  stage.Report("vertices", result.mesh.vertex_count());
  stage.Report("faces", result.mesh.face_count());
  stage.Report("trimmed_faces", result.trimmed_faces);
  stage.Report("removed_components", result.removed_components);
  stage.Report("kept_closures", result.kept_closures);
  stage.Report("views_with_closed_window", result.views_with_closed_window);
  stage.Report("window_points", result.window_points);
  stage.Report("closed", keypose::CheckClosed(result.mesh).closed());
}

}  // namespace

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "mesh";
  spec.version = "5";
  spec.summary = "Fits a surface to an oriented point cloud, cut back to where there is data.";
  spec.title = "Surface";
  spec.measurements = {{"faces", "Poisson faces"}};
  spec.inputs = {{"cloud", "file", "points with normals and colours (.ply)", "", false, false},
                 {"images", "folder", "photographs and masks, which show windows; with model", "",
                  true, false},
                 {"model", "folder", "COLMAP model of the cameras", "", true, false}};
  spec.outputs = {
      {"surface", "file", "triangle mesh with vertex colours (.ply)", "surface.ply", false, false}};
  spec.cores = 1;
  spec.memory_gib = 4;
  spec.common = {"depth", "trim"};
  return keypose::RunStage<MeshOptions>(argc, argv, spec, Run);
}
