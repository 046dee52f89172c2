#include "core/io/meshes/mesh_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "core/io/testing/damaged_file.h"
#include "core/io/testing/mesh_files.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::mesh_io_test {

namespace fs = std::filesystem;

TEST_F(MeshIo, FormatIsToldByContentNotByName) {
  WriteMesh(folder_ / "m.ply", MakeIcosphere(1));
  fs::rename(folder_ / "m.ply", folder_ / "m.obj");
  EXPECT_EQ(ReadMesh(folder_ / "m.obj").face_count(), 80);
}

TEST_F(MeshIo, ReadsQuadsNegativeIndicesOffAndStl) {
  EXPECT_EQ(
      ReadMesh(Put("q.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n")).face_count(),
      2);
  EXPECT_EQ(ReadMesh(Put("t.off", "OFF\n# a comment\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"))
                .face_count(),
            1);
  const Mesh stl = ReadMesh(Put("t.stl",
                                "solid t\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 "
                                "0\nvertex 0 1 0\nendloop\nendfacet\nendsolid t\n"));
  EXPECT_EQ(stl.face_count(), 1);
  EXPECT_EQ(stl.vertex_count(), 3);
}

TEST_F(MeshIo, DamagedFilesThrowInputErrorWithThePath) {
  WriteMesh(folder_ / "whole.ply", MakeIcosphere(2));
  const std::string bytes = ReadFile(folder_ / "whole.ply");
  for (const auto& path : {Put("cut.ply", bytes.substr(0, bytes.size() / 2)),
                           Put("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
                           Put("noise.bin", "\x01\x02\x03 nothing"), Put("empty.ply", ""),
                           Put("cut.off", "OFF\n3 1 0\n0 0 0\n")}) {
    try {
      ReadMesh(path);
      ADD_FAILURE() << path << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(path.filename().string()), std::string::npos)
          << error.what();
    }
  }
  EXPECT_THROW(ReadMesh(folder_ / "absent.ply"), DiskError);
}

TEST_F(MeshIo, ObjLinesContinuedWithABackslashAreRead) {
  const std::string plain = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
  const std::string folded = "v 0 \\\n0 0\nv 1 0 0\nv 1 1 \\\r\n 0\nv 0 1 0\nf 1 2 \\\n 3 \\\n 4\n";
  const Mesh expected = ReadMesh(Put("plain.obj", plain)),
             read = ReadMesh(Put("folded.obj", folded));
  EXPECT_EQ(read.points, expected.points);
  EXPECT_EQ(read.faces, expected.faces);
  EXPECT_EQ(read.faces.rows(), 2);
}

TEST_F(MeshIo, ObjVertexBelowAContinuedLineThrowsWithItsOwnLine) {
  const fs::path path = Put("bad.obj", "v 0 \\\n0 0\nv 1 0 0\nv 1 nan 0\nf 1 2 3\n");
  try {
    ReadMesh(path);
    FAIL() << "nan was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("bad.obj:4:"), std::string::npos) << error.what();
  }
}

TEST_F(MeshIo, ObjVertexThatIsNoNumberThrowsWithItsLine) {
  for (const char* bad : {"nan", "inf", "clay"}) {
    try {
      ReadMesh(Put("bad.obj", std::string("v 0 0 0\nv 1 0 0\nv 0 1 ") + bad + "\nf 1 2 3\n"));
      ADD_FAILURE() << bad << " was read";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("bad.obj:3"), std::string::npos) << error.what();
    }
  }
}

TEST_F(MeshIo, AnObjFaceWithoutTextureCoordinatesDoesNotTakeThoseOfOthers) {
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0.5 0.5\nvt 1 0\nvt 1 1\n";
  const Mesh mesh = ReadMesh(Put("m.obj", square + "f 1/1 2/2 3/3\nf 1 3 4\n"));
  ASSERT_TRUE(mesh.has_uvs());
  EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(0, 0)), Eigen::RowVector2d(0.5, 0.5));
  for (int k = 0; k < 3; ++k)
    EXPECT_EQ(mesh.uvs.row(mesh.uv_faces(1, k)), Eigen::RowVector2d(0, 0));
  EXPECT_FALSE(ReadMesh(Put("m.obj", square + "f 1 2 3\nf 1 3 4\n")).has_uvs());
  EXPECT_THROW(ReadMesh(Put("m.obj", square + "f 1/9 2/2 3/3\nf 1 3 4\n")), InputError);
}

