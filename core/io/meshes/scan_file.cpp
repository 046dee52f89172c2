#include "core/io/meshes/scan_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/io/meshes/beside.h"
#include "core/io/meshes/glb_mesh.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/obj_file.h"
#include "core/io/meshes/obj_look.h"
#include "core/io/meshes/off_file.h"
#include "core/io/meshes/ply_io.h"
#include "core/io/meshes/ply_mesh.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/meshes/stl_file.h"
#include "core/io/meshes/texture_pages.h"
#include "core/io/meshes/zipped_scan.h"
#include "core/io/text/files.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

/// Makes one texture of all pages.
/// @param files  of the pictures; empty: they lie inside of the mesh's file
void TakeLook(const fs::path& path, PagedMesh paged, const std::vector<fs::path>& files,
              Scan* scan) {
  if (paged.pages.empty()) {
    scan->mesh = std::move(paged.mesh);
    return;
  }
  OneTexture one = JoinPages(std::move(paged), PrintableName(path));
  if (!one.why.empty()) scan->warnings.push_back(one.why);
  scan->mesh = std::move(paged.mesh);
  scan->mesh.uvs = std::move(one.uvs);
  scan->mesh.uv_faces = std::move(one.uv_faces);
  scan->texture = std::move(one.picture);
  scan->texture_ending = std::move(one.ending);
  scan->changed |= !one.as_it_was;
  if (one.as_it_was && !files.empty()) scan->texture_file = files[paged.pages[0].picture];
}

void Warn(const fs::path& path, const std::vector<std::string>& notes, Scan* scan) {
  for (const std::string& note : notes)
    scan->warnings.push_back(fmt::format("{}: {}", PrintableName(path), note));
}

Scan FromNoted(const fs::path& path, NotedMesh read) {
  Scan scan;
  Warn(path, read.notes, &scan);
  scan.mesh = std::move(read.mesh);
  return scan;
}

Scan FromGltf(const fs::path& path, bool join_seams) {
  GlbMesh read = ReadGlb(path, join_seams);
  Scan scan;
  scan.changed = true;
  scan.unit = "m";
  scan.warnings = std::move(read.warnings);
  TakeLook(path, std::move(read.paged), {}, &scan);
  return scan;
}

Scan FromObj(const fs::path& path) {
  ObjFile obj = ReadObj(path);
  Scan scan;
  scan.polygons = std::move(obj.polygons);
  ObjLook look = LookOfObj(path, std::move(obj));
  scan.changed = look.moved;
  scan.warnings = std::move(look.warnings);
  TakeLook(path, std::move(look.paged), look.files, &scan);
  return scan;
}

/// White, or the colours of the vertices.
std::vector<std::array<Eigen::Vector3d, 3>> CornerColorsOf(const Mesh& mesh) {
  std::vector<std::array<Eigen::Vector3d, 3>> colors;
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    std::array<Eigen::Vector3d, 3> corners;
    corners.fill(Eigen::Vector3d::Ones());
    for (int k = 0; k < 3 && mesh.colors.rows() > 0; ++k)
      for (int c = 0; c < 3; ++c)
        corners[k][c] = LinearFromSrgb(mesh.colors(mesh.faces(f, k), c) / 255.0);
    colors.push_back(corners);
  }
  return colors;
}

/// The pages of a PLY: its textures that are there, -1 for others.
std::vector<int> PagesOfPly(const fs::path& path, PagedMesh* paged, std::vector<fs::path>* files,
                            std::vector<std::string>* warnings) {
  std::vector<int> pages;
  for (const std::string& name : PlyNotes(path, "texturefile")) {
    const fs::path file = FileBeside(path, name);
    if (file.empty()) {
      warnings->push_back(
          fmt::format("{}: it names the texture {}, which is not there: put it beside the mesh",
                      PrintableName(path), PrintableName(name)));
      pages.push_back(-1);
      continue;
    }
    TexturePage page;
    page.picture = SizeOf(paged->pictures);
    paged->pictures.push_back({PrintableName(file.filename()), ReadFile(file)});
    files->push_back(file);
    pages.push_back(paged->PageOf(page));
  }
  return pages;
}

Scan FromPly(const fs::path& path) {
  PlyPages ply = ReadPlyPages(path);
  Scan scan;
  PagedMesh paged;
  std::vector<fs::path> files;
  const std::vector<int> pages = PagesOfPly(path, &paged, &files, &scan.warnings);
  if (!files.empty() && !ply.mesh.has_uvs()) {
    scan.warnings.push_back(
        fmt::format("{}: it names a texture, but has no texture coordinates: export it with them",
                    PrintableName(path)));
    paged.pages.clear();
  }
  paged.mesh = std::move(ply.mesh);
  if (paged.pages.empty()) {
    Warn(path, ply.notes, &scan);
    scan.mesh = std::move(paged.mesh);
    return scan;
  }
  ply.page_of_face.resize(static_cast<std::size_t>(paged.mesh.faces.rows()), 0);
  bool bare = false;
  for (const int number : ply.page_of_face) {
    const bool known = number >= 0 && number < SizeOf(pages);
    paged.page_of_face.push_back(known ? pages[number] : -1);
    bare |= paged.page_of_face.back() < 0;
  }
  if (bare) paged.corner_colors = CornerColorsOf(paged.mesh);
  paged.mesh.colors.resize(0, 3);
  TakeLook(path, std::move(paged), files, &scan);
  return scan;
}

template <class Read>
Scan FromZip(const fs::path& path, const Read& read) {
  const ZippedScan unpacked(path);
  if (MeshKindOf(unpacked.mesh()) == MeshKind::kZip)
    throw InputError(fmt::format("{} holds a ZIP file: unpack it", PrintableName(path)));
  Scan scan = read(unpacked.mesh());
  scan.changed = true;
  scan.texture_file.clear();
  return scan;
}

Scan WithoutLookFromGltf(const fs::path& path, bool join_seams) {
  GlbMesh read = ReadGlb(path, join_seams);
  Scan scan;
  scan.mesh = std::move(read.paged.mesh);
  scan.unit = "m";
  scan.changed = true;
  scan.unit = "m";
  scan.warnings = std::move(read.warnings);
  return scan;
}

}  // namespace

Scan ReadScan(const fs::path& path, bool join_seams) {
  switch (MeshKindOf(path)) {
    case MeshKind::kGltf:
      return FromGltf(path, join_seams);
    case MeshKind::kObj:
      return FromObj(path);
    case MeshKind::kPly:
      return FromPly(path);
    case MeshKind::kZip:
      return FromZip(path, [&](const fs::path& mesh) { return ReadScan(mesh, join_seams); });
    case MeshKind::kOff:
      return FromNoted(path, ReadOff(path));
    case MeshKind::kStl:
      return FromNoted(path, ReadStl(path));
  }
  return {};
}

Scan ReadScanWithoutLook(const fs::path& path, bool join_seams) {
  const MeshKind kind = MeshKindOf(path);
  if (kind == MeshKind::kGltf) return WithoutLookFromGltf(path, join_seams);
  if (kind == MeshKind::kZip)
    return FromZip(path,
                   [&](const fs::path& mesh) { return ReadScanWithoutLook(mesh, join_seams); });
  Scan scan;
  PolygonMesh read = ReadPolygonMesh(path);
  scan.mesh = std::move(read.mesh);
  scan.polygons = std::move(read.polygons);
  return scan;
}

}  // namespace keypose
