// keypose-refine: moves a surface to the best agreement with the photographs.
#include <malloc.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/colmap_io.h"
#include "core/stage/stage.h"
#include "reconstruct/numerics/cpu_seconds.h"
#include "reconstruct/refinement/refine_surface.h"
#include "views/load/prepared_views.h"

namespace keypose::reconstruct {
namespace {

void Run(StageContext& stage, const RefineOptions& options) {
  // By default, the size limit above which freed memory returns to the system grows with the first
  // large images.
  mallopt(M_MMAP_THRESHOLD, 1 << 20);
  const Mesh surface = ReadMesh(stage.Input("surface"));
  const Scene scene = ReadColmapModel(stage.Input("model"));
  std::vector<PreparedView> views =
      LoadPreparedViews(stage, "refine", scene, options.max_size, options.levels);
  double masked = 0;
  for (PreparedView& view : views) masked += 1e-6 * static_cast<double>(view.masked_pixels);
  const RefineResult result = RefineSurface(surface, views, options, stage.progress());
  WriteMesh(stage.Output("refined"), result.mesh);
  const double cpu = CpuSeconds();
  stage.Report("vertices", result.mesh.vertex_count());
  stage.Report("faces", result.mesh.face_count());
  stage.Report("footprint", result.footprint);
  stage.Report("moved_median_footprints", result.moved_median);
  stage.Report("moved_95_footprints", result.moved_95);
  stage.Report("cost_before", result.cost_before);
  stage.Report("cost_after", result.cost_after);
  stage.Report("seen", result.seen);
  stage.Report("evidence", result.evidence);
  stage.Report("outline_gap_before_px", result.outline_gap_before_px);
  stage.Report("outline_gap_px", result.outline_gap_px);
  stage.Report("shading_error_before", result.shading_error_before);
  stage.Report("shading_error_after", result.shading_error_after);
  stage.Report("unfolded", result.unfolded);
  stage.Report("held_inside", result.held_inside);
  stage.Report("masked_megapixels", masked);
  stage.Report("cpu_seconds", cpu);
  stage.Report("cpu_seconds_per_masked_megapixel", masked > 0 ? cpu / masked : 0.0);
}

}  // namespace
}  // namespace keypose::reconstruct

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "refine";
  spec.version = "4";
  spec.summary = "Moves the surface along its normals to the best photometric consistency.";
  spec.title = "Fine detail";
  spec.measurements = {
      {"moved_95_footprints", "shift of the surface by the photographs, 95 %", "px"},
      {"outline_gap_px", "distance of outlines and masks", "px"},
      {"evidence", "surface determined by photographs", "share", 0.08},
      {"shading_error_after", "difference of its brightness to the photographs", "share"}};
  spec.inputs = {{"images", "folder", "photographs and masks, as capture makes them"},
                 {"model", "folder", "COLMAP model of the cameras, as sfm makes it"},
                 {"surface", "file", "triangle mesh, as mesh makes it"}};
  spec.outputs = {{"refined", "file", "the surface's faces and colours, moved", "refined.ply"}};
  spec.memory_gib = 2;
  spec.common = {"max_size", "rounds", "shading"};
  return keypose::RunStage<keypose::reconstruct::RefineOptions>(argc, argv, spec,
                                                                keypose::reconstruct::Run);
}
