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

TEST(CureFor, EachKindHasItsOwn) {
  EXPECT_NE(CureFor({"a.AVIF"}).find("mogrify"), std::string::npos);
  EXPECT_NE(CureFor({"a.jpe", "b.jpe"}).find("mogrify"), std::string::npos);
  EXPECT_NE(CureFor({"a.3fr"}).find("develop RAW"), std::string::npos);
  for (const char* film : {"a.mov", "a.flv", "a.Y4M", "a.m2ts"})
    EXPECT_NE(CureFor({film}).find("ffmpeg -i FILM"), std::string::npos) << film;
  EXPECT_EQ(CureFor({"a.gif"}).find("FILM"), std::string::npos);
  EXPECT_EQ(CureFor({"notes.txt"}), "");
}

}  // namespace keypose::photograph_files_test
