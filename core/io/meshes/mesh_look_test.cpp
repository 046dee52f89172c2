#include "core/io/meshes/mesh_look.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/meshes/mesh_io.h"
#include "core/io/testing/mesh_files.h"

namespace keypose::mesh_look_test {

namespace fs = std::filesystem;

TEST_F(MeshIo, WhatOneMaterialWithOneTextureCannotShowIsSaid) {
  const std::string square =
      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 1.5 1\n";
  const auto warnings = [&](const std::string& faces) {
    const fs::path path = Put("two parts.obj", square + faces);
    return LookWarnings(path, ReadMesh(path));
  };
  EXPECT_THAT(warnings("usemtl skin\nf 1/1 2/2 3/3\nf 1/1 3/3 4/2\nusemtl unused\n"),
              ::testing::IsEmpty());
  EXPECT_THAT(warnings("usemtl skin\nf 1/1 2/2 3/3\nusemtl red cloth\r\nf 1/1 3/3 4/2\n"),
              ::testing::ElementsAre(::testing::HasSubstr("2 materials (red cloth, skin)")));
  EXPECT_THAT(
      warnings("f 1/1 2/2 3/4\nf 1/1 3/3 4/2\n"),
      ::testing::ElementsAre(::testing::HasSubstr("1 of 2 faces of two parts.obj lie outside")));
  EXPECT_THAT(warnings("f 1/1 2/2 3/3\nf 1 3 4\n"),
              ::testing::ElementsAre(::testing::HasSubstr("1 of 2 faces")));
  EXPECT_THAT(warnings("f 1 2 3\nusemtl cloth\nf 1 3 4\n"), ::testing::IsEmpty());
}

}  // namespace keypose::mesh_look_test
