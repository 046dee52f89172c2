#include <gtest/gtest.h>
#include <libheif/heif_cxx.h>
#include <unistd.h>

#include <chrono>
#include <fstream>
#include <thread>

#include "core/errors.h"
#include "core/geometry.h"
#include "core/io/colmap_io.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_set.h"
#include "core/io/landmarks_io.h"
#include "core/io/mesh_io.h"
#include "core/io/poses_io.h"
#include "core/size_of.h"
#include "core/testing_shapes.h"

namespace keypose {
namespace {
namespace fs = std::filesystem;

class IoTest : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("keypose_io_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path Put(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return folder_ / name;
  }
  fs::path folder_;
};

Mesh ColoredSphereWithUvs() {
  Mesh mesh = MakeIcosphere(2);
  mesh.normals = VertexNormals(mesh.points, mesh.faces);
  mesh.colors = ColorsX3::Constant(mesh.points.rows(), 3, 77);
  mesh.uvs = (mesh.points.leftCols(2).array() * 0.5 + 0.5).matrix();
  mesh.uv_faces = mesh.faces;
  return mesh;
}

/// A HEIC photograph of 128 x 80 pixels as it was taken, with a red upper left quarter. Like a
/// phone, it stores its orientation twice: in the container (irot), which decoders apply, and in
/// EXIF. (The library's writer reads beyond the end of rows whose size is not a multiple of 16
/// bytes.)
fs::path PutHeic(const fs::path& path, int orientation) {
  Image8 image(128, 80, 3, 30);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) image.at(x, y)[0] = 220;
  ExifToWrite exif;
  exif.focal_mm = 4.2;
  exif.focal_35mm = 26;
  exif.make = "Apple";
  exif.model = "iPhone 12";
  exif.orientation = orientation;
  const fs::path plain = path.string() + ".plain.heic";
  WriteImage(plain, image, 92, &exif);
  heif::Context from, to;
  from.read_from_file(plain.string());
  heif::ImageHandle handle = from.get_primary_image_handle();
  heif::Encoder encoder(heif_compression_HEVC);
  heif::Context::EncodingOptions options;
  options.image_orientation = static_cast<heif_orientation>(orientation);
  heif::ImageHandle turned = to.encode_image(
      handle.decode_image(heif_colorspace_RGB, heif_chroma_interleaved_RGB), encoder, options);
  for (const heif_item_id id : handle.get_list_of_metadata_block_IDs("Exif")) {
    const std::vector<std::uint8_t> block = handle.get_metadata(id);
    // The first four bytes are the offset of the TIFF header, which the writer adds itself.
    to.add_exif_metadata(turned, block.data() + 4, SizeOf(block) - 4);
  }
  to.write_to_file(path.string());
  return path;
}

/// Whether the pixel belongs to the red quarter. Not for pixels near its edge, because HEIC is
/// lossy.
bool IsRed(const Image8& image, int x, int y) { return image.at(x, y)[0] > 150; }

using ImageIo = IoTest;

TEST_F(ImageIo, HeicIsTurnedOnceAndKeepsItsFocalLength) {
  const fs::path path =
      PutHeic(folder_ / "portrait.heic", 6);  // to be shown rotated by 90 degrees clockwise
  const ImageInfo info = ReadImageInfo(path);
  EXPECT_EQ(info.format, "heif");
  EXPECT_EQ(info.width, 80);
  EXPECT_EQ(info.height, 128);
  EXPECT_EQ(info.orientation, 1) << "the decoder has turned it: nobody may turn it again";
  ASSERT_TRUE(info.focal_35mm);
  EXPECT_DOUBLE_EQ(*info.focal_35mm, 26);
  EXPECT_NEAR(info.focal_mm.value_or(0), 4.2, 1e-3);
  EXPECT_EQ(info.camera_model, "Apple iPhone 12");
  const Image8 image = ReadImage(path, 3);
  ASSERT_EQ(image.width, 80);
  ASSERT_EQ(image.height, 128);
  EXPECT_TRUE(IsRed(image, 60, 20))
      << "what was upper left is upper right after a turn to the right";
  EXPECT_FALSE(IsRed(image, 20, 20));
  EXPECT_FALSE(IsRed(image, 60, 100));
}