TEST_F(MeshIo, AnObjWhoseFirstObjectIsACoffeeCupIsNoOff) {
  for (const std::string first : {"o Coffee_cup", "g office", "s off"})
    EXPECT_EQ(ReadMesh(Put("m.obj", first + "\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).face_count(),
              1)
        << first;
}

TEST_F(HostileMesh, ObjCornerThatNamesNoVertexThrows) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (const char* face :
       {"f 0 1 2\n", "f 1 2 x\n", "f 1 2 -4\n", "f 1 2 4\n", "f 1 2 99999999999\n"})
    MeshMessage(Put("corner.obj", vertices + face));
}

TEST_F(HostileMesh, ObjTexturePlacesMayCountBackwards) {
  const std::string whole =
      "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf -3/-3 -2/-2 -1/-1\n";
  EXPECT_TRUE(ReadMesh(Put("whole.obj", whole)).has_uvs());
}

TEST_F(HostileMesh, CountsThatTheFileCannotHoldTakeNoMemory) {
  const std::string ply = "ply\nformat ascii 1.0\nelement vertex ",
                    properties = "\nproperty float x\nproperty float y\nproperty float z\n";
  const std::int64_t growth = GrowthBytes([&] {
    EXPECT_TRUE(Says(MeshMessage(Put("a.off", "OFF\n10000000 10000000 0\n0 0 0\n1 0 0\n0 1 0\n")),
                     "10000000 vertices"));
    EXPECT_TRUE(Says(MeshMessage(Put("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n10000000 0 1 2\n")),
                     "face 0 claims 10000000 corners"));
    EXPECT_TRUE(
        Says(MeshMessage(Put("c.ply", ply + "1x" + properties + "end_header\n0 0 0\n")), "line 3"));
    EXPECT_TRUE(Says(MeshMessage(Put("d.ply", ply + "10000" + properties + "end_header\n0 0 0\n")),
                     "claims 10000 of 'vertex'"));
    EXPECT_TRUE(Says(MeshMessage(Put("e.ply", ply + "1" + properties +
                                                  "element nothing 1000\nend_header\n0 0 0\n")),
                     "claims 1000 of 'nothing'"));
  });
  EXPECT_LT(growth, 100 << 20);
}

/// A square of two triangles as binary OFF. Each face is followed by the number of its colours.
std::string BinaryOff(std::uint32_t corners_of_second) {
  const auto real = [](float value) {
    std::uint32_t bits = 0;
    std::memcpy(&bits, &value, 4);
    return BigEndian32(bits);
  };
  std::string bytes = "OFF BINARY\n" + BigEndian32(4) + BigEndian32(2) + BigEndian32(0);
  for (const float value : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 1.f, 1.f, 0.f, 0.f, 1.f, 0.f})
    bytes += real(value);
  for (const std::uint32_t value : {3u, 0u, 1u, 2u, 0u, corners_of_second, 0u, 2u, 3u, 0u})
    bytes += BigEndian32(value);
  return bytes;
}

TEST_F(HostileMesh, BinaryOffIsReadAndItsDamageNamed) {
  const Mesh square = ReadMesh(Put("square.off", BinaryOff(3)));
  ASSERT_EQ(square.face_count(), 2);
  EXPECT_NEAR(SurfaceArea(square.points, square.faces), 1, 1e-12);
  for (const std::uint32_t corners : {100000u, 1000u})
    EXPECT_TRUE(Says(MeshMessage(Put("bad.off", BinaryOff(corners))), "cannot hold"));
  MeshMessage(Put("bad.off", BinaryOff(4)));
}

TEST_F(HostileMesh, CoordinatesBeyondSinglePrecisionAreNoUsableMesh) {
  Mesh mesh = MakeIcosphere(1);
  mesh.points(5, 1) = 1e30;
  try {
    RequireUsable(mesh, "far.ply");
    FAIL() << "1e30 is usable";
  } catch (const InputError& error) {
    EXPECT_TRUE(Says(error.what(), "far.ply: vertex 5")) << error.what();
  }
}

}  // namespace keypose::mesh_io_test
