// What is given as a mesh and is none that is read is called what it is, with what to do.
#include "core/io/meshes/other_meshes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/testing/damaged_file.h"

namespace keypose::other_meshes_test {

using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::string_literals;

class OtherMeshes : public HostileFile {};

TEST_F(OtherMeshes, AreKnownByTheirContent) {
  const std::string xml = "<?xml version='1.0'?>\n";
  for (const auto& [head, kind, cure] : std::vector<std::array<std::string, 3>>{
           {"DRACO\x02", "a Draco file", "Blender"},
           {"Kaydara FBX Binary  ", "an FBX file", "export it as OBJ, PLY, STL or GLB"},
           {"; FBX 7.4.0 project file\n", "an FBX file", "Blender"},
           {"MM\x10\0\0\0\x02\0\x0a\0\0\0\3\0\0\0"s, "a 3DS file", "export it as OBJ"},
           {xml + "<X3D version='3.0'>", "an X3D file", "export it as OBJ"},
           {xml + "<COLLADA>", "a Collada file", "export it as OBJ"},
           {"<?xml version=\"1.0\"?><COLLADA/>", "a Collada file", "Blender"},
           {xml + "<amf unit=\"inch\">", "an AMF file", "a slicer"},
           {xml + "<VTKFile type=\"PolyData\">", "a VTK file", "ParaView"},
           {"<VTKFile type=\"PolyData\">", "a VTK file", "PLY or STL"},
           {"<!DOCTYPE html>\n<HTML>", "a web page", "fetch the file itself"},
           {"#usda 1.0\n(\n", "a USD file", "Blender"},
           {"PXR-USDC\0"s, "a USD file", "Blender"},
           {"VRML V1.0", "a VRML file", "Blender"},
           {"#VRML V2.0 utf8\n", "a VRML file", "export it as OBJ"},
           {"# vtk DataFile Version 3.0\nmesh\nASCII\n", "a VTK file", "ParaView"},
           {"# .PCD v0.7 - Point Cloud Data file format\nVERSION .7\n", "a point cloud of PCL",
            "holds points and no faces"},
           {"VERSION .7\nFIELDS x y z rgb\n", "a point cloud of PCL", "CloudCompare or MeshLab"},
           {"LASF\0\0"s, "a LAS or LAZ point cloud", "make a mesh of them"},
           {"ASTM-E57\1"s, "an E57 point cloud", "make a mesh of them"},
           {"0.1 0.2 0.3\n0.4 0.5 -6e-7\n", "a list of points", "make a mesh of them"},
           {"0.1, 0.2, 0.3, 255, 0, 0\n0.4,0.5,0.6,1,2,3\n", "a list of points", "points"},
           {"$MeshFormat\n4.1 0 8\n", "a Gmsh file", "open it in Gmsh"},
           {"MeshVersionFormatted 2\n", "a Medit file", "Gmsh"},
           {"ISO-10303-21;\n", "a STEP file", "FreeCAD"},
           {"HIERARCHY\nROOT Hips\n", "a BVH file", "give a mesh"},
           {"\x1f\x8b\x08", "packed by gzip", "unpack it"},
           {"(\xb5/\xfd rest", "packed by Zstandard", "Blender"},
           {"\xff\xd8\xff\xe0", "a JPEG picture", "give a mesh"},
           {"version https://git-lfs.github.com/spec/v1\n", "a pointer of Git LFS", "git lfs pull"},
           {"v\0 \0000\0 \0000\0 \0000\0\n\0v\0"s, "text in UTF-16", "save it as UTF-8"},
           {"\xff\xfev\0"s, "text in UTF-16", "save it as UTF-8"},
           {"\xfe\xff\0v"s, "text in UTF-16", "save it as UTF-8"}})
    EXPECT_THAT(MeshMessage(Put("m.bin", head)), AllOf(HasSubstr(kind), HasSubstr(cure))) << head;
}

TEST_F(OtherMeshes, AreKnownByTheirEndingsWhereTheContentSaysNothing) {
  for (const auto& [ending, kind, cure] :
       std::vector<std::array<std::string, 3>>{{"3mf", "a 3MF file", "a slicer"},
                                               {"amf", "an AMF file", "slicer"},
                                               {"las", "a LAS point cloud", "points"},
                                               {"laz", "a LAZ point cloud", "points"},
                                               {"msh", "a .msh file", "Gmsh"},
                                               {"pcd", "a point cloud of PCL", "points"},
                                               {"splat", "Gaussian splats", "holds no faces"},
                                               {"ksplat", "Gaussian splats", "export a mesh"},
                                               {"vtk", "a VTK file", "ParaView"},
                                               {"vtp", "a VTK file", "ParaView"},
                                               {"xyz", "a list of points", "points"},
                                               {"e57", "an E57 point cloud", "points"},
                                               {"usd", "a USD file", "Blender"},
                                               {"dae", "a Collada file", "Blender"},
                                               {"fbx", "an FBX file", "Blender"},
                                               {"wrl", "a VRML file", "Blender"},
                                               {"max", "a 3ds Max file", "program"},
                                               {"c4d", "a Cinema 4D file", "program"},
                                               {"SKP", "a SketchUp file", "program"},
                                               {"stp", "a STEP file", "FreeCAD"}})
    EXPECT_THAT(MeshMessage(Put("m." + ending, "\x01\x02\x03 nothing known")),
                AllOf(HasSubstr(kind), HasSubstr("which is not read"), HasSubstr(cure)))
        << ending;
  EXPECT_THAT(MeshMessage(Put("m.ply", "\x01\x02\x03 nothing known")),
              HasSubstr("is not a PLY, OBJ, OFF, STL or glTF mesh"));
}

TEST_F(OtherMeshes, TheContentComesBeforeTheEnding) {
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const std::string& head : {obj, "\xef\xbb\xbf" + obj, "\xef\xbb\xbf# a comment\n" + obj,
                                  "cstype bezier\n" + obj, "vendor thing\n" + obj})
    EXPECT_EQ(ReadMesh(Put("m.fbx", head)).face_count(), 1) << head;
}

}  // namespace keypose::other_meshes_test