TEST_F(ImageIo, UprightHeicStaysAsItIs) {
  const Image8 image = ReadImage(PutHeic(folder_ / "landscape.heic", 1), 3);
  ASSERT_EQ(image.width, 128);
  EXPECT_TRUE(IsRed(image, 20, 20));
  EXPECT_FALSE(IsRed(image, 100, 20));
}

TEST_F(ImageIo, TruncatedHeicIsAnInputErrorThatNamesIt) {
  const std::string bytes = ReadFile(PutHeic(folder_ / "whole.heic", 1));
  const fs::path cut = Put("cut.heic", bytes.substr(0, bytes.size() / 2));
  try {
    ReadImage(cut, 3);
    FAIL() << "half a file was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cut.heic"), std::string::npos) << error.what();
  }
}

using MeshIo = IoTest;

TEST_F(MeshIo, PlyKeepsEveryBitAndTheUvs) {
  const Mesh mesh = ColoredSphereWithUvs();
  WriteMesh(folder_ / "m.ply", mesh);
  const Mesh read = ReadMesh(folder_ / "m.ply");
  EXPECT_EQ(read.points, mesh.points);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.colors, mesh.colors);
  EXPECT_LT((read.normals - mesh.normals).norm(), 1e-5);
  ASSERT_TRUE(read.has_uvs());
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(read.uvs.row(read.uv_faces(f, k)), mesh.uvs.row(mesh.uv_faces(f, k)));
}

TEST_F(MeshIo, ObjKeepsPositionsUvsAndNamesItsMaterial) {
  const Mesh mesh = ColoredSphereWithUvs();
  WriteMesh(folder_ / "m.obj", mesh, "texture.png");
  const Mesh read = ReadMesh(folder_ / "m.obj");
  // The OBJ parser rounds decimals itself and may miss the last bits.
  EXPECT_LT((read.points - mesh.points).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_EQ(read.faces, mesh.faces);
  EXPECT_EQ(read.uv_faces, mesh.uv_faces);
  EXPECT_LT((read.uvs - mesh.uvs).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NE(ReadFile(folder_ / "m.mtl").find("map_Kd texture.png"), std::string::npos);
}

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

TEST_F(MeshIo, CloudKeepsConfidence) {
  PointCloud cloud;
  cloud.points = PointsX3::Random(10, 3);
  cloud.normals = cloud.points.rowwise().normalized();
  cloud.confidence = Eigen::VectorXf::LinSpaced(10, 0, 1);
  WritePointCloud(folder_ / "c.ply", cloud);
  const PointCloud read = ReadPointCloud(folder_ / "c.ply");
  EXPECT_EQ(read.points, cloud.points);
  EXPECT_EQ(read.confidence, cloud.confidence);
}

using ImageIo = IoTest;

Image8 Gradient(int width, int height) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(255 * x / width);
      image.at(x, y)[1] = static_cast<std::uint8_t>(255 * y / height);
    }
  return image;
}

TEST_F(ImageIo, PngIsLossless) {
  WriteImage(folder_ / "g.png", Gradient(40, 30));
  EXPECT_EQ(ReadImage(folder_ / "g.png").data, Gradient(40, 30).data);
}

TEST_F(ImageIo, LinearLightIsWrittenAsTheExtensionAndBitsSay) {
  ImageF linear(8, 4, 3, 0.2140411f);  // sRGB 127.5
  linear.data[0] = 3;
  linear.data[1] = 0.001f;  // on the straight part of the curve: 12.92 * 0.001 * 255 = 3.29
  WriteLinearImage(folder_ / "l.png", linear);
  WriteLinearImage(folder_ / "l16.png", linear, 16);
  WriteLinearImage(folder_ / "l.tif", linear);
  WriteLinearImage(folder_ / "l.exr", linear, 32);
  for (const char* name : {"l.png", "l16.png", "l.tif"}) {
    const Image8 read = ReadImage(folder_ / name, 3);
    EXPECT_EQ(read.data[0], 255) << name;
    EXPECT_EQ(read.data[1], 3) << name;
    EXPECT_NEAR(read.data[2], 127.5, 0.6) << name;
  }
  EXPECT_EQ(ReadFile(folder_ / "l.png").at(24), 8);  // the depth in a PNG's header
  EXPECT_EQ(ReadFile(folder_ / "l16.png").at(24), 16);
  EXPECT_EQ(ReadFile(folder_ / "l.exr").substr(0, 4), "v/1\x01");
  EXPECT_THROW(WriteLinearImage(folder_ / "l.exr", linear, 8), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "l.png", linear, 32), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "l.jpg", linear), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "missing" / "l.exr", linear), DiskError);
}

