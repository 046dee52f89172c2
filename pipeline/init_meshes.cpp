// `keypose init` with meshes that were made elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "core/file_names.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "core/io/mesh_texture.h"
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
  fs::path texture;      ///< empty: it names none that can be used
  bool colored = false;  ///< it has a texture that can be used, or colours of its vertices
};

/// @throws UsageError  no name, or not a mesh, as the other poses are
/// @throws InputError  there is no such file, or it is of a format that is not read
GivenMesh ParseMesh(const std::string& text) {
  const GivenMesh mesh{
      Composed(text.substr(0, text.find('='))), fs::absolute(FileOf(text)), {}, false};
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

/// @throws InputError  the mesh cannot be read
void FindColors(GivenMesh* mesh) {
  const MeshTexture found = FindTexture(mesh->file);
  if (!found.why.empty()) fmt::print(stderr, "warning: {}\n", found.why);
  const Mesh read = ReadMesh(mesh->file);
  if (read.has_uvs()) mesh->texture = found.file;
  mesh->colored = !mesh->texture.empty() || read.colors.rows() > 0;
}

/// Whether two files have the same bytes, as of one texture that is exported with each pose.
bool SameFile(const fs::path& a, const fs::path& b) {
  return fs::equivalent(a, b) ||
         (fs::file_size(a) == fs::file_size(b) && ReadFile(a) == ReadFile(b));
}

/// How the poses get their textures; see NewMeshes.
MeshColors ColorsOf(const std::vector<GivenMesh>& given, const GivenMesh& source,
                    const NewMeshes& meshes) {
  bool any = false, others = false, all = true;
  for (const GivenMesh& mesh : given) {
    any |= mesh.colored;
    all &= !mesh.texture.empty();
    const bool same =
        !mesh.texture.empty() && !source.texture.empty() && SameFile(mesh.texture, source.texture);
    others |= mesh.colored && !same && mesh.name != source.name;
  }
  if (meshes.same_faces && all && others && !meshes.keep) return MeshColors::kOwn;
  if (meshes.same_faces || (meshes.keep && !others))
    return source.texture.empty() ? MeshColors::kNone : MeshColors::kTemplates;
  return any ? MeshColors::kCarried : MeshColors::kNone;
}

bool UsesTexture(const GivenMesh& mesh, const GivenMesh& source, MeshColors colors) {
  if (mesh.texture.empty() || colors == MeshColors::kNone) return false;
  return colors != MeshColors::kTemplates || mesh.name == source.name;
}

NewMesh Copied(RealDisk& disk, const GivenMesh& mesh, bool with_texture, const fs::path& folder) {
  NewMesh copy{mesh.name, "meshes/" + mesh.name + LowerExtension(mesh.file), ""};
  disk.Copy(mesh.file, folder / copy.mesh);
  fmt::print("{}: copied to {}\n", mesh.name, (folder / copy.mesh).string());
  if (!with_texture) return copy;
  copy.texture = "meshes/" + mesh.name + "_texture" + LowerExtension(mesh.texture);
  disk.Copy(mesh.texture, folder / copy.texture);
  fmt::print("  with its texture {}\n", PrintableName(mesh.texture));
  return copy;
}

void TellColors(const NewMeshes& meshes, const GivenMesh& source) {
  if (meshes.colors != MeshColors::kCarried) return;
  if (meshes.keep)
    fmt::print("the other poses' own colours will be carried to '{}'\n", source.name);
  else
    fmt::print(
        "the meshes get new faces and one layout, into which their colours are carried; to keep "
        "those of '{}': --texture {}\n",
        source.name, source.texture.empty() ? "FILE" : ShellWord(source.texture.string()));
}

}  // namespace

bool NamesMesh(const InitOptions& options) {
  return std::any_of(options.poses.begin(), options.poses.end(), IsMesh);
}

ExitCode InitMeshes(const InitOptions& options) {
  const fs::path folder = fs::absolute(WithHome(options.folder)).lexically_normal();
  std::vector<GivenMesh> given = ParseMeshes(options);
  NewMeshes meshes;
  meshes.same_faces = options.same_faces;
  meshes.template_pose =
      options.template_pose.empty() ? given[0].name : Composed(options.template_pose);
  const auto source = std::find_if(given.begin(), given.end(), [&](const GivenMesh& mesh) {
    return mesh.name == meshes.template_pose;
  });
  if (source == given.end())
    throw UsageError(
        fmt::format("--template {}: there is no pose of that name", options.template_pose));
  meshes.keep = !options.texture.empty();
  const fs::path texture = meshes.keep ? ParseTexture(options.texture) : fs::path();
  RequireNoProject(folder);
  for (GivenMesh& mesh : given) FindColors(&mesh);
  if (meshes.keep) source->texture = texture, source->colored = true;
  meshes.colors = ColorsOf(given, *source, meshes);
  RealDisk disk;
  for (const GivenMesh& mesh : given)
    meshes.poses.push_back(Copied(disk, mesh, UsesTexture(mesh, *source, meshes.colors), folder));
  disk.Write(folder / "pipeline.yaml", NewMeshesText(folder, meshes));
  TellColors(meshes, *source);
  fmt::print("next: keypose run -C {}\n", ShellWord(options.folder));
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
