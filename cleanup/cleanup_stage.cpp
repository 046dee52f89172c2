// keypose-cleanup: turns a surface of any quality into a closed, oriented 2-manifold.
#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "cleanup/strategies/cleanup.h"
#include "cleanup/support/ground.h"
#include "cleanup/support/unseen.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_set.h"
#include "core/io/pictures/sight_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/memory.h"
#include "core/values/size_of.h"

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

keypose::Sight SightOf(StageContext& stage) {
  if (stage.Has("images") != stage.Has("model"))
    throw keypose::UsageError("cleanup: images and model belong together; give both, or neither");
  if (!stage.Has("images")) return {};
  return keypose::ReadSight(keypose::ReadImageSet(stage.Input("images")),
                            keypose::ReadColmapModel(stage.Input("model")));
}

void WarnOfCutHandles(StageContext& stage, const CleanupOptions& options,
                      const CleanupResult& result) {
  constexpr double kSmall = 0.0314;  // of the diagonal: the loop around a tunnel that is 1 % of the
                                     // diagonal wide; shorter loops are noise
  if (options.genus != -2 || stage.Has("images") || result.handles_cut == 0 ||
      result.largest_handle_cut_over_diag < kSmall)
    return;
  stage.Warn("cleanup cut " + std::to_string(result.handles_cut) + " of " +
             std::to_string(result.genus_before) +
             " handles, because without photographs it is not known whether one can see through "
             "them; if the figure has such a window (a hand on the hip), keep it with --genus " +
             std::to_string(result.genus_before) + ", or give --images and --model");
}

void WarnOfClosedWindows(StageContext& stage, const keypose::Sight& sight,
                         const keypose::Mesh& mesh) {
  constexpr std::size_t kEnough = 3;  // one or two may be wrong masks
  const std::vector<int> closed = keypose::ViewsWithClosedWindow(mesh, sight.lines);
  stage.Report("views_with_closed_window", keypose::SizeOf(closed));
  if (closed.size() < kEnough) return;
  std::string names;
  for (std::size_t i = 0; i < std::min(closed.size(), kEnough); ++i)
    names += (i ? ", " : "") + sight.views[closed[i]].name;
  stage.Warn(
      std::to_string(closed.size()) +
      " photographs show background inside of the figure's outline where the mesh is closed (" +
      names +
      "); if the figure has a window there, photograph it from more sides or nearer; if not, "
      "correct these masks");
}

/// A surface and the views of it, in a frame whose z = 0 is at some height.
struct Lowered {
  keypose::Mesh surface;
  std::vector<keypose::View> views;
};

Lowered Lower(const keypose::Mesh& surface, const std::vector<keypose::View>& views,
              double height) {
  Lowered lowered{surface, views};
  lowered.surface.points.col(2).array() -= height;
  for (keypose::View& view : lowered.views) {
    keypose::Rigid3& pose = view.camera_from_world;
    pose.translation += pose.rotation * Eigen::Vector3d(0, 0, height);
  }
  return lowered;
}

/// The height of the ground, if the figure stands on it: z = 0, or of the plane that masks found.
std::optional<double> Ground(StageContext& stage, const CleanupOptions& options,
                             const keypose::Mesh& surface, const keypose::Sight& sight) {
  if (!stage.Has("images") || options.ground != "auto") return std::nullopt;
  using keypose::cleanup::GroundKind;
  const keypose::ImageSet set = keypose::ReadImageSet(stage.Input("images"));
  const double height = set.floor.value_or(0);
  const GroundKind without_board = set.floor ? GroundKind::kFloor : GroundKind::kGuessed;
  const Lowered on_ground = Lower(surface, sight.views, height);
  const keypose::cleanup::Standing standing =
      keypose::cleanup::StandsOnGround(on_ground.surface, on_ground.views, sight.masks,
                                       set.board ? GroundKind::kBoard : without_board);
  stage.Report("stands_on_ground", standing.stands);
  stage.Report("outlines_end_at", standing.contact);
  if (standing.stands) return height;
  stage.Note("no soles are cut flat at the ground: " + standing.why);
  return std::nullopt;
}

CleanupResult Cleaned(StageContext& stage, const CleanupOptions& options,
                      const keypose::Mesh& surface, const keypose::Sight& sight,
                      const std::optional<double>& ground) try {
  return keypose::cleanup::MakeClosedManifold(surface, options, stage.progress(), sight.lines,
                                              ground);
} catch (const keypose::InputError& error) {
  throw keypose::InputError(stage.Input("surface").string() + ": " + error.what());
} catch (const keypose::QualityError& error) {
  throw keypose::QualityError(stage.Input("surface").string() + ": " + error.what());
}

/// @throws DiskError  the repair needs more memory than there is
keypose::Mesh ReadSurface(StageContext& stage) {
  const std::string file = stage.Input("surface").string();
  keypose::Mesh surface = keypose::ReadMesh(stage.Input("surface"));
  keypose::RequireUsable(surface, file);
  constexpr std::int64_t kBytesAFace = 200;  // measured
  keypose::RequireMemory(
      kBytesAFace * surface.face_count(),
      "cleanup: the repair of " + std::to_string(surface.face_count()) + " faces (" + file + ")");
  return surface;
}