TEST_F(ImageIo, NoFileHoldsTheTimeOfDay) {
  const ImageF linear(8, 4, 3, 0.2f);
  const std::vector<std::string> kinds = {".png", ".tif", ".exr", ".jpg"};
  const auto write = [&](const std::string& kind) {
    const fs::path file = folder_ / ("time" + kind);
    if (kind == ".jpg")
      WriteImage(file, Gradient(8, 4));
    else
      WriteLinearImage(file, linear);
    return ReadFile(file);
  };
  std::vector<std::string> first;
  for (const std::string& kind : kinds) first.push_back(write(kind));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // such times are whole seconds
  for (std::size_t k = 0; k < kinds.size(); ++k)
    EXPECT_EQ(write(kinds[k]) == first[k], true) << kinds[k];
}

TEST_F(ImageIo, ExifComesBackAndOrientationIsApplied) {
  const ExifToWrite exif{35, 52, "Maker", "Box 1", 6};
  WriteImage(folder_ / "g.jpg", Gradient(64, 32), 98, &exif);
  const ImageInfo info = ReadImageInfo(folder_ / "g.jpg");
  EXPECT_NEAR(info.focal_mm.value_or(0), 35, 1e-3);
  EXPECT_NEAR(info.focal_35mm.value_or(0), 52, 1e-3);
  EXPECT_EQ(info.camera_model, "Maker Box 1");
  EXPECT_EQ(info.width, 32);
  const Image8 image = ReadImage(folder_ / "g.jpg");
  ASSERT_EQ(image.width, 32);
  ASSERT_EQ(image.height, 64);
  // Orientation 6: the stored top row becomes the right-hand column, so red increases downwards and
  // green to the left.
  EXPECT_LT(image.at(16, 2)[0], image.at(16, 61)[0]);
  EXPECT_GT(image.at(2, 32)[1], image.at(29, 32)[1]);
}

TEST_F(ImageIo, TruncatedJpegThrowsAndNamesTheFile) {
  WriteImage(folder_ / "g.jpg", Gradient(200, 150));
  const std::string bytes = ReadFile(folder_ / "g.jpg");
  Put("cut.jpg", bytes.substr(0, bytes.size() * 2 / 3));
  try {
    ReadImage(folder_ / "cut.jpg");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cut.jpg"), std::string::npos);
  }
}

TEST_F(ImageIo, ResizingKeepsTheMean) {
  Image8 image(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      *image.at(x, y) = static_cast<std::uint8_t>((x * 7 + y * 13) % 200);
  const auto mean = [](const Image8& i) {
    double sum = 0;
    for (const auto v : i.data) sum += v;
    return sum / static_cast<double>(i.data.size());
  };
  EXPECT_NEAR(mean(Resized(image, 16, 16)), mean(image), 0.5);
}

using ColmapIo = IoTest;

Scene SmallScene() {
  Scene scene;
  for (const char* name : {"a.jpg", "b.jpg"}) {
    View view;
    view.name = name;
    view.camera = {640, 480, 500, 501, 320, 240, 0.01, -0.02, 1e-4, 2e-4};
    view.camera_from_world = {Eigen::Quaterniond(1, 0.1, 0.2, name[0] * 0.01).normalized(),
                              {0, 0.1, 3}};
    scene.views.push_back(view);
  }
  SparsePoint point;
  point.position = {0.1, 0.2, 0.3};
  point.color << 10, 20, 30;
  point.error_px = 0.5;
  point.views = {0, 1};
  scene.points.push_back(point);
  return scene;
}

TEST_F(ColmapIo, BinaryModelComesBack) {
  const Scene scene = SmallScene();
  WriteColmapModel(folder_, scene);
  const Scene read = ReadColmapModel(folder_);
  ASSERT_EQ(read.views.size(), 2u);
  for (int v = 0; v < 2; ++v) {
    EXPECT_LT((read.views[v].Project({0.1, 0, 0.2}) - scene.views[v].Project({0.1, 0, 0.2})).norm(),
              1e-9);
    EXPECT_EQ(read.views[v].name, scene.views[v].name);
  }
  ASSERT_EQ(read.points.size(), 1u);
  EXPECT_EQ(read.points[0].views, scene.points[0].views);
  EXPECT_EQ(read.points[0].position, scene.points[0].position);
}

TEST_F(ColmapIo, TruncatedModelThrowsInputError) {
  WriteColmapModel(folder_, SmallScene());
  const std::string bytes = ReadFile(folder_ / "images.bin");
  Put("images.bin", bytes.substr(0, bytes.size() - 9));
  EXPECT_THROW(ReadColmapModel(folder_), InputError);
  EXPECT_THROW(ReadColmapModel(folder_ / "absent"), InputError);
}

using LandmarksIo = IoTest;

TEST_F(LandmarksIo, PicksComeBackAndKnowTheirMesh) {
  const Mesh mesh = MakeIcosphere(1);
  WriteLandmarks(folder_ / "l.json", mesh, {{"nose", 3, {0.2, 0.3, 0.5}}});
  const auto read = ReadLandmarks(folder_ / "l.json", mesh);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "nose");
  EXPECT_EQ(read[0].face, 3);
  EXPECT_THROW(ReadLandmarks(folder_ / "l.json", MakeBox(1, 1, 1)), InputError);
}

