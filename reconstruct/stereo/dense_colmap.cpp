#include "reconstruct/stereo/dense_colmap.h"

#include "core/io/meshes/mesh_io.h"
#include "core/values/errors.h"

namespace keypose::reconstruct {

bool BuiltWithCuda(const std::string& help) {
  return help.find("with CUDA") != std::string::npos &&
         help.find("without CUDA") == std::string::npos;
}

PointCloud RunColmapDense(StageContext& stage, const std::filesystem::path& images,
                          const std::filesystem::path& model, int max_size) {
  if (!BuiltWithCuda(RunTool(stage, "colmap", {"-h"})))
    throw ToolError(
        "dense: the installed COLMAP is built without CUDA, and its dense stereo refuses to run "
        "without; install a CUDA build and put "
        "it first on PATH, or use --backend patchmatch");
  const std::filesystem::path workspace = stage.Scratch() / "colmap_dense";
  std::filesystem::create_directories(workspace);
  ReportProgress(stage.progress(), 0.02, "COLMAP: undistorting");
  RunTool(stage, "colmap",
          {"image_undistorter", "--image_path", images.string(), "--input_path", model.string(),
           "--output_path", workspace.string(), "--output_type", "COLMAP", "--max_image_size",
           std::to_string(max_size)});
  ReportProgress(stage.progress(), 0.1, "COLMAP: stereo");
  RunTool(stage, "colmap",
          {"patch_match_stereo", "--workspace_path", workspace.string(), "--workspace_format",
           "COLMAP", "--PatchMatchStereo.geom_consistency", "true"});
  ReportProgress(stage.progress(), 0.9, "COLMAP: fusion");
  const std::filesystem::path fused = workspace / "fused.ply";
  RunTool(stage, "colmap",
          {"stereo_fusion", "--workspace_path", workspace.string(), "--workspace_format", "COLMAP",
           "--input_type", "geometric", "--output_path", fused.string()});
  if (!std::filesystem::exists(fused))
    throw ToolError("dense: COLMAP's stereo_fusion wrote no points; look at the step's log");
  return ReadPointCloud(fused);
}

}  // namespace keypose::reconstruct
