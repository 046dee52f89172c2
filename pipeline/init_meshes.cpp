// `keypose init` with meshes that were made elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/file_names.h"
#include "core/io/photograph_files.h"
#include "pipeline/commands.h"
#include "pipeline/new_project.h"
#include "pipeline/project_paths.h"
#include "pipeline/real_disk.h"
#include "pipeline/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

fs::path FileOf(const std::string& pose) {
  const auto equals = pose.find('=');
  if (equals == std::string::npos) return {};
  return WithHome(pose.substr(equals + 1));
}

bool IsMesh(const std::string& pose) {
  const fs::path file = FileOf(pose);
  return IsMeshName(file) && !fs::is_directory(file);
}

struct GivenMesh {
  std::string name;
  fs::path file;
};

/// @throws UsageError  no name, or not a mesh, as the other poses are
/// @throws InputError  there is no such file, or it is of a format that is not read
GivenMesh ParseMesh(const std::string& text) {
  const GivenMesh mesh{Composed(text.substr(0, text.find('='))), fs::absolute(FileOf(text))};
  if (!IsName(mesh.name))
    throw UsageError(fmt::format("--pose {}: a pose's name may have {}", text, kNameRule));
  if (!IsMesh(text))
    throw UsageError(fmt::format(
        "--pose {}: the other poses are meshes; a project has either meshes or photographs", text));
  if (!fs::is_regular_file(mesh.file))
    throw InputError(fmt::format("--pose {}: there is no file {}", text, mesh.file.string()));
  const std::string extension = LowerExtension(mesh.file);
  for (const char* read : {".obj", ".ply", ".off", ".stl"})
    if (extension == read) return mesh;
  throw InputError(
      fmt::format("--pose {}: {} files are not read; open it in Blender and export it as OBJ "
                  "(Wavefront)",
                  text, extension));
}

std::vector<GivenMesh> ParseMeshes(const InitOptions& options) {
  if (!options.few.empty() || !options.scan.empty())
    throw UsageError("--few and --scan are for poses of photographs, and these are meshes");
  if (!options.film.empty() || !options.shows.empty())
    throw UsageError("--film and --shows are for poses of photographs, and these are meshes");
  std::vector<GivenMesh> meshes;
  for (const std::string& text : options.poses) {
    const GivenMesh mesh = ParseMesh(text);
    for (const GivenMesh& other : meshes)
      if (other.name == mesh.name)
        throw UsageError(fmt::format("--pose {}: there are two poses of that name", text));
    meshes.push_back(mesh);
  }
  return meshes;
}

fs::path ParseTexture(const std::string& text) {
  const fs::path file = fs::absolute(WithHome(text));
  if (!fs::is_regular_file(file))
    throw InputError(fmt::format("--texture {}: there is no file {}", text, file.string()));
  return file;
}

}  // namespace

bool NamesMesh(const InitOptions& options) {
  return std::any_of(options.poses.begin(), options.poses.end(), IsMesh);
}

ExitCode InitMeshes(const InitOptions& options) {
  const fs::path folder = fs::absolute(WithHome(options.folder)).lexically_normal();
  const std::vector<GivenMesh> given = ParseMeshes(options);
  NewMeshes meshes;
  meshes.same_faces = options.same_faces;
  meshes.template_pose =
      options.template_pose.empty() ? given[0].name : Composed(options.template_pose);
  if (std::none_of(given.begin(), given.end(),
                   [&](const GivenMesh& mesh) { return mesh.name == meshes.template_pose; }))
    throw UsageError(
        fmt::format("--template {}: there is no pose of that name", options.template_pose));
  const fs::path texture = options.texture.empty() ? fs::path() : ParseTexture(options.texture);
  RequireNoProject(folder);
  RealDisk disk;
  for (const GivenMesh& mesh : given) {
    meshes.poses.emplace_back(mesh.name, "meshes/" + mesh.name + LowerExtension(mesh.file));
    disk.Copy(mesh.file, folder / meshes.poses.back().second);
    fmt::print("{}: copied to {}\n", mesh.name, (folder / meshes.poses.back().second).string());
  }
  if (!texture.empty()) {
    meshes.texture = "meshes/texture" + LowerExtension(texture);
    disk.Copy(texture, folder / meshes.texture);
  }
  disk.Write(folder / "pipeline.yaml", NewMeshesText(folder, meshes));
  fmt::print("next: keypose run -C {}\n", ShellWord(options.folder));
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
