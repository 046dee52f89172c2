// keypose-unwrap: texture coordinates for a closed mesh.
#include <filesystem>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/mesh_look.h"
#include "core/io/pictures/frame_folder.h"
#include "core/stage/stage.h"
#include "core/surfaces/mesh_checks.h"
#include "texture/unwrap/unwrap.h"
#include "texture/unwrap_options.h"

namespace {

using keypose::StageContext;
using keypose::StageSpec;
using keypose::texture::UnwrapResult;
using keypose::texture::UnwrapStageOptions;

void Run(StageContext& stage, const UnwrapStageOptions& options) {
  keypose::RequireMeshName(stage.Output("unwrapped"));
  std::filesystem::path path = stage.Input("clean");
  if (std::filesystem::is_directory(path)) path = keypose::NumberedFrames(path, "unwrap").front();
  const keypose::Mesh clean = keypose::ReadMesh(path);
  keypose::RequireUsable(clean, path.string());
  stage.Report("kept", options.keep && clean.has_uvs());
  if (options.keep && clean.has_uvs()) {
    for (const std::string& warning : keypose::LookWarnings(path, clean)) stage.Warn(warning);
    return keypose::WriteMesh(stage.Output("unwrapped"), clean);
  }
  if (options.keep) stage.Note("the mesh has no texture coordinates, so it gets new ones");
  const UnwrapResult result = keypose::texture::Unwrapped(clean, options, stage.progress());
  stage.Report("faces", result.mesh.face_count());
  stage.Report("charts", result.charts);
  stage.Report("flipped", 0);  // Unwrapped proves both before it returns
  stage.Report("overlapping", 0);
  stage.Report("stretch_l2", result.stretch.l2);
  stage.Report("stretch_linf", result.stretch.linf);
  stage.Report("conformal_ratio_mean", result.stretch.conformal_mean);
  stage.Report("conformal_ratio_p99", result.stretch.conformal_p99);
  stage.Report("area_deviation", result.stretch.area_deviation);
  stage.Report("utilisation", result.stretch.utilisation);
  stage.Report("seam_over_diag", result.seam_over_diag);
  stage.Report("seam_front_over_diag", result.seam_front_over_diag);
  stage.Report("seam_exposure", result.seam_exposure);
  stage.Report("edge_exposure", result.edge_exposure);
  stage.Report("texels_per_unit", result.texels_per_unit);
  keypose::WriteMesh(stage.Output("unwrapped"), result.mesh);
}

const StageSpec kSpec = {
    .name = "unwrap",
    .version = "5",
    .summary =
        "Cuts a closed mesh into charts and packs them into one texture without flips or overlaps.",
    .title = "Texture layout",
    .measurements = {{"charts", "UV charts"},
                     {"stretch_l2", "L2 stretch"},
                     {"utilisation", "UV area used", "share"},
                     {"flipped", "flipped in UV", "", -keypose::kAnyNumber, 0}},
    .inputs = {{.name = "clean",
                .kind = "path",
                .help = "closed mesh (.ply, .obj, .off, .stl), or a folder of frames, whose first "
                        "is meant",
                .file = ""}},
    .outputs = {{.name = "unwrapped",
                 .kind = "file",
                 .help = "the same mesh with UVs",
                 .file = "unwrapped.obj"}},
    .tools = {},
    .cores = 0,
    .memory_gib = 1,
    .common = {"texture_size"}};

}  // namespace

int main(int argc, char** argv) {
  return keypose::RunStage<UnwrapStageOptions>(argc, argv, kSpec, Run);
}
