#include "core/io/pictures/photograph_files.h"

#include <gtest/gtest.h>

namespace keypose::photograph_files_test {

TEST(IsRawName, KnowsTheKindsOfTheBigMakersInAnyCase) {
  for (const char* name : {"a.CR2", "a.cr3", "a.NEF", "a.arw", "a.dng", "a.RAF", "a.orf", "a.rw2"})
    EXPECT_TRUE(IsRawName(name)) << name;
  for (const char* name : {"a.jpg", "a", ".dng", "a.dng.txt"})
    EXPECT_FALSE(IsRawName(name)) << name;
}

TEST(IsMeshName, KnowsWhatIsReadAndWhatIsRefusedByName) {
  for (const char* name : {"a.OBJ", "a.ply", "a.off", "a.stl", "a.glb", "a.gltf"}) {
    EXPECT_TRUE(IsReadableMeshName(name)) << name;
    EXPECT_TRUE(IsMeshName(name)) << name;
  }
  for (const char* name : {"a.zip", "a.fbx", "a.3mf", "a.amf", "a.las", "a.laz", "a.msh", "a.pcd",
                           "a.splat", "a.vtk", "a.vtp", "a.xyz", "a.e57", "a.usdz", "a.wrl"}) {
    EXPECT_FALSE(IsReadableMeshName(name)) << name;
    EXPECT_TRUE(IsMeshName(name)) << name;
  }
  EXPECT_FALSE(IsMeshName("a.jpg"));
}

}  // namespace keypose::photograph_files_test
