// Key poses whose meshes were made elsewhere, from `keypose init` to the animation and the report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/image.h"
#include "core/values/same_faces.h"
#include "tests/run_program.h"

namespace keypose::tests::mesh_project_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kOk = 0, kUsage = 2, kInput = 3;

/// A tube with texture coordinates, in millimetres, upright and bent.
class MeshProject : public ::testing::Test, public TestingFolder {
 protected:
  void SetUp() override {
    mesh_ = MakeCylinder(120, 900, 16, 40);
    mesh_.uvs = UvsX2(mesh_.points.rows(), 2);
    for (Eigen::Index v = 0; v < mesh_.points.rows(); ++v)
      mesh_.uvs.row(v) << 0.5 + mesh_.points(v, 0) / 300, mesh_.points(v, 2) / 1000;
    mesh_.uv_faces = mesh_.faces;
    Mesh bent = mesh_;
    for (Eigen::Index v = 0; v < bent.points.rows(); ++v)
      if (const double above = bent.points(v, 2) - 450; above > 0) bent.points(v, 0) += above / 2;
    WriteMesh(folder_ / "rest pose.obj", mesh_);
    WriteMesh(folder_ / "wave.obj", bent);
    WriteImage(folder_ / "skin.png", Image8(64, 64, 3, 140));
  }

  RunResult Init(const std::vector<std::string>& more, const std::string& rest = "rest pose.obj",
                 const std::string& wave = "wave.obj") const {
    std::vector<std::string> command = {"keypose",      "init",   "fox",         "--pose",
                                        "rest=" + rest, "--pose", "wave=" + wave};
    command.insert(command.end(), more.begin(), more.end());
    return RunProgram(command, folder_);
  }
  RunResult Run(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> command = {"keypose", "run", "-C", "fox"};
    for (const std::string set : {"export.formats=glb", "export.unit=mm", "interpolate.steps=3"})
      command.insert(command.end(), {"--set", set});
    command.insert(command.end(), more.begin(), more.end());
    return RunProgram(command, folder_);
  }
  fs::path Out(const std::string& path) const { return folder_ / "fox/out" / path; }

  Mesh mesh_;
};