/// The text of a schema 1 file, as older versions wrote it.
std::string OldPicks(const Mesh& mesh) {
  return R"({"schema":1,"mesh":{"vertices":)" + std::to_string(mesh.vertex_count()) +
         R"(,"faces":)" + std::to_string(mesh.face_count()) +
         R"(},"landmarks":[{"name":"nose","face":3,"barycentric":[0.2,0.3,0.5]}]})";
}

TEST_F(LandmarksIo, OlderFilesAreBelievedWithAWarningWhereTheCountsAreTheSame) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  EXPECT_EQ(ReadLandmarks(Put("old.json", OldPicks(mesh)), mesh, &log)[0].face, 3);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("landmarks bind"), std::string::npos) << log.warnings[0];
  EXPECT_TRUE(log.unbound);
  EXPECT_THROW(ReadLandmarks(folder_ / "old.json", MakeIcosphere(2)), InputError);
}

TEST_F(LandmarksIo, PointsThatHangBesideTheMeshWerePickedOnAnother) {
  const Mesh mesh = MakeIcosphere(4);
  const auto put = [&](double radius) {
    std::string text = "<PickedPoints>\n";
    for (const char* axis : {"x", "y", "z"})
      for (const double side : {-radius, radius})
        text += "<point " + std::string(axis == std::string("x") ? "" : "x=\"0\" ") +
                (axis == std::string("y") ? "" : "y=\"0\" ") +
                (axis == std::string("z") ? "" : "z=\"0\" ") + axis + "=\"" + std::to_string(side) +
                "\" name=\"" + axis + std::to_string(side) + "\"/>\n";
    return Put("p.pp", text + "</PickedPoints>\n");
  };
  CarryLog log;
  EXPECT_EQ(ReadPicks(put(1.0), mesh, &log).size(), 6u);
  EXPECT_TRUE(log.warnings.empty()) << log.warnings[0];
  EXPECT_EQ(ReadPicks(put(1.01), mesh, &log).size(), 6u);  // 0.3 % of the diagonal
  EXPECT_EQ(log.warnings.size(), 1u);
  EXPECT_THROW(ReadPicks(put(1.03), mesh, &log), InputError);  // 0.9 %
}

TEST_F(LandmarksIo, FaceBeyondTheMeshIsNamed) {
  Put("l.json",
      R"({"schema":1,"landmarks":[{"name":"left-eye","face":9001,"barycentric":[1,0,0]}]})");
  try {
    ReadLandmarks(folder_ / "l.json", MakeIcosphere(1));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(
        std::string(error.what()).find("'left-eye' is on face 9001, but the mesh has 80 faces"),
        std::string::npos)
        << error.what();
  }
}

