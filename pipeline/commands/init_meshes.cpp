// `keypose init` with meshes that were made elsewhere.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <optional>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/pictures/plain_texture.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/commands/keypose_commands.h"
#include "pipeline/commands/new_project.h"
#include "pipeline/disk/project_paths.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

fs::path FileOf(const std::string& pose) {
  const auto equals = pose.find('=');
  if (equals == std::string::npos) return {};
  return WithHome(pose.substr(equals + 1));
}

/// By its name, or, where that is no photograph's, by its content.
bool IsMesh(const std::string& pose) {
  const fs::path file = FileOf(pose);
  if (fs::is_directory(file)) return false;
  if (IsMeshName(file)) return true;
  if (!fs::is_regular_file(file) || IsPhotographName(file) || IsRawName(file)) return false;
  try {
    MeshKindOf(file);
  } catch (const Error&) {
    return false;
  }
  return true;
}

/// The ending that a mesh has in the project.
std::string EndingOf(const fs::path& file) {
  if (IsMeshName(file)) return LowerExtension(file);
  switch (MeshKindOf(file)) {
    case MeshKind::kPly:
      return ".ply";
    case MeshKind::kOff:
      return ".off";
    case MeshKind::kStl:
      return ".stl";
    default:
      return ".obj";  // others are written anew
  }
}

struct GivenMesh {
  std::string name;
  fs::path file;
  fs::path texture = {};  ///< empty: none that can be used, or it is inside of the scan
  Scan scan = {};
  bool colored = false;   ///< it has a texture that can be used, or colours of its vertices
  std::string told = {};  ///< what was read, in words