TEST_F(MeshProject, ATemplateThatKeepsItsTextureIsBentOntoTheOtherPose) {
  const RunResult init = Init({"--texture", "skin.png"});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  const RunResult run = Run({"--set", "cleanup.faces=1500"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  const Mesh rest = ReadMesh(Out("rest/mesh.obj")), wave = ReadMesh(Out("wave/mesh.obj"));
  EXPECT_TRUE(SameFaces(rest.faces, mesh_.faces));
  EXPECT_TRUE(SameFaces(wave.faces, mesh_.faces));
  EXPECT_TRUE(SameFaces(wave.uv_faces, mesh_.uv_faces));
  EXPECT_LT((wave.uvs - mesh_.uvs).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_THAT(ReadFile(Out("animation/character.glb")), HasSubstr(ReadFile(folder_ / "skin.png")));
  EXPECT_TRUE(fs::exists(Out("report/index.html")));
  EXPECT_THAT(run.output, Not(HasSubstr("no textured mesh to compare")));
  EXPECT_THAT(run.output, Not(HasSubstr("metres large")));
}

TEST_F(MeshProject, PosesOfTheSameFacesAreNotRegistered) {
  const RunResult init = Init({"--same-faces", "--texture", "skin.png"});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  const RunResult run = Run({"--set", "interpolate.align=none"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(run.output, Not(HasSubstr("register")));
  EXPECT_THAT(ReadFile(Out("animation/animation.json")), HasSubstr("\"frame_0004\""));
}

/// A tube of 16 x 30 quads between two faces of 16 corners, as an artist's OBJ.
class QuadProject : public MeshProject {
 protected:
  static constexpr int kSides = 16, kRings = 31;

  void SetUp() override {
    MeshProject::SetUp();
    WriteFile(folder_ / "rest pose.obj", Tube(0, 0) + Faces());
    WriteFile(folder_ / "wave.obj", Tube(0.5, 0) + Faces());
  }

  /// @param dent  how far one vertex slides towards the opposite corner of its quad
  static std::string Tube(double lean, double dent) {
    std::string text;
    for (int ring = 0; ring < kRings; ++ring)
      for (int side = 0; side < kSides; ++side) {
        const bool slides = ring == 15 && side == 3;
        const double turn = 2 * M_PI * (side - (slides ? dent : 0)) / kSides,
                     z = 30 * (ring + (slides ? dent : 0));
        text += "v " + std::to_string(120 * std::cos(turn) + lean * std::max(0.0, z - 450)) + " " +
                std::to_string(120 * std::sin(turn)) + " " + std::to_string(z) + "\n";
      }
    return text;
  }

  static std::string Faces() {
    std::string text, floor = "f", lid = "f";
    for (int ring = 0; ring < kRings; ++ring)
      for (int side = 0; side <= kSides; ++side)
        text += "vt " + std::to_string(0.9 * side / kSides) + " " +
                std::to_string(0.9 * ring / kRings) + "\n";
    const auto corner = [](int ring, int side) {
      return " " + std::to_string(kSides * ring + side % kSides + 1) + "/" +
             std::to_string((kSides + 1) * ring + side + 1);
    };
    for (int ring = 0; ring + 1 < kRings; ++ring)
      for (int side = 0; side < kSides; ++side)
        text += "f" + corner(ring, side) + corner(ring, side + 1) + corner(ring + 1, side + 1) +
                corner(ring + 1, side) + "\n";
    for (int side = 0; side < kSides; ++side) {
      floor += corner(0, kSides - 1 - side);
      lid += corner(kRings - 1, side);
    }
    return text + floor + "\n" + lid + "\n";
  }

  /// Vertices of the faces, a line each.
  static std::string FaceLines(const std::string& obj) {
    std::string lines;
    std::istringstream in(obj);
    for (std::string line; std::getline(in, line);) {
      if (!line.starts_with("f ")) continue;
      std::istringstream words(line.substr(2));
      for (std::string word; words >> word;) lines += word.substr(0, word.find('/')) + " ";
      lines += "\n";
    }
    return lines;
  }
};

TEST_F(QuadProject, ATemplateThatKeepsItsTextureKeepsItsNet) {
  const RunResult init = Init({"--texture", "skin.png"});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_THAT(init.output, HasSubstr("the quads and polygons of 'rest' will be the faces"));
  const RunResult run = Run({"--set", "cleanup.faces=1500", "--set", "export.formats=obj,usda"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  const std::string given = FaceLines(ReadFile(folder_ / "rest pose.obj"));
  EXPECT_EQ(std::count(given.begin(), given.end(), '\n'), 16 * 30 + 2);
  for (const char* frame : {"frame_0000.obj", "frame_0004.obj"})
    EXPECT_EQ(FaceLines(ReadFile(Out("animation/obj") / frame)), given) << frame;
  EXPECT_THAT(ReadFile(Out("animation/character.usda")), HasSubstr(", 4, 4, 4, 16, 16]\n"));
  EXPECT_THAT(ReadFile(Out("animation/animation.json")), HasSubstr("\"polygons\": 482"));
}

TEST_F(QuadProject, PosesOfTheSamePolygonsAreCutAlike) {
  WriteFile(folder_ / "wave.obj", Tube(0.5, 0.7) + Faces());
  ASSERT_FALSE(
      SameFaces(ReadMesh(folder_ / "wave.obj").faces, ReadMesh(folder_ / "rest pose.obj").faces))
      << "a concave quad is cut another way";
  ASSERT_EQ(Init({"--same-faces"}).exit_code, kOk);
  const RunResult run =
      Run({"--set", "interpolate.align=none", "--set", "export.formats=obj", "--until", "export"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_EQ(FaceLines(ReadFile(Out("animation/obj/frame_0004.obj"))),
            FaceLines(ReadFile(folder_ / "rest pose.obj")));
}

TEST_F(QuadProject, WhereTheTemplateIsMeshedAnewThatIsSaid) {
  const RunResult init = Init({});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_THAT(init.output, HasSubstr("the quads and polygons of 'rest' become triangles"));
  EXPECT_THAT(ReadFile(folder_ / "fox/pipeline.yaml"), Not(HasSubstr("polygons")));
}

TEST_F(QuadProject, PolygonsOfAnotherMeshAreRefused) {
  ASSERT_EQ(Init({"--same-faces"}).exit_code, kOk);
  WriteFile(folder_ / "other.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
  std::string yaml = ReadFile(folder_ / "fox/pipeline.yaml");
  yaml.replace(yaml.find("polygons: ./meshes/rest.obj"), 27, "polygons: ../other.obj");
  WriteFile(folder_ / "fox/pipeline.yaml", yaml);
  const RunResult run = Run({"--set", "interpolate.align=none", "--until", "export"});
  EXPECT_EQ(run.exit_code, kInput) << run.output;
  EXPECT_THAT(run.output, HasSubstr("do not belong to the frames"));
}

TEST_F(MeshProject, WithoutATextureTheTemplateIsCleanedAndUnwrapped) {
  const RunResult init = Init({"--template", "wave"});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  const RunResult run = Run({"--set", "cleanup.faces=1500"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_TRUE(ReadMesh(Out("wave/mesh.obj")).has_uvs());
  EXPECT_THAT(run.output, HasSubstr("without the texture coordinates of wave.obj"));
  EXPECT_TRUE(fs::exists(Out("report/index.html"))) << "its player has no texture";
}

/// Mean of a picture's channel.
double MeanOf(const fs::path& picture, int channel) {
  const Image8 image = ReadImage(picture, 3);
  double sum = 0;
  for (std::size_t i = channel; i < image.data.size(); i += 3) sum += image.data[i];
  return 3 * sum / static_cast<double>(image.data.size());
}

/// The meshes as a scanning program exports them, each with its own material and texture.
class ScannedMeshes : public MeshProject {
 protected:
  void SetUp() override {
    MeshProject::SetUp();
    Image8 red(32, 32, 3, 40), blue = red;
    for (std::size_t i = 0; i < red.data.size(); i += 3) red.data[i] = blue.data[i + 2] = 200;
    Give("rest pose.obj", "rest.png", red);
    Give("wave.obj", "wave.png", blue);
  }
  void Give(const std::string& mesh, const std::string& texture, const Image8& picture) const {
    WriteMesh(folder_ / mesh, ReadMesh(folder_ / mesh), texture);
    WriteImage(folder_ / texture, picture);
  }
};

TEST_F(ScannedMeshes, EachPoseHasItsOwnColoursInTheTemplatesNewLayout) {
  const RunResult init = Init({});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_THAT(init.output, HasSubstr("all colours are carried"));
  const RunResult run = Run({"--set", "cleanup.faces=1500"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_GT(MeanOf(Out("rest/texture.png"), 0), 190);
  EXPECT_LT(MeanOf(Out("rest/texture.png"), 2), 50);
  EXPECT_GT(MeanOf(Out("wave/texture.png"), 2), 190);
  EXPECT_LT(MeanOf(Out("wave/texture.png"), 0), 50);
  EXPECT_TRUE(fs::exists(Out("report/index.html")));
  EXPECT_THAT(run.output, Not(HasSubstr("warning")));
}

TEST_F(ScannedMeshes, ATemplateThatKeepsItsTextureGetsTheOthersColours) {
  const RunResult init = Init({"--texture", "rest.png"});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  const RunResult run = Run({"--set", "cleanup.faces=1500"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(ReadFile(Out("animation/character.glb")), HasSubstr(ReadFile(folder_ / "rest.png")));
  EXPECT_GT(MeanOf(Out("wave/texture.png"), 2), 190);
}

TEST_F(ScannedMeshes, OneTextureForAllIsUsedAsItIs) {
  Give("wave.obj", "wave.png", ReadImage(folder_ / "rest.png", 3));
  ASSERT_EQ(Init({"--texture", "rest.png"}).exit_code, kOk);
  EXPECT_THAT(ReadFile(folder_ / "fox/pipeline.yaml"), HasSubstr("bake: {enabled: false}"));
  fs::remove_all(folder_ / "fox");
  ASSERT_EQ(Init({"--same-faces"}).exit_code, kOk);
  const RunResult run =
      Run({"--set", "interpolate.align=none", "--set", "export.formats=glb-full"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_THAT(ReadFile(Out("animation/character_full.glb")),
              HasSubstr(ReadFile(folder_ / "rest.png")));
}

TEST_F(ScannedMeshes, PosesOfTheSameFacesEachShowTheirOwnTexture) {
  ASSERT_EQ(Init({"--same-faces"}).exit_code, kOk);
  const RunResult run = Run({"--set", "interpolate.align=none", "--set", "export.pose_textures=png",
                             "--set", "export.formats=glb-full"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  const std::string glb = ReadFile(Out("animation/character_full.glb"));
  EXPECT_THAT(glb, HasSubstr(ReadFile(folder_ / "rest.png")));
  EXPECT_THAT(glb, HasSubstr(ReadFile(folder_ / "wave.png")));
}

TEST_F(ScannedMeshes, APoseWithoutColoursTakesTheTemplates) {
  Mesh bare = ReadMesh(folder_ / "wave.obj");
  bare.uvs.resize(0, 2), bare.uv_faces.resize(0, 3);
  WriteMesh(folder_ / "wave.obj", bare);
  ASSERT_EQ(Init({}).exit_code, kOk);
  const RunResult run = Run({"--set", "cleanup.faces=1500"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
  EXPECT_GT(MeanOf(Out("wave/texture.png"), 0), 190) << "the template's red";
}

TEST_F(ScannedMeshes, BinaryGltfIsTakenWithItsTexture) {
  ASSERT_EQ(Init({"--same-faces"}).exit_code, kOk);
  ASSERT_EQ(Run({"--set", "interpolate.align=none", "--set", "export.formats=glb-full", "--until",
                 "export"})
                .exit_code,
            kOk);
  fs::copy(Out("animation/character_full.glb"), folder_ / "app.glb");
  fs::remove_all(folder_ / "fox");
  const RunResult init = Init({}, "app.glb");
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_EQ(ReadFile(folder_ / "fox/meshes/rest_texture.png"), ReadFile(folder_ / "rest.png"));
  EXPECT_THAT(init.output, HasSubstr(" m, has a texture"));
  EXPECT_NEAR(BoundingDiagonal(ReadMesh(folder_ / "fox/meshes/rest.obj").points),
              BoundingDiagonal(mesh_.points) / 1000, 1e-6)
      << "which is in metres";
  const RunResult run = Run({"--set", "cleanup.faces=1500", "--until", "bake/rest"});
  ASSERT_EQ(run.exit_code, kOk) << run.output;
}

TEST_F(ScannedMeshes, ATextureThatIsNotThereIsSaid) {
  fs::remove(folder_ / "wave.png");
  const RunResult init = Init({});
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_THAT(init.output, HasSubstr("names the texture wave.png, which is not there"));
  fs::remove_all(folder_ / "fox");
  WriteFile(folder_ / "wave.png", "a TGA has no mark at its start");
  const RunResult other = Init({});
  ASSERT_EQ(other.exit_code, kOk) << other.output;
  EXPECT_THAT(other.output,
              HasSubstr("the picture wave.png cannot be read: it is no PNG, JPEG or WebP"));
}

TEST_F(MeshProject, WhatCannotBeAProjectIsRefusedAndLeavesNothing) {
  fs::create_directories(folder_ / "photos");
  WriteFile(folder_ / "photos/a.jpg", "picture");
  WriteFile(folder_ / "wave.glb", "glTF");
  WriteFile(folder_ / "wave.fbx", "Kaydara FBX");
  const auto refuse = [&](const RunResult& result, int code, const std::string& why) {
    EXPECT_EQ(result.exit_code, code) << result.output;
    EXPECT_THAT(result.output, HasSubstr(why));
    EXPECT_FALSE(fs::exists(folder_ / "fox"));
  };
  refuse(Init({}, "rest pose.obj", "photos"), kUsage, "either meshes or photographs");
  refuse(Init({}, "rest pose.obj", "wave.glb"), kInput, "export it as OBJ");
  refuse(Init({}, "rest pose.obj", "wave.fbx"), kInput, "export it as OBJ");
  WriteFile(folder_ / "wave.laz", "LASF");
  refuse(Init({}, "rest pose.obj", "wave.laz"), kInput, "it holds points and no faces");
  WriteFile(folder_ / "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n");
  refuse(Init({}, "rest pose.obj", "points.obj"), kInput, "has 4 vertices and no faces");
  refuse(Init({}, "rest pose.obj", "none.ply"), kInput, "there is no file");
  refuse(Init({"--texture", "none.png"}), kInput, "there is no file");
  refuse(Init({"--few", "wave"}), kUsage, "these are meshes");
  refuse(Init({"--texture", "skin.png"}, "photos", "photos"), kUsage, "poses from meshes");
}

TEST_F(MeshProject, AFileWithoutItsLastFacesIsDoubted) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\n";
  WriteFile(folder_ / "cut.obj", text);
  EXPECT_THAT(Init({}, "rest pose.obj", "cut.obj").output,
              HasSubstr("1 of 4 vertices are in no face"));
  fs::remove_all(folder_ / "fox");
  WriteFile(folder_ / "cut.obj", text + "f 2 4 3\n");
  EXPECT_THAT(Init({}, "rest pose.obj", "cut.obj").output, Not(HasSubstr("in no face")));
}

TEST_F(MeshProject, InitSaysWhatItReadInOneLine) {
  const std::string corners = "0 0 0 255 0 0\n100 0 0 255 0 0\n0 50 2 255 0 0\n";
  WriteFile(folder_ / "a.off", "COFF\n3 1 0\n" + corners + "3 0 1 2\n");
  WriteFile(folder_ / "no ending", "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nf 1 2 3 4\n");
  const RunResult init = Init({}, "a.off", "no ending");
  ASSERT_EQ(init.exit_code, kOk) << init.output;
  EXPECT_THAT(init.output, HasSubstr("3 vertices, 1 faces, 100 x 50 x 2 (its file names no unit), "
                                     "has colours of its vertices"));
  EXPECT_THAT(init.output, HasSubstr("4 vertices, 1 faces, 4 x 4 x 0 (its file names no unit), has "
                                     "no colours"));
  EXPECT_EQ(ReadMesh(folder_ / "fox/meshes/wave.obj").vertex_count(), 4);
}

TEST_F(MeshProject, AFolderOfMeshesIsNoFolderOfPhotographsAndSaysWhatToDo) {
  fs::create_directories(folder_ / "scans");
  fs::copy(folder_ / "wave.obj", folder_ / "scans/wave.obj");
  const RunResult none = Init({}, "scans", "scans");
  EXPECT_NE(none.exit_code, kOk);
  const RunResult one = RunProgram({"keypose", "init", "fox", "--pose", "wave=scans"}, folder_);
  EXPECT_EQ(one.exit_code, kInput);
  EXPECT_THAT(one.output, HasSubstr("name each file itself, as in --pose rest=rest.obj"));
  fs::copy(folder_ / "skin.png", folder_ / "scans/skin.png");
  const RunResult textured =
      RunProgram({"keypose", "init", "fox", "--pose", "wave=scans"}, folder_);
  EXPECT_THAT(textured.output, HasSubstr("name each file itself"));
}

}  // namespace keypose::tests::mesh_project_test
