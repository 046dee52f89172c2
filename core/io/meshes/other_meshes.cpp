#include "core/io/meshes/other_meshes.h"

#include <algorithm>
#include <array>

#include "core/values/file_names.h"

namespace keypose {
namespace {

using namespace std::string_view_literals;

/// What to do with each.
constexpr const char* kBlender = "open it in Blender and export it as OBJ, PLY, STL or GLB";
constexpr const char* kItsProgram =
    "export it as OBJ, PLY, STL or GLB from the program that made it";
constexpr const char* kCad = "export it as OBJ, PLY or STL from a CAD program, such as FreeCAD";
constexpr const char* kPrint =
    "export it as OBJ, PLY or STL from the program that made it, or from a slicer";
constexpr const char* kVtk = "open it in ParaView and export it as PLY or STL";
constexpr const char* kGmsh = "open it in Gmsh and export it as PLY or STL";
constexpr const char* kPoints =
    "it holds points and no faces; make a mesh of them in CloudCompare or MeshLab and export it as "
    "PLY";
constexpr const char* kSplats =
    "it holds no faces; export a mesh as OBJ, PLY or GLB from the program that made it";
constexpr const char* kUnpack = "unpack it, and give the mesh in it";
constexpr const char* kNoMesh = "give a mesh (OBJ, PLY, OFF, STL, GLB)";

struct KnownStart {
  std::string_view start;
  const char* kind;
  const char* cure;
};

constexpr KnownStart kStarts[] = {
    {"Kaydara FBX", "an FBX file", kBlender},
    {"; FBX", "an FBX file", kBlender},
    {";FBX", "an FBX file", kBlender},
    {"#usda", "a USD file", kBlender},
    {"PXR-USDC", "a USD file", kBlender},
    {"BLENDER", "a Blender file", kBlender},
    {"Ogawa", "an Alembic file", kBlender},
    {"\x89HDF", "an HDF5 file (an older Alembic file?)", kItsProgram},
    {"VRML", "a VRML file", kBlender},
    {"#VRML", "a VRML file", kBlender},
    {"#X3D", "an X3D file", kBlender},
    {"#Inventor", "an Open Inventor file", kItsProgram},
    {"xof 0", "a DirectX file (.x)", kItsProgram},
    {"//Maya", "a Maya file", kItsProgram},
    {"FOR4", "a Maya file", kItsProgram},
    {"FOR8", "a Maya file", kItsProgram},
    {"QC4D", "a Cinema 4D file", kItsProgram},
    {"3D Geometry File Format", "a Rhino file (.3dm)", kItsProgram},
    {"PMX ", "an MMD model (.pmx)", kItsProgram},
    {"Pmd\0\0\x80?"sv, "an MMD model (.pmd)", kItsProgram},
    {"U3D\0"sv, "a U3D file", kItsProgram},
    {"OCTM", "an OpenCTM file (.ctm)", "open it in MeshLab and export it as OBJ, PLY or STL"},
    {"DRACO", "a Draco file (.drc)", kBlender},
    {"MeshVersionFormatted", "a Medit file (.mesh)", kGmsh},
    {"$MeshFormat", "a Gmsh file (.msh)", kGmsh},
    {"ISO-10303-21", "a STEP file", kCad},
    {"# vtk DataFile", "a VTK file", kVtk},
    {"# .PCD", "a point cloud of PCL (.pcd)", kPoints},
    {"LASF", "a LAS or LAZ point cloud", kPoints},
    {"ASTM-E57", "an E57 point cloud", kPoints},
    {"NGSP", "a file of Gaussian splats (.spz)", kSplats},
    {"HIERARCHY", "a BVH file, a motion without a mesh", kNoMesh},
    {"\x1f\x8b", "a file packed by gzip", kUnpack},
    {"(\xb5/\xfd", "a file packed by Zstandard (a Blender file?)",
     "open it in Blender and export it as OBJ, PLY, STL or GLB, or unpack it"},
    {"7z\xbc\xaf", "a file packed by 7-Zip", kUnpack},
    {"Rar!", "a file packed by RAR", kUnpack},
    {"BZh", "a file packed by bzip2", kUnpack},
    {"\xfd"
     "7zXZ",
     "a file packed by xz", kUnpack},
    {"%PDF", "a PDF", kNoMesh},
    {"\xff\xd8\xff", "a JPEG picture", kNoMesh},
    {"\x89PNG", "a PNG picture", kNoMesh},
    {"version https://git-lfs", "a pointer of Git LFS in place of the file",
     "fetch the file itself (git lfs pull)"}};

/// Of a text in angle brackets.
constexpr KnownStart kTags[] = {
    {"<COLLADA", "a Collada file", kBlender},
    {"<X3D", "an X3D file", kBlender},
    {"<amf", "an AMF file", kPrint},
    {"<VTKFile", "a VTK file", kVtk},
    {"<kml", "a KML file", kItsProgram},
    {"<svg", "an SVG file", kItsProgram},
    {"<html", "a web page and no mesh: the download failed", "fetch the file itself"},
    {"<?xml", "an XML file", kItsProgram}};

/// By endings; of some the bytes say nothing.
constexpr KnownStart kEndings[] = {
    {".fbx", "an FBX file", kBlender},
    {".dae", "a Collada file", kBlender},
    {".usd", "a USD file", kBlender},
    {".usda", "a USD file", kBlender},
    {".usdc", "a USD file", kBlender},
    {".usdz", "a USD file", kBlender},
    {".blend", "a Blender file", kBlender},
    {".abc", "an Alembic file", kBlender},
    {".x3d", "an X3D file", kBlender},
    {".wrl", "a VRML file", kBlender},
    {".3ds", "a 3DS file", kItsProgram},
    {".drc", "a Draco file", kBlender},
    {".3mf", "a 3MF file", kPrint},
    {".model", "a 3MF model", kPrint},
    {".amf", "an AMF file", kPrint},
    {".ctm", "an OpenCTM file", "open it in MeshLab and export it as OBJ, PLY or STL"},
    {".x", "a DirectX file", kItsProgram},
    {".ma", "a Maya file", kItsProgram},
    {".mb", "a Maya file", kItsProgram},
    {".max", "a 3ds Max file", kItsProgram},
    {".c4d", "a Cinema 4D file", kItsProgram},
    {".lwo", "a LightWave file", kItsProgram},
    {".ztl", "a ZBrush file", kItsProgram},
    {".zpr", "a ZBrush file", kItsProgram},
    {".skp", "a SketchUp file", kItsProgram},
    {".3dm", "a Rhino file", kItsProgram},
    {".step", "a STEP file", kCad},
    {".stp", "a STEP file", kCad},
    {".iges", "an IGES file", kCad},
    {".igs", "an IGES file", kCad},
    {".dxf", "a DXF file", kItsProgram},
    {".msh", "a .msh file (Gmsh, Fluent)", kGmsh},
    {".mesh", "a .mesh file (Medit, Ogre)", kItsProgram},
    {".vtk", "a VTK file", kVtk},
    {".vtp", "a VTK file", kVtk},
    {".vtu", "a VTK file", kVtk},
    {".pcd", "a point cloud of PCL", kPoints},
    {".las", "a LAS point cloud", kPoints},
    {".laz", "a LAZ point cloud", kPoints},
    {".e57", "an E57 point cloud", kPoints},
    {".xyz", "a list of points", kPoints},
    {".pts", "a list of points", kPoints},
    {".ptx", "a list of points", kPoints},
    {".asc", "a list of points", kPoints},
    {".csv", "a list of points", kPoints},
    {".splat", "a file of Gaussian splats", kSplats},
    {".ksplat", "a file of Gaussian splats", kSplats},
    {".spz", "a file of Gaussian splats", kSplats},
    {".sog", "a file of Gaussian splats", kSplats},
    {".pmx", "an MMD model", kItsProgram},
    {".pmd", "an MMD model", kItsProgram},
    {".u3d", "a U3D file", kItsProgram},
    {".kmz", "a KML file", kItsProgram},
    {".zae", "a Collada file", kBlender},
    {".zip", "a ZIP file", kUnpack}};

bool IsNumberLine(std::string_view line) {
  return line.find_first_of("0123456789") != line.npos &&
         line.find_first_not_of("0123456789+-.eE,; \t\r") == line.npos;
}

/// Whether the first two lines hold nothing but numbers, as lists of points do.
bool IsNumbers(std::string_view head) {
  int lines = 0;
  while (!head.empty() && lines < 2) {
    const std::size_t end = std::min(head.find('\n'), head.size());
    if (!IsNumberLine(head.substr(0, end))) return false;
    head.remove_prefix(std::min(end + 1, head.size()));
    ++lines;
  }
  return lines == 2;
}

OtherMesh TaggedMesh(std::string_view text) {
  const std::string small = LowerCase(std::string(text));
  for (const KnownStart& tag : kTags)
    if (small.find(LowerCase(std::string(tag.start))) != small.npos) return {tag.kind, tag.cure};
  return {};
}

}  // namespace

OtherMesh OtherMeshOf(std::string_view head) {
  // Chunks: the whole file, and its version or its scene in it.
  if (head.starts_with("MM") && head.size() >= 8 &&
      (head.substr(6, 2) == "\x02\0"sv || head.substr(6, 2) == "=="))
    return {"a 3DS file", kItsProgram};
  if (head.starts_with("FORM") && head.size() >= 12 && head.substr(8, 3) == "LWO")
    return {"a LightWave file", kItsProgram};
  for (const KnownStart& known : kStarts)
    if (head.starts_with(known.start)) return {known.kind, known.cure};
  std::string_view text = head;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  if (text.starts_with('<')) return TaggedMesh(text);
  if (text.starts_with("VERSION") && text.find("\nFIELDS") != text.npos)
    return {"a point cloud of PCL (.pcd)", kPoints};
  if (IsNumbers(text)) return {"a list of points", kPoints};
  return {};
}

OtherMesh OtherMeshNamed(const std::filesystem::path& file) {
  const std::string ending = LowerExtension(file);
  for (const KnownStart& known : kEndings)
    if (ending == known.start) return {known.kind, known.cure};
  return {};
}

bool IsUtf16(std::string_view head) {
  if (head.starts_with("\xff\xfe") || head.starts_with("\xfe\xff")) return true;
  constexpr std::size_t kLooked = 16;
  if (head.size() < kLooked) return false;
  for (const std::size_t odd : {0u, 1u}) {
    bool whole = true;
    for (std::size_t i = 0; i < kLooked; ++i)
      whole &= (head[i] == '\0') == (i % 2 == odd) && static_cast<unsigned char>(head[i]) < 0x80;
    if (whole) return true;
  }
  return false;
}

}  // namespace keypose
