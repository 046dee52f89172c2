// Each statement of MTL that tells a material's colour, and each option of its texture.
#include "core/io/meshes/mtl_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::mtl_file_test {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(MtlFile, MaterialsWithColorsAndTextures) {
  const auto materials = ParseMtl(
      "# a comment\r\nnewmtl red cloth\r\n\tKd 1 0.5 0\r\nnewmtl skin\n  map_Kd\tmaps\\fur "
      "1.jpg \nnewmtl grey\nKd 0.25\nnewmtl odd\nKd spectral file.rfl\n");
  ASSERT_EQ(materials.size(), 4u);
  EXPECT_EQ(materials[0].name, "red cloth");
  EXPECT_EQ(materials[0].color, Eigen::Vector3d(1, 0.5, 0));
  EXPECT_EQ(materials[0].map.file, "");
  EXPECT_EQ(materials[1].map.file, "maps\\fur 1.jpg");
  EXPECT_EQ(materials[2].color, Eigen::Vector3d(0.25, 0.25, 0.25));
  EXPECT_FALSE(materials[3].color);
}

TEST(MtlFile, TheDiffuseTextureComesBeforeTheOthers) {
  const auto map_of = [](const std::string& lines) {
    return ParseMtl("newmtl a\n" + lines)[0].map.file;
  };
  EXPECT_EQ(map_of("map_Ka a.png\nmap_Kd d.png\nmap_Ke e.png\n"), "d.png");
  EXPECT_EQ(map_of("map_Ke e.png\nmap_Ka a.png\n"), "a.png");
  EXPECT_EQ(map_of("MAP_KD d.png\n"), "d.png");
  EXPECT_EQ(map_of("map_Ke e.png\n"), "e.png");
  for (const char* other : {"map_Ks", "map_Ns", "map_d", "map_Bump", "bump", "disp", "decal",
                            "refl", "map_Pr", "map_Pm", "norm", "map_aat"})
    EXPECT_EQ(map_of(std::string(other) + " other.png\n"), "") << other;
}

TEST(MtlFile, OptionsOfATexture) {
  const MtlMap both = ParseMtlMap("-o 0.25 0 0 -s 2 3 1 scan.png");
  EXPECT_EQ(both.file, "scan.png");
  EXPECT_EQ(both.offset, Eigen::Vector2d(0.25, 0));
  EXPECT_EQ(both.scale, Eigen::Vector2d(2, 3));
  EXPECT_EQ(ParseMtlMap("-s 2 scan.png").scale, Eigen::Vector2d(2, 1));
  EXPECT_EQ(ParseMtlMap("-s 2 2 1.png").file, "1.png");
  EXPECT_EQ(ParseMtlMap("-o 1 2 3").file, "3") << "a name may be a number";
  EXPECT_TRUE(ParseMtlMap("-clamp on a.png").clamped);
  EXPECT_FALSE(ParseMtlMap("-clamp off a.png").clamped);
  for (const char* option : {"-blendu off", "-blendv on", "-cc on", "-boost 2", "-bm 0.5",
                             "-texres 512", "-imfchan l", "-type sphere", "-colorspace sRGB"}) {
    const MtlMap map = ParseMtlMap(std::string(option) + " my scan.png");
    EXPECT_EQ(map.file, "my scan.png") << option;
    EXPECT_THAT(map.left_out, IsEmpty());
  }
  EXPECT_THAT(ParseMtlMap("-mm 0 1 a.png").left_out, IsEmpty());
  EXPECT_THAT(ParseMtlMap("-mm 0.2 0.5 a.png").left_out, ElementsAre("-mm"));
  EXPECT_THAT(ParseMtlMap("-t 0.1 0 0 a.png").left_out, ElementsAre("-t"));
  EXPECT_EQ(ParseMtlMap("\"my scan.png\"").file, "my scan.png");
  EXPECT_EQ(ParseMtlMap("-dashed name.png").file, "-dashed name.png");
}

TEST(MtlFile, OtherNamesAndOtherColors) {
  const auto map_of = [](const std::string& lines) {
    return ParseMtl("newmtl a\n" + lines)[0].map.file;
  };
  for (const char* key : {"map_basecolor", "map_BaseColor", "map_base_color", "map_albedo",
                          "map_diffuse", "map_color", "map_emissive", "map_Ka"})
    EXPECT_EQ(map_of(std::string(key) + " c.png\n"), "c.png") << key;
  EXPECT_EQ(map_of("map_Kd d.png\nmap_basecolor c.png\n"), "d.png");
  EXPECT_EQ(map_of("map_Ka a.png\nmap_basecolor c.png\n"), "c.png");
  const auto left_out = [](const std::string& line) {
    return ParseMtl("newmtl a\n" + line)[0].left_out;
  };
  EXPECT_THAT(left_out("Kd spectral file.rfl 1\n"), ElementsAre("Kd spectral"));
  EXPECT_THAT(left_out("Kd xyz 0.4 0.2 0.1\n"), ElementsAre("Kd xyz"));
  EXPECT_THAT(left_out("Kd 0.4 0.2 0.1\n"), IsEmpty());
}

}  // namespace keypose::mtl_file_test