TEST_F(LandmarksIo, TextPairsGiveTheVertices) {
  const Mesh mesh = MakeIcosphere(1);
  const auto pairs = ReadLandmarkPairs({Put("p.txt", "# two pairs\n3 5\n7 9\n")}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_LT((PositionOf(pairs[0].source, mesh) - mesh.points.row(3).transpose()).norm(), 1e-15);
  EXPECT_LT((PositionOf(pairs[1].target, mesh) - mesh.points.row(9).transpose()).norm(), 1e-15);
  EXPECT_THROW(ReadLandmarkPairs({Put("q.txt", "3 5\n3 6\n")}, mesh, mesh), InputError);
  EXPECT_THROW(ReadLandmarkPairs({Put("r.txt", "3 500\n")}, mesh, mesh), InputError);
  EXPECT_THROW(ReadLandmarkPairs({Put("s.txt", "three 5\n")}, mesh, mesh), InputError);
}

TEST_F(LandmarksIo, PairsComeBackWithWhatAPersonSaidOfThem) {
  const Mesh source = MakeIcosphere(1), target = MakeIcosphere(2);
  LandmarkPair pair{"ear", {"ear", 3, {0.25, 0.25, 0.5}}, {"ear", 300, {1, 0, 0}}, false, 0.5,
                    "tip"};
  WriteLandmarkPairs(folder_ / "pairs.json", source, target, {pair});
  const auto read = ReadLandmarkPairs({folder_ / "pairs.json"}, source, target);
  ASSERT_EQ(read.size(), 1u);
  EXPECT_EQ(read[0].name, "ear");
  EXPECT_EQ(read[0].target.face, 300);
  EXPECT_EQ(read[0].source.barycentric, pair.source.barycentric);
  EXPECT_FALSE(read[0].confirmed);
  EXPECT_EQ(read[0].confidence, 0.5);
  EXPECT_EQ(read[0].origin, "tip");
  EXPECT_THROW(ReadLandmarkPairs({folder_ / "pairs.json"}, MakeBox(1, 1, 3), target),
               InputError);  // of another shape
  EXPECT_THROW(
      ReadLandmarkPairs({Put("one.json", R"({"schema":1,"landmarks":[]})")}, source, target),
      InputError);
  EXPECT_THROW(
      ReadLandmarkPairs({Put("cut.json", R"({"schema":1,"pairs":[{"name":)")}, source, target),
      InputError);
  const std::string place = R"({"face":1,"barycentric":[1,0,0]})";
  const std::string entry = R"({"name":"a","source":)" + place + R"(,"target":)" + place + "}";
  EXPECT_TRUE(
      ReadLandmarkPairs({Put("hand.json", R"({"pairs":[)" + entry + "]}")}, source, target)[0]
          .confirmed);
  EXPECT_THROW(ReadLandmarkPairs({Put("twice.json", R"({"pairs":[)" + entry + "," + entry + "]}")},
                                 source, target),
               InputError);
}

TEST_F(LandmarksIo, MeshLabPicksSnapToTheSurfaceAndJoinByName) {
  const Mesh mesh = MakeIcosphere(2);
  const auto pp = [&](const char* file, double x) {
    return Put(file, "<!DOCTYPE PickedPoints>\n<PickedPoints>\n<point x=\"" + std::to_string(x) +
                         "\" y=\"0\" z=\"0\" name=\"tip\" active=\"1\"/>\n</PickedPoints>\n");
  };
  const auto pairs = ReadLandmarkPairs({pp("a.pp", 1.0), pp("b.pp", -1.0)}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_GT(PositionOf(pairs[0].source, mesh).x(), 0.95);
  EXPECT_LT(PositionOf(pairs[0].target, mesh).x(), -0.95);
  EXPECT_THROW(ReadLandmarkPairs({pp("a.pp", 1.0), pp("c.pp", 9.0)}, mesh, mesh), InputError);
}

using Files = IoTest;

/// Picks in the middle of faces, by names that XML and JSON must escape.
std::vector<Landmark> OddlyNamedPicks() {
  return {{"a < b & \"c\"", 3, {0.2, 0.3, 0.5}},
          {"it's", 40, {0.6, 0.25, 0.15}},
          {"n\u00e4se>", 79, {0.125, 0.5, 0.375}}};
}

void ExpectSamePicks(const std::vector<Landmark>& read, const std::vector<Landmark>& picks) {
  ASSERT_EQ(read.size(), picks.size());
  for (const Landmark& pick : picks) {
    const auto same = std::find_if(read.begin(), read.end(),
                                   [&](const Landmark& one) { return one.name == pick.name; });
    ASSERT_NE(same, read.end()) << pick.name;
    EXPECT_EQ(same->face, pick.face) << pick.name;
    EXPECT_LT((same->barycentric - pick.barycentric).norm(), 1e-12) << pick.name;
  }
}

TEST_F(LandmarksIo, PicksComeBackFromMeshLabsPoints) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  const fs::path file = Put("p.pp", PickedPointsText(OddlyNamedPicks(), mesh));
  ExpectSamePicks(ReadPicks(file, mesh, &log), OddlyNamedPicks());
  EXPECT_TRUE(log.warnings.empty()) << log.warnings[0];
}

TEST_F(LandmarksIo, PicksComeBackFromWrapsPoints) {
  const Mesh mesh = MakeIcosphere(1);
  CarryLog log;
  const fs::path file = Put("wrap.json", WrapPointsText(OddlyNamedPicks()));
  ExpectSamePicks(ReadPicks(file, mesh, &log, "scan"), OddlyNamedPicks());
  EXPECT_TRUE(log.unbound);
  ASSERT_EQ(log.warnings.size(), 1u);
  EXPECT_NE(log.warnings[0].find("if the scan was rebuilt"), std::string::npos) << log.warnings[0];
}

TEST_F(LandmarksIo, WrapsPointsWithoutNamesAreNumbered) {
  const Mesh mesh = MakeIcosphere(1);
  const fs::path file = Put("list.json", " [[3, 0.2, 0.3], [40, 1, 0]]");
  ExpectSamePicks(ReadPicks(file, mesh), {{"1", 3, {0.2, 0.3, 0.5}}, {"2", 40, {1, 0, 0}}});
  const auto pairs = ReadLandmarkPairs({file, file}, mesh, mesh);
  ASSERT_EQ(pairs.size(), 2u);
  const Eigen::Vector3d corner = mesh.points.row(mesh.faces(40, 0));
  EXPECT_LT((PositionOf(pairs[1].target, mesh) - corner).norm(), 1e-12);
}

TEST_F(LandmarksIo, WrapsPointsOfAnotherMeshAreInputErrors) {
  const Mesh mesh = MakeIcosphere(1);
  for (const char* text :
       {R"({"nose": [80, 0.2, 0.3]})", R"({"nose": [-1, 0.2, 0.3]})", R"({"nose": [1e300, 0, 1]})",
        R"({"nose": [3.5, 0.2, 0.3]})", R"({"nose": [3, 0.7, 0.7]})",
        R"({"nose": [3, 0.2, 0.3], "ear": [3, 0.2]})", R"([[3, 0.2, 0.3], {"face": 3}])"})
    EXPECT_THROW(ReadPicks(Put("w.json", text), mesh), InputError) << text;
  const fs::path one = Put("w.json", R"({"nose": [3, 0.2, 0.3]})");
  EXPECT_THROW(ReadLandmarkPairs({one}, mesh, mesh), InputError);
}

TEST_F(Files, FullDiskGivesDiskErrorAndNoFile) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
  EXPECT_THROW(WriteFile("/dev/full", std::string(1 << 20, 'x')), DiskError);
}