  bool textured() const { return !texture.empty() || !scan.texture.empty(); }
  /// Of glTF, whose textures are inside, profiles do not count.
  std::string TextureBytes() const {
    const bool own = !texture.empty();
    return PlainTexture(own ? ReadFile(texture) : scan.texture, PrintableName(own ? texture : file),
                        own);
  }
  std::string TextureEnding() const {
    return texture.empty() ? scan.texture_ending : LowerExtension(texture);
  }
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
  MeshKindOf(mesh.file);  // refuses other formats by their names
  return mesh;
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

void Warn(const std::string& text) { fmt::print(stderr, "warning: {}\n", text); }

/// What was read, in words.
std::string Told(const Scan& scan, bool textured, bool look_given) {
  const Mesh& mesh = scan.mesh;
  const std::size_t faces =
      scan.polygons.sizes.empty() ? mesh.faces.rows() : scan.polygons.sizes.size();
  std::string size = "no size";
  if (mesh.points.rows() > 0) {
    const Eigen::RowVector3d span =
        mesh.points.colwise().maxCoeff() - mesh.points.colwise().minCoeff();
    size = fmt::format("{:.4g} x {:.4g} x {:.4g} {}", span[0], span[1], span[2],
                       scan.unit.empty() ? "(its file names no unit)" : scan.unit);
  }
  const char* look = "has no colours";
  if (look_given)
    look = "takes the texture that is given";
  else if (textured)
    look = "has a texture";
  else if (mesh.colors.rows() > 0)
    look = "has colours of its vertices";
  return fmt::format("{} vertices, {} faces, {}, {}", mesh.points.rows(), faces, size, look);
}

/// An OBJ that was cut off has its vertices before its faces; other formats count both.
void WarnOfLooseVertices(const GivenMesh& mesh) {
  const Mesh& read = mesh.scan.mesh;
  if (MeshKindOf(mesh.file) != MeshKind::kObj) return;
  std::vector<char> used(static_cast<std::size_t>(read.points.rows()), 0);
  for (Eigen::Index f = 0; f < read.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) used[static_cast<std::size_t>(read.faces(f, k))] = 1;
  const auto loose = std::count(used.begin(), used.end(), 0);
  if (read.faces.rows() == 0 || loose * 20 <= std::ssize(used)) return;
  Warn(fmt::format(
      "{}: {} of {} vertices are in no face: if the mesh has a hole where they lie, the file was "
      "not written to its end; export it again",
      mesh.file.string(), loose, used.size()));
}

/// @param look_given  its texture comes from elsewhere: it keeps its coordinates
/// @throws InputError  the mesh cannot be read
void FindColors(GivenMesh* mesh, bool same_faces, bool look_given) {
  mesh->scan =
      look_given ? ReadScanWithoutLook(mesh->file, !same_faces) : ReadScan(mesh->file, !same_faces);
  for (const std::string& warning : mesh->scan.warnings) Warn(warning);
  mesh->texture = mesh->scan.texture_file;
  mesh->colored = mesh->textured() || mesh->scan.mesh.colors.rows() > 0;
  mesh->told = Told(mesh->scan, mesh->textured(), look_given);
  if (mesh->scan.mesh.faces.rows() == 0 && mesh->scan.polygons.sizes.empty())
    throw InputError(fmt::format(
        "--pose {}: {} has {} vertices and no faces; a pose needs a surface: export one, or make "
        "it "
        "of the points (MeshLab: Filters > Remeshing > Surface Reconstruction: Screened Poisson)",
        mesh->name, mesh->file.string(), mesh->scan.mesh.points.rows()));
  WarnOfLooseVertices(*mesh);
  if (!mesh->texture.empty()) mesh->scan.texture.clear();  // it is read when it is copied
  if (!mesh->scan.changed) mesh->scan.mesh = {};
}

/// How the poses get their textures; see NewMeshes.
MeshColors ColorsOf(const std::vector<GivenMesh>& given, const GivenMesh& source,
                    const NewMeshes& meshes) {
  bool any = false, others = false, all = true;
  for (const GivenMesh& mesh : given) {
    any |= mesh.colored;
    all &= mesh.textured();
    // One texture may be exported with each pose.
    const bool same = mesh.textured() && source.textured() &&
                      (mesh.name == source.name || mesh.TextureBytes() == source.TextureBytes());
    others |= mesh.colored && !same && mesh.name != source.name;
  }
  if (meshes.same_faces && all && others && !meshes.keep) return MeshColors::kOwn;
  if (meshes.same_faces || (meshes.keep && !others))
    return source.textured() ? MeshColors::kTemplates : MeshColors::kNone;
  return any ? MeshColors::kCarried : MeshColors::kNone;
}

bool UsesTexture(const GivenMesh& mesh, const GivenMesh& source, MeshColors colors) {
  if (!mesh.textured() || colors == MeshColors::kNone) return false;
  return colors != MeshColors::kTemplates || mesh.name == source.name;
}

/// Writes a mesh that is not as in its file as one that stages read.
/// @return  its ending
std::string WriteChanged(const GivenMesh& mesh, const fs::path& stem, const std::string& texture) {
  const std::string ending = mesh.scan.mesh.colors.rows() > 0 ? ".ply" : ".obj";
  fs::create_directories(stem.parent_path());
  if (ending == ".obj")
    WritePolygonObj(stem.string() + ending, {mesh.scan.mesh, mesh.scan.polygons}, texture);
  else
    WriteMesh(stem.string() + ending, mesh.scan.mesh);
  return ending;
}

NewMesh Copied(RealDisk& disk, const GivenMesh& mesh, bool with_texture, const fs::path& folder) {
  const std::string stem = "meshes/" + mesh.name,
                    texture = with_texture ? mesh.name + "_texture" + mesh.TextureEnding() : "";
  NewMesh copy{mesh.name, stem + EndingOf(mesh.file), ""};
  if (mesh.scan.changed)
    copy.mesh = stem + WriteChanged(mesh, folder / stem, texture);
  else
    disk.Copy(mesh.file, folder / copy.mesh);
  copy.polygons = !mesh.scan.polygons.sizes.empty() && !copy.mesh.ends_with(".ply");
  fmt::print("{}: copied to {}\n  {}\n", mesh.name, (folder / copy.mesh).string(), mesh.told);
  if (!with_texture) return copy;
  copy.texture = "meshes/" + texture;
  disk.Write(folder / copy.texture, mesh.TextureBytes());
  fmt::print("  with its texture {}\n",
             mesh.texture.empty() ? "from inside" : PrintableName(mesh.texture));
  return copy;
}

void TellColors(const NewMeshes& meshes, const GivenMesh& source, const fs::path& folder) {
  if (meshes.colors != MeshColors::kCarried) return;
  if (meshes.keep) {
    fmt::print("the other poses' own colours will be carried to '{}'\n", source.name);
    return;
  }
  fmt::print("the mesh gets new faces and a new layout, into which all colours are carried\n");
  if (!source.textured()) return;
  const fs::path written = folder / "meshes" / source.name,
                 inside = written.string() + "_texture" + source.TextureEnding(),
                 texture = source.texture.empty() ? inside : source.texture;
  // A layout that was made here belongs to the mesh that was written with it.
  const std::string mesh =
      source.scan.changed
          ? fmt::format("--pose {} ", ShellWord(source.name + "=" + written.string() + ".obj"))
          : "";
  fmt::print("  to keep those of '{}': init {}--texture {}\n", source.name, mesh,
             ShellWord(texture.string()));
}

/// What becomes of the quads that an artist drew.
void TellPolygons(const NewMeshes& meshes, const GivenMesh& source) {
  if (source.scan.polygons.sizes.empty()) return;
  if (meshes.template_polygons())
    fmt::print("the quads and polygons of '{}' will be the faces of OBJ, USD and FBX\n",
               source.name);
  else
    Warn(fmt::format(
        "the quads and polygons of '{}' become triangles, because {}: they stay with --texture, "
        "or with --same-faces where all poses have them",
        source.name,
        meshes.keep || meshes.same_faces ? "it has colours of vertices" : "it is meshed anew"));
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
  for (GivenMesh& mesh : given)
    FindColors(&mesh, meshes.same_faces, meshes.keep && mesh.name == source->name);
  if (meshes.keep) {
    source->texture = texture;
    source->colored = true;
  }
  meshes.colors = ColorsOf(given, *source, meshes);
  RealDisk disk;
  for (const GivenMesh& mesh : given)
    meshes.poses.push_back(Copied(disk, mesh, UsesTexture(mesh, *source, meshes.colors), folder));
  disk.Write(folder / "pipeline.yaml", NewMeshesText(folder, meshes));
  TellColors(meshes, *source, folder);
  TellPolygons(meshes, *source);
  fmt::print("next: keypose run -C {}\n", ShellWord(options.folder));
  return ExitCode::kOk;
}

}  // namespace keypose::pipeline
