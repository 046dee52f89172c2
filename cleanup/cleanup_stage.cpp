// keypose-cleanup: a surface of any quality to a closed, oriented 2-manifold.
#include <algorithm>

#include "cleanup/cleanup.h"
#include "core/geometry.h"
#include "core/io/mesh_io.h"
#include "core/stage/stage.h"

namespace {

using keypose::StageContext;
using keypose::StageSpec;
using keypose::cleanup::CleanupOptions;
using keypose::cleanup::CleanupResult;
using keypose::cleanup::SurfaceDistance;

void ReportDistance(StageContext& stage, const std::string& name, const SurfaceDistance& distance) {
  stage.Report(name + "_mean_over_diag", distance.mean);
  stage.Report(name + "_p99_over_diag", distance.p99);
  stage.Report(name + "_max_over_diag", distance.max);
}

void Run(StageContext& stage, const CleanupOptions& options) {
  const keypose::Mesh surface = keypose::ReadMesh(stage.Input("surface"));
  keypose::RequireUsable(surface, stage.Input("surface").string());
  const CleanupResult result = keypose::cleanup::MakeClosedManifold(surface, options, stage.progress());
  stage.Report("input_faces", surface.face_count());
  stage.Report("faces", result.mesh.face_count());
  stage.Report("vertices", result.mesh.vertex_count());
  stage.Report("closed", true);
  stage.Report("rung", result.rung);
  stage.Report("holes_filled", result.holes_filled);
  stage.Report("largest_hole_over_diag", result.largest_hole_over_diag);
  stage.Report("components", result.components);
  stage.Report("components_removed", result.components_removed);
  stage.Report("stands_removed", result.stands_removed);
  stage.Report("merged_vertices", result.merged_vertices);
  stage.Report("self_intersections_before", result.self_intersections_before);
  stage.Report("self_intersections", result.self_intersections);
  stage.Report("genus", result.genus);
  stage.Report("genus_before", result.genus_before);
  stage.Report("handles_cut", result.handles_cut);
  stage.Report("area", result.area);
  stage.Report("volume", result.volume);
  stage.Report("min_angle_deg", result.min_angle_deg);
  stage.Report("mean_min_angle_deg", result.mean_min_angle_deg);
  ReportDistance(stage, "distance_to_input", result.to_input);
  ReportDistance(stage, "distance_from_input", result.from_input);
  stage.Report("undamaged_share", result.undamaged_share);
  ReportDistance(stage, "undamaged_to_input", result.undamaged_to_input);
  ReportDistance(stage, "undamaged_from_input", result.undamaged_from_input);
  stage.Report("diagonal", keypose::BoundingDiagonal(surface.points));
  stage.Report("hausdorff_over_diag", std::max(result.to_input.max, result.from_input.max));
  keypose::WriteMesh(stage.Output("clean"), result.mesh);
}

const StageSpec kSpec = {
    .name = "cleanup",
    .version = "4",
    .summary = "Repairs a surface into a closed, oriented 2-manifold without self-intersections at the wanted size.",
    .inputs = {{.name = "surface", .kind = "file", .help = "triangles of any quality (.ply, .obj, .off, .stl)", .file = ""}},
    .outputs = {{.name = "clean", .kind = "file", .help = "the closed mesh", .file = "clean.ply"}},
    .tools = {},
    .cores = 1,
    .memory_gib = 2};

}  // namespace

int main(int argc, char** argv) { return keypose::RunStage<CleanupOptions>(argc, argv, kSpec, Run); }