TEST(NearestWord, FindsTheTypo) {
  EXPECT_EQ(NearestWord("facse", {"alpha", "faces", "offset"}), "faces");
}

using PosesIo = IoTest;

TEST_F(PosesIo, TransformsAreCameraToWorldWithYUp) {
  // A camera at (0, -2, 0) that looks along +y, z up.
  const fs::path file =
      Put("transforms.json", R"({"fl_x": 900, "w": 640, "h": 480, "k1": 0.01, "frames": [
    {"file_path": "./images/b.jpg", "transform_matrix": [[1, 0, 0, 0], [0, 0, -1, -2], [0, 1, 0, 0], [0, 0, 0, 1]]},
    {"file_path": "./images/a", "cx": 300, "transform_matrix": [[1, 0, 0, 0], [0, 0, -1, -2], [0, 1, 0, 0]]}]})");
  const std::vector<View> views = ReadPoses(file);
  ASSERT_EQ(views.size(), 2u);
  EXPECT_EQ(ReadPoses(file.parent_path()).size(), 2u) << "the file is found in its folder";
  EXPECT_EQ(views[0].name, "a");
  EXPECT_EQ(views[0].camera.cx, 300);
  EXPECT_EQ(views[1].camera.fy, 900);
  EXPECT_EQ(views[1].camera.k1, 0.01);
  EXPECT_LT((views[1].Center() - Eigen::Vector3d(0, -2, 0)).norm(), 1e-12);
  // A point in front of the camera, to the right and above, projects to the right of and above the
  // centre.
  const Eigen::Vector3d seen = views[1].camera_from_world * Eigen::Vector3d(0.1, 0, 0.2);
  EXPECT_LT((seen - Eigen::Vector3d(0.1, -0.2, 2)).norm(), 1e-12);
}