void WarnOfLostLayout(StageContext& stage, const CleanupOptions& options,
                      const keypose::Mesh& surface) {
  if (!surface.has_uvs() || options.drop_layout) return;
  stage.Warn("cleanup makes new faces, without the texture coordinates of " +
             keypose::PrintableName(stage.Input("surface")) +
             "; a template that shall keep them is not cleaned, but given to unwrap with --keep "
             "true, and `bake --scan` carries colours to a new layout");
}

void WarnOfHandles(StageContext& stage, const CleanupOptions& options,
                   const CleanupResult& result) {
  WarnOfCutHandles(stage, options, result);
  if (options.genus >= 0 && result.genus > options.genus)
    stage.Warn(
        "the mesh has " + std::to_string(result.genus) + " handles instead of " +
        std::to_string(options.genus) +
        ": the others could not be cut without self-intersections; try another number of --faces");
}

/// How much of the mesh is a guess.
void ReportUnseen(StageContext& stage, const keypose::Mesh& mesh, const keypose::Sight& sight) {
  const keypose::cleanup::UnseenSurface unseen = keypose::cleanup::MeasureUnseen(mesh, sight.views);
  stage.Report("unseen_share", unseen.share);
  stage.Report("unseen_sole_share", unseen.sole_share);
}

/// What was mended, and what the mesh is now.
void ReportRepair(StageContext& stage, const CleanupResult& result) {
  stage.Report("faces", result.mesh.face_count());
  stage.Report("vertices", result.mesh.vertex_count());
  stage.Report("closed", true);
  stage.Report("strategy", result.strategy);
  stage.Report("holes_filled", result.holes_filled);
  stage.Report("largest_hole_over_diag", result.largest_hole_over_diag);
  stage.Report("components", result.components);
  stage.Report("components_removed", result.components_removed);
  stage.Report("supports_removed", result.supports_removed);
  stage.Report("cut_below_ground_over_diag", result.cut_below_ground_over_diag);
  stage.Report("merged_vertices", result.merged_vertices);
  stage.Report("self_intersections_before", result.self_intersections_before);
  stage.Report("self_intersections", result.self_intersections);
  stage.Report("genus", result.genus);
  stage.Report("genus_before", result.genus_before);
  stage.Report("handles_cut", result.handles_cut);
  stage.Report("handles_seen_through", result.handles_seen_through);
}

/// How large the mesh is, how good its faces, and how far it is from what it was made of.
void ReportShape(StageContext& stage, const keypose::Mesh& surface, const CleanupResult& result) {
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
}

void Run(StageContext& stage, const CleanupOptions& options) {
  keypose::RequireMeshName(stage.Output("clean"));
  const keypose::Mesh surface = ReadSurface(stage);
  WarnOfLostLayout(stage, options, surface);
  const keypose::Sight sight = SightOf(stage);
  const std::optional<double> ground = Ground(stage, options, surface, sight);
  const CleanupResult result = Cleaned(stage, options, surface, sight, ground);
  if (stage.Has("images")) {
    WarnOfClosedWindows(stage, sight, result.mesh);
    ReportUnseen(stage, result.mesh, sight);
  }
  WarnOfHandles(stage, options, result);
  stage.Report("input_faces", surface.face_count());
  ReportRepair(stage, result);
  ReportShape(stage, surface, result);
  keypose::WriteMesh(stage.Output("clean"), result.mesh);
}

const StageSpec kSpec = {
    .name = "cleanup",
    .version = "13",
    .summary =
        "Repairs a surface into a closed, oriented 2-manifold without self-intersections at the "
        "wanted size.",
    .title = "Clean mesh",
    .measurements = {{"faces", "faces"},
                     {"closed", "closed 2-manifold", "", 1},
                     {"holes_filled", "holes filled"},
                     {"self_intersections", "self-intersections", "", -keypose::kAnyNumber, 0},
                     {"genus", "genus"},
                     {"strategy", "repair strategy"},
                     {"unseen_share", "surface that no camera saw, soles left out", "share",
                      -keypose::kAnyNumber, 0.1},
                     {"distance_to_input_p99_over_diag", "distance of the mesh to the scan, 99 %",
                      "diagonal"},
                     {"distance_from_input_p99_over_diag", "distance of the scan to the mesh, 99 %",
                      "diagonal"}},
    .inputs = {{.name = "surface",
                .kind = "file",
                .help = "triangles of any quality (.ply, .obj, .off, .stl)",
                .file = ""},
               {.name = "images",
                .kind = "folder",
                .help = "photographs with masks: handles that they see through stay",
                .optional = true},
               {.name = "model",
                .kind = "folder",
                .help = "COLMAP model of their cameras, in the surface's frame",
                .optional = true}},
    .outputs = {{.name = "clean", .kind = "file", .help = "the closed mesh", .file = "clean.ply"}},
    .tools = {},
    .cores = 1,
    .memory_gib = 2,
    .common = {"faces", "genus", "support", "keep_components"}};

}  // namespace

int main(int argc, char** argv) {
  return keypose::RunStage<CleanupOptions>(argc, argv, kSpec, Run);
}
