#include "pipeline/commands/new_project.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/io/text/yaml_edit.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

/// The folder's name without characters that YAML would need to escape.
std::string SafeName(const fs::path& folder) {
  std::string name =
      folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
  std::erase_if(name, [](unsigned char c) { return c < 32 || c == '"' || c == '\\'; });
  return name;
}

/// Not the timeline itself: the default one grows with the poses.
std::string TimelineHint(const std::vector<std::string>& poses) {
  if (poses.size() < 2) return "";
  return fmt::format(
      "# Without a timeline all poses play as a loop, each held; or name keys and times:\n"
      "# timeline: [{{pose: {}, at: 0, hold: 0.6, ease: in-out}}, {{pose: {}, at: 1.5}}]\n",
      poses[0], poses[1]);
}

std::string ShotText(const NewShot& shot) {
  std::string text =
      fmt::format("shot:\n  film: {}\n  fps: {:g}\n  shows: {{", YamlScalar(shot.film), shot.fps);
  for (std::size_t i = 0; i < shot.shows.size(); ++i)
    text += fmt::format("{}{}: {}", i ? ", " : "", shot.shows[i].first, shot.shows[i].second);
  text += "}\n";
  for (const auto& [key, path] :
       {std::pair{"plate", &shot.plate}, {"mattes", &shot.mattes}, {"holdout", &shot.holdout}})
    if (!path->empty()) text += fmt::format("  {}: {}\n", key, YamlScalar(*path));
  return text;
}

}  // namespace

std::string NewPipelineText(const fs::path& folder, const std::vector<std::string>& poses,
                            const std::string& template_pose, const std::set<std::string>& few,
                            const NewShot& shot) {
  std::string text =
      "# The poses and settings of this project. What is not set here is as in the default "
      "pipeline; see docs/pipeline.md.\n";
  text += fmt::format("name: \"{}\"\nposes:\n", SafeName(folder));
  for (const std::string& pose : poses)
    text += few.contains(pose) ? fmt::format("  {0}: {{photos: photos/{0}, method: fit}}\n", pose)
                               : fmt::format("  {0}: photos/{0}\n", pose);
  text += fmt::format("template: {}\n", template_pose);
  if (!shot.film.empty() && shot.animation_fps != 24)
    text += fmt::format("fps: {:g}\n", shot.animation_fps);
  if (!shot.film.empty()) return text + ShotText(shot);
  return text + TimelineHint(poses);
}

namespace {

/// The inputs of `export`.
std::string ExportInputs(const NewMeshes& meshes, const std::string& texture) {
  const bool carried = meshes.colors == MeshColors::kCarried;
  std::string textures = "[]";
  if (meshes.colors == MeshColors::kTemplates) textures = YamlScalar("./" + texture);
  if (meshes.colors == MeshColors::kOwn) textures = "{template: $texture, others: $texture}";
  if (carried && meshes.keep) textures = "{template: $texture, others: complete.completed}";
  const NewMesh* polygons = meshes.template_polygons();
  return fmt::format("{{textures: {}{}}}", textures,
                     polygons ? ", polygons: " + YamlScalar("./" + polygons->mesh) : "");
}

/// @param texture  the template's
std::string MeshSteps(const NewMeshes& meshes, const std::string& texture) {
  const bool carried = meshes.colors == MeshColors::kCarried;
  std::vector<std::string> off = {"capture", "sfm", "masks", "dense", "mesh", "refine"};
  if (!carried) off.insert(off.end(), {"bake", "complete"});
  if (meshes.same_faces) off.insert(off.end(), {"cleanup", "unwrap", "register"});
  std::string text;
  for (const std::string& step : off) text += fmt::format("  {}: {{enabled: false}}\n", step);
  if (!meshes.same_faces) {
    text += fmt::format("  cleanup: {{{}inputs: {{surface: $mesh, images: [], model: []}}{}}}\n",
                        meshes.keep ? "for: pair, " : "",
                        carried ? ", options: {drop_layout: true}" : "");
    if (meshes.keep) text += "  unwrap: {inputs: {clean: $mesh}, options: {keep: true}}\n";
  } else {
    text += "  interpolate: {inputs: {keys: {template: $mesh, others: $mesh}}}\n";
  }
  if (carried)
    text +=
        "  bake: {inputs: {images: [], model: [], scan: $mesh, scan_texture: $texture}, options: "
        "{texture_size: 0}}\n";
  if (!carried || meshes.keep)
    text += fmt::format("  export: {{inputs: {}}}\n", ExportInputs(meshes, texture));
  return text;
}

}  // namespace

const NewMesh* NewMeshes::template_polygons() const {
  if (!keep && !same_faces) return nullptr;
  const auto found = std::find_if(poses.begin(), poses.end(), [&](const NewMesh& pose) {
    return pose.name == template_pose && pose.polygons;
  });
  return found == poses.end() ? nullptr : &*found;
}

std::string NewMeshesText(const fs::path& folder, const NewMeshes& meshes) {
  std::string text =
      "# Poses from meshes; see docs/pipeline.md. Of meshes in millimetres, or with y up, add\n"
      "#   options: {export: {unit: mm, up: y}, interpolate: {align: rigid}, cleanup: {support: "
      "keep}}\n";
  text += fmt::format("name: \"{}\"\nposes:\n", SafeName(folder));
  std::vector<std::string> names;
  std::string own;  // the template's texture
  for (const NewMesh& pose : meshes.poses) {
    const std::string texture =
        pose.texture.empty() ? "" : ", texture: " + YamlScalar(pose.texture);
    text += fmt::format("  {}: {{mesh: {}{}}}\n", pose.name, YamlScalar(pose.mesh), texture);
    names.push_back(pose.name);
    if (pose.name == meshes.template_pose) own = pose.texture;
  }
  text += fmt::format("template: {}\n", meshes.template_pose);
  text += TimelineHint(names);
  return text + "steps:\n" + MeshSteps(meshes, own);
}

std::string NewPerformanceText(const fs::path& folder, const NewPerformance& performance) {
  std::string text =
      "# The shots and settings of this performance. What is not set here is as in the default "
      "pipeline performance.yaml; see docs/pipeline.md.\n";
  text += fmt::format("kind: performance\nname: \"{}\"\nshots:\n", SafeName(folder));
  for (const auto& [name, films] : performance.shots) {
    text += fmt::format("  {}:\n    video: {}\n", name, YamlScalar(films));
    if (!performance.calibration.empty())
      text += fmt::format("    calibration: {}\n", YamlScalar(performance.calibration));
  }
  for (const auto& [key, path] : {std::pair{"scan", &performance.scan},
                                  {"texture", &performance.texture},
                                  {"marks", &performance.marks}})
    if (!path->empty()) text += fmt::format("{}: {}\n", key, YamlScalar(*path));
  if (performance.video3d || performance.surface)
    text += "steps:\n  transfer: {options: {space: template}}  # the mesh lies over the films\n";
  if (performance.surface) text += "  follow: {enabled: true}\n";
  if (performance.video3d) text += "  layout: {enabled: true}\n  video3d: {enabled: true}\n";
  return text;
}

}  // namespace keypose::pipeline