TEST_F(PosesIo, FaultsAreInputErrorsThatNameTheFrame) {
  const auto message = [&](const std::string& text) -> std::string {
    try {
      ReadPoses(Put("transforms.json", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message("{").find("transforms.json"), std::string::npos);
  EXPECT_NE(message(R"({"frames": []})").find("holds no camera"), std::string::npos);
  EXPECT_NE(message(R"({"fl_x": 9, "frames": [{"file_path": "q.jpg",
    "transform_matrix": [[2, 0, 0, 0], [0, 2, 0, 0], [0, 0, 2, 0], [0, 0, 0, 1]]}]})")
                .find("frame q.jpg"),
            std::string::npos);
  EXPECT_NE(
      message(
          R"({"frames": [{"file_path": "q.jpg", "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]}]})")
          .find("no focal length"),
      std::string::npos);
  EXPECT_THROW(ReadPoses(Put("poses.csv", "a")), InputError);
}

using ImageSetIo = IoTest;

TEST_F(ImageSetIo, PlateAndGroupsComeBackAsTheyWereWritten) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{9, 7, 0.030, 0.02};
  CapturedImage image;
  image.name = "a.jpg";
  image.group = "lying";
  image.board_corners = {{0, Eigen::Vector2d(1.25, 1.0 / 3)}, {47, Eigen::Vector2d(-2, 1e3)}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  const ImageSet read = ReadImageSet(folder_);
  ASSERT_TRUE(read.board.has_value());
  EXPECT_EQ(read.board->columns, 9);
  EXPECT_EQ(read.board->marker_m, 0.02);
  EXPECT_EQ(read.images[0].group, "lying");
  ASSERT_EQ(read.images[0].board_corners.size(), 2u);
  EXPECT_EQ(read.images[0].board_corners[1].id, 47);
  EXPECT_EQ(read.images[0].board_corners[0].pixel, image.board_corners[0].pixel);
}

TEST_F(ImageSetIo, PlateCornerThatThePlateDoesNotHaveIsAnInputError) {
  ImageSet set;
  set.folder = folder_;
  set.board = BoardLayout{3, 3, 0.030, 0.02};
  CapturedImage image;
  image.name = "a.jpg";
  image.board_corners = {{4, Eigen::Vector2d::Zero()}};
  set.images = {image};
  WriteFile(folder_ / "a.jpg", "x");
  WriteImageSet(set);
  EXPECT_THROW(ReadImageSet(folder_), InputError);
}

TEST(BoardLayout, CornersAreCentredAndRunFromTheTopLeft) {
  const BoardLayout board;
  ASSERT_EQ(board.CornerCount(), 70);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int id = 0; id < board.CornerCount(); ++id) sum += board.Corner(id);
  EXPECT_LT(sum.norm(), 1e-14);
  EXPECT_LT((board.Corner(0) - Eigen::Vector3d(-4.5 * 0.022, 3 * 0.022, 0)).norm(), 1e-15);
  EXPECT_LT((board.Corner(1) - board.Corner(0) - Eigen::Vector3d(0.022, 0, 0)).norm(), 1e-15);
  EXPECT_TRUE(board.Problems().empty());
  EXPECT_FALSE((BoardLayout{15, 15, 0.02, 0.015}.Problems().empty()));
  EXPECT_FALSE((BoardLayout{11, 8, 0.02, 0.02}.Problems().empty()));
}

}  // namespace
}  // namespace keypose
