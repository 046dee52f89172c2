#include "core/io/meshes/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include "core/io/meshes/glb_mesh.h"
#include "core/io/meshes/gltf_file.h"
#include "core/io/meshes/obj_file.h"
#include "core/io/meshes/off_file.h"
#include "core/io/meshes/other_meshes.h"
#include "core/io/meshes/ply_mesh.h"
#include "core/io/meshes/stl_file.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

/// Whether the first statement is one of OBJ, or any is a vertex.
bool LooksLikeObj(std::string_view head) {
  if (head.starts_with("\xef\xbb\xbf")) head.remove_prefix(3);
  std::istringstream in{std::string(head)};
  bool first = true;
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word) || word[0] == '#') continue;
    double x = 0, y = 0, z = 0;
    if (word == "v" && words >> x >> y >> z) return true;
    for (const char* key :
         {"v",         "vn",    "vt",    "vp",     "vc",       "f",        "o",
          "g",         "s",     "mg",    "mtllib", "usemtl",   "usemap",   "maplib",
          "l",         "p",     "lod",   "cstype", "deg",      "bmat",     "step",
          "curv",      "curv2", "surf",  "bevel",  "c_interp", "d_interp", "shadow_obj",
          "trace_obj", "ctech", "stech", "call",   "csh"})
      if (first && word == key) return true;
    first = false;
  }
  return first;  // comments only: an OBJ without vertices
}

[[noreturn]] void RefuseOther(const fs::path& path, const OtherMesh& other) {
  throw InputError(
      fmt::format("{} is {}, which is not read: {}", path.string(), other.kind, other.cure));
}

/// @throws InputError  says what the file is, where that is known
[[noreturn]] void RefuseUnknown(const fs::path& path, std::string_view head) {
  const OtherMesh other = OtherMeshOf(head), named = OtherMeshNamed(path);
  if (other.kind == "a list of points" && LowerExtension(path) == ".off")
    throw InputError(path.string() +
                     " does not begin with the word OFF: write it as the first line");
  if (!other.kind.empty()) RefuseOther(path, other);
  if (!named.kind.empty()) RefuseOther(path, named);
  throw InputError(path.string() +
                   " is not a PLY, OBJ, OFF, STL or glTF mesh (judged by its first bytes): " +
                   "export it as one of these from the program that made it");
}

}  // namespace

MeshKind MeshKindOf(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("mesh " + path.string() + " does not exist");
  if (!fs::is_regular_file(path)) throw DiskError("mesh " + path.string() + " is not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError("cannot open mesh " + path.string());
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  in.close();
  if (head.empty()) throw InputError("mesh " + path.string() + " is empty (0 bytes)");
  if (IsWholeBinaryStl(path, head)) return MeshKind::kStl;
  if (IsUtf16(head))
    throw InputError(path.string() + " is text in UTF-16, which is not read: save it as UTF-8");
  const auto next_word = [&head](std::size_t from) {
    return std::min(head.find_first_not_of(" \t\r\n\xef\xbb\xbf", from), head.size());
  };
  std::size_t word = next_word(0);
  while (word < head.size() && head[word] == '#')
    word = next_word(std::min(head.find_first_of("\r\n", word), head.size()));
  const std::string start =
      LowerCase(head.substr(word, head.find_first_of(" \t\r\n", word) - word));
  if (start == "ply") return MeshKind::kPly;
  if (LooksLikeOff(head)) return MeshKind::kOff;
  if (LooksLikeGltf(head)) return MeshKind::kGltf;
  if (head.starts_with("PK\x03\x04")) return MeshKind::kZip;
  if (start == "solid") return MeshKind::kStl;
  const bool other = !OtherMeshOf(head).kind.empty();
  if (!other && LooksLikeObj(head)) return MeshKind::kObj;
  if (!other && LooksLikeBinaryStl(path, head)) return MeshKind::kStl;
  RefuseUnknown(path, head);
}

namespace {

/// The surface of a glTF. Its texture coordinates are kept where they are those of one texture.
Mesh ReadGltfMesh(const fs::path& path) {
  PagedMesh paged = ReadGlb(path).paged;
  if (paged.pages.size() > 1 || !paged.corner_colors.empty()) {
    paged.mesh.uvs.resize(0, 2);
    paged.mesh.uv_faces.resize(0, 3);
  }
  return std::move(paged.mesh);
}

}  // namespace

Mesh ReadMesh(const fs::path& path) {
  switch (MeshKindOf(path)) {
    case MeshKind::kPly:
      return ReadPlyMesh(path);
    case MeshKind::kObj:
      return ReadObj(path).mesh;
    case MeshKind::kOff:
      return ReadOff(path).mesh;
    case MeshKind::kStl:
      return ReadStl(path).mesh;
    case MeshKind::kGltf:
      return ReadGltfMesh(path);
    case MeshKind::kZip:
      throw InputError(path.string() +
                       " is a ZIP file (as .usdz and .3mf are): unpack it, or begin a project with "
                       "it by keypose init");
  }
  return {};
}

PointCloud ReadPointCloud(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("point cloud " + path.string() + " does not exist");
  if (!fs::is_regular_file(path))
    throw DiskError("point cloud " + path.string() + " is not a file");
  return ReadPlyCloud(path);
}

}  // namespace keypose
