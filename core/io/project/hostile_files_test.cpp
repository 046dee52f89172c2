// Damaged and malicious files: each gives an error of the right kind that names the file, and takes
// little memory and time.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/image_set.h"
#include "core/io/project/colmap_io.h"
#include "core/io/project/landmarks_io.h"
#include "core/io/project/poses_io.h"
#include "core/io/project/timeline_json.h"
#include "core/io/text/files.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/shapes.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::hostile_files_test {

namespace fs = std::filesystem;

class HostileFile : public ::testing::Test, public TestingFolder {
 protected:
  fs::path PutJpeg(const std::string& name, int width = 320, int height = 240) const {
    Image8 image(width, height, 3);
    for (std::size_t k = 0; k < image.data.size(); ++k)
      image.data[k] = static_cast<std::uint8_t>(k * k >> 4);
    WriteImage(folder_ / name, image);
    return folder_ / name;
  }

  /// The error's message, which must name the file.
  template <class Fault>
  static std::string Message(const fs::path& file, const std::function<void()>& read) {
    try {
      read();
      ADD_FAILURE() << file << " was read";
    } catch (const Fault& error) {
      EXPECT_NE(std::string(error.what()).find(file.filename().string()), std::string::npos)
          << error.what();
      return error.what();
    }
    return "";
  }
  static std::string MeshMessage(const fs::path& file) {
    return Message<InputError>(file, [&] { ReadMesh(file); });
  }
  static std::string ImageMessage(const fs::path& file) {
    std::string info = Message<InputError>(file, [&] { ReadImageInfo(file); });
    EXPECT_EQ(info, Message<InputError>(file, [&] { ReadImage(file); }));
    return info;
  }
};

/// A lower bound of the peak memory that `work` adds to this process.
std::int64_t GrowthBytes(const std::function<void()>& work) {
  const auto peak = [] {
    rusage use{};
    getrusage(RUSAGE_SELF, &use);
    return std::int64_t{1024} * use.ru_maxrss;
  };
  const std::int64_t before = peak();
  work();
  return peak() - before;
}

bool Says(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

std::string BigEndian32(std::uint32_t value) {
  return {static_cast<char>(value >> 24), static_cast<char>(value >> 16),
          static_cast<char>(value >> 8), static_cast<char>(value)};
}

using HostileMesh = HostileFile;

TEST_F(HostileMesh, ObjPolygonOf300CornersKeepsAllOfThem) {
  constexpr int kCorners = 300;
  std::string text, polygon = "f";
  for (int k = 0; k < kCorners; ++k) {
    text += "v " + std::to_string(std::cos(2 * M_PI * k / kCorners)) + " " +
            std::to_string(std::sin(2 * M_PI * k / kCorners)) + " 0\n";
    polygon += " " + std::to_string(kCorners - k);
  }
  text += "v 0 0 1\n" + polygon + "\n";
  for (int k = 0; k < kCorners; ++k)
    text += "f " + std::to_string(k + 1) + " " + std::to_string((k + 1) % kCorners + 1) + " " +
            std::to_string(kCorners + 1) + "\n";
  const Mesh cone = ReadMesh(Put("cone.obj", text));
  EXPECT_EQ(cone.face_count(), kCorners - 2 + kCorners);
  EXPECT_TRUE(CheckClosed(cone).closed());
  EXPECT_NEAR(SignedVolume(cone.points, cone.faces), M_PI / 3, 1e-3);
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
    EXPECT_TRUE(Says(MeshMessage(Put("a.off", "OFF\n100000000 100000000 0\n0 0 0\n1 0 0\n0 1 0\n")),
                     "100000000 vertices"));
    EXPECT_TRUE(Says(
        MeshMessage(Put("b.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n100000000 0 1 2\n")), "face 0"));
    EXPECT_TRUE(
        Says(MeshMessage(Put("c.ply", ply + "-1" + properties + "end_header\n0 0 0\n")), "line 3"));
    EXPECT_TRUE(
        Says(MeshMessage(Put("d.ply", ply + "9999999999" + properties + "end_header\n0 0 0\n")),
             "9999999999"));
    EXPECT_TRUE(Says(
        MeshMessage(Put(
            "e.ply", ply + "1" + properties + "element nothing 1000000000\nend_header\n0 0 0\n")),
        "nothing"));
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
  for (const std::uint32_t corners : {0xffffffffu, 0x7fffffffu, 1000u, 4u})
    MeshMessage(Put("bad.off", BinaryOff(corners)));
}

TEST_F(HostileMesh, PlyFaceCornersThatAreNoVertexThrow) {
  const std::string head =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\n"
      "element face 1\nproperty list uchar float vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_EQ(ReadMesh(Put("good.ply", head + "3 0 1 2\n")).face_count(), 1);
  for (const char* face : {"3 0 1 nan\n", "3 0 1 1e30\n", "3 0 1 -1\n", "3 0 1 clay\n"})
    MeshMessage(Put("bad.ply", head + face));
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

TEST_F(HostileFile, PipesDevicesAndFoldersAreNoFiles) {
  const fs::path fifo = folder_ / "fifo";
  ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", folder_ / "zero");
  fs::create_symlink(".", folder_ / "loop");
  for (const char* name : {"fifo", "zero", "loop"}) {
    const fs::path file = folder_ / name;
    Message<DiskError>(file, [&] { ReadFile(file); });
    Message<DiskError>(file, [&] { ReadMesh(file); });
    Message<DiskError>(file, [&] { ReadPointCloud(file); });
    Message<DiskError>(file, [&] { ReadImage(file); });
    Message<DiskError>(file, [&] { ReadImageInfo(file); });
  }
}

using HostileImage = HostileFile;

/// A DirectDraw surface: a volume texture, which has depth.
std::string VolumeTexture() {
  std::string bytes(128, '\0');
  const auto put = [&](std::size_t at, std::uint32_t value) {
    std::memcpy(bytes.data() + at, &value, 4);
  };
  bytes.replace(0, 4, "DDS ");
  const std::array<std::pair<std::size_t, std::uint32_t>, 12> fields{{{4, 124},
                                                                      {8, 0x80100f},
                                                                      {12, 240},
                                                                      {16, 320},
                                                                      {20, 1280},
                                                                      {24, 8},
                                                                      {76, 32},
                                                                      {80, 0x40},
                                                                      {88, 24},
                                                                      {92, 0xff0000},
                                                                      {96, 0xff00},
                                                                      {100, 0xff}}};
  for (const auto& [at, value] : fields) put(at, value);
  put(108, 0x1008);
  put(112, 0x200000);
  return bytes + std::string(320 * 240 * 3 * 8, 'A');
}

TEST_F(HostileImage, WhatIsNoPhotographByItsBytesIsNotReadWhateverItsName) {
  EXPECT_TRUE(Says(ImageMessage(Put("volume.jpg", VolumeTexture())), "whatever its name says"));
  ImageMessage(Put("text.png", "no picture"));
  ImageMessage(Put("gif.jpg", "GIF89a" + std::string(100, '\0')));
  ImageMessage(Put("short.jpg", "\xff"));
  ImageMessage(Put("soft.tif", "v/1\x01" + std::string(100, '\0')));
}

TEST_F(HostileImage, PhotographUnderAnotherKindsNameIsRead) {
  fs::rename(PutJpeg("photo.jpg"), folder_ / "photo.png");
  EXPECT_EQ(ReadImageInfo(folder_ / "photo.png").format, "jpeg");
  EXPECT_EQ(ReadImage(folder_ / "photo.png").width, 320);
}

TEST_F(HostileImage, HeicThatClaimsMoreThanItsPictureHasIsDamaged) {
  const fs::path photo = folder_ / "photo.heic";
  WriteImage(photo, Image8(64, 48, 3, 90));
  EXPECT_EQ(ReadImage(photo).width, 64);
  std::string bytes = ReadFile(photo);
  for (std::size_t at = bytes.find("ispe"); at != std::string::npos;
       at = bytes.find("ispe", at + 4))
    bytes.replace(at + 8, 4, BigEndian32(4160));
  const fs::path wide = Put("wide.heic", bytes);
  Message<InputError>(wide, [&] { ReadImage(wide, 3); });
}

/// The first bytes of a PNG whose header claims this size.
std::string PngOf(std::uint32_t width, std::uint32_t height) {
  // libpng checks the checksum of the header: CRC-32, computed bit by bit.
  const std::string header =
      "IHDR" + BigEndian32(width) + BigEndian32(height) + std::string("\x08\x02\x00\x00\x00", 5);
  std::uint32_t crc = ~0u;
  for (const char c : header) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return "\x89PNG\r\n\x1a\n" + BigEndian32(13) + header + BigEndian32(~crc);
}

TEST_F(HostileImage, ClaimedSizesBeyondTheLimitTakeNoMemory) {
  const std::string data = BigEndian32(16) + "IDAT" + std::string(20, '\0') + BigEndian32(0) +
                           "IEND" + std::string(4, '\0');
  const std::int64_t growth = GrowthBytes([&] {
    EXPECT_TRUE(Says(ImageMessage(Put("giant.png", PngOf(20000, 15000) + data)), "20000 x 15000"));
    ImageMessage(Put("giants.png", PngOf(1000000, 1000000) + data));
    // claims two gigabytes
    const std::string chunk = BigEndian32(0x7f000000) + "eXIf" + std::string(40, '\0');
    EXPECT_TRUE(Says(ImageMessage(Put("chunk.png", PngOf(64, 16) + chunk + data)), "truncated"));
    std::string claim = "....ftypheic....mif1heic", box = BigEndian32(20) + "ispe" +
                                                          BigEndian32(0) + BigEndian32(60000) +
                                                          BigEndian32(60000);
    claim.replace(0, 4, BigEndian32(24));
    EXPECT_TRUE(Says(ImageMessage(Put("giant.heic", claim + box)), "claims more"));
  });
  EXPECT_LT(growth, 100 << 20);
  EXPECT_GT(ClaimedHeifPixels(BigEndian32(20) + "ispe" + BigEndian32(0) + BigEndian32(0xffffffff) +
                              BigEndian32(0xffffffff)),
            kMostPixels);
  EXPECT_EQ(ReadImage(PutJpeg("strip.jpg", 1, 20000)).height,
            20000);  // unusual, but a valid picture
}

TEST_F(HostileImage, ThumbnailsEndMarkDoesNotStandForThePhotographs) {
  const std::string photo = ReadFile(PutJpeg("photo.jpg")),
                    thumbnail = ReadFile(PutJpeg("thumbnail.jpg", 64, 48));
  ASSERT_LT(thumbnail.size(), 60000u);
  const std::string segment = "Exif" + std::string(2, '\0') + thumbnail;
  const std::string with = photo.substr(0, 2) + "\xff\xe1" +
                           BigEndian32(static_cast<std::uint32_t>(segment.size() + 2)).substr(2) +
                           segment + photo.substr(2);
  EXPECT_EQ(ReadImage(Put("with.jpg", with)).data, ReadImage(folder_ / "photo.jpg").data);
  const std::string cut = with.substr(0, with.size() - photo.size() / 3);
  ASSERT_LT(cut.size(), 65536u) << "the thumbnail's mark must lie where the end is looked for";
  const fs::path path = Put("cut.jpg", cut);
  EXPECT_TRUE(Says(Message<InputError>(path, [&] { ReadImage(path); }), "truncated"));
  EXPECT_TRUE(IsWholeImage(with + "what a camera adds", "jpeg"));
}

using HostileModel = HostileFile;

std::string CamerasText(const std::string& camera) { return "1 OPENCV " + camera + "\n"; }

TEST_F(HostileModel, CamerasAndPosesThatCannotBeAreInputErrors) {
  const std::string good_camera = "640 480 500 500 320 240 0 0 0 0", good_pose = "1 0 0 0 0 0 3";
  const auto model = [&](const std::string& camera, const std::string& pose,
                         const std::string& point) {
    Put("cameras.txt", CamerasText(camera));
    Put("images.txt", "1 " + pose + " 1 a.jpg\n\n");
    Put("points3D.txt", "1 " + point + " 9 9 9 0.5 1 0\n");
    return folder_;
  };
  EXPECT_EQ(ReadColmapModel(model(good_camera, good_pose, "0 0 0")).views.size(), 1u);
  for (const char* bad : {"640 480 0 500 320 240 0 0 0 0", "640 480 1e300 500 320 240 0 0 0 0",
                          "640 480 500 500 320 240 1e30 0 0 0", "0 480 500 500 320 240 0 0 0 0",
                          "4294967297 480 500 500 320 240 0 0 0 0",
                          "60000 60000 500 500 320 240 0 0 0 0", "640 480 -500 500 320 240 0 0 0 0",
                          "640 480 500 1e-300 320 240 0 0 0 0", "640 480 nan 500 320 240 0 0 0 0"})
    Message<InputError>("cameras.txt", [&] { ReadColmapModel(model(bad, good_pose, "0 0 0")); });
  for (const char* bad :
       {"0 0 0 0 0 0 3", "1 0 0 0 0 0 1e200", "nan 0 0 0 0 0 3", "1e200 0 0 0 0 0 3"})
    Message<InputError>("images.txt", [&] { ReadColmapModel(model(good_camera, bad, "0 0 0")); });
  Message<InputError>("points3D.txt",
                      [&] { ReadColmapModel(model(good_camera, good_pose, "0 1e99 0")); });
}

TEST_F(HostileModel, NumbersThatAreNotFiniteInBinaryModelsAreInputErrors) {
  Scene scene;
  View view;
  view.name = "a.jpg";
  view.camera = {640, 480, 500, 500, 320, 240, 0, 0, 0, 0};
  scene.views = {view};
  const auto spoilt = [&](const std::function<void(View&)>& spoil) {
    Scene bad = scene;
    spoil(bad.views[0]);
    WriteColmapModel(folder_, bad);
    return folder_;
  };
  Message<InputError>("cameras.bin",
                      [&] { ReadColmapModel(spoilt([](View& v) { v.camera.k1 = NAN; })); });
  Message<InputError>("cameras.bin",
                      [&] { ReadColmapModel(spoilt([](View& v) { v.camera.fy = INFINITY; })); });
  Message<InputError>("images.bin", [&] {
    ReadColmapModel(spoilt([](View& v) { v.camera_from_world.translation.x() = NAN; }));
  });
  Message<InputError>("images.bin", [&] {
    ReadColmapModel(spoilt([](View& v) { v.camera_from_world.rotation.coeffs().setZero(); }));
  });
}

TEST_F(HostileModel, TransformsWithCamerasThatCannotBeAreInputErrors) {
  const auto file = [&](const std::string& camera, const std::string& x = "0") {
    return Put("transforms.json",
               "{" + camera +
                   R"(, "frames": [{"file_path": "a.jpg", "transform_matrix": [[1,0,0,)" + x +
                   "],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]}");
  };
  EXPECT_EQ(ReadPoses(file(R"("fl_x": 900, "w": 640, "h": 480)")).size(), 1u);
  for (const char* bad :
       {R"("fl_x": 900, "w": 1e300, "h": 480)", R"("fl_x": 900, "w": -5, "h": 480)",
        R"("fl_x": 1e300, "w": 640, "h": 480)"})
    Message<InputError>("transforms.json", [&] { ReadPoses(file(bad)); });
  Message<InputError>("transforms.json",
                      [&] { ReadPoses(file(R"("fl_x": 900, "w": 640, "h": 480)", "1e200")); });
}

using HostilePicks = HostileFile;

TEST_F(HostilePicks, XmlWithoutItsRootOrWithoutEndIsAnInputError) {
  const Mesh mesh = MakeIcosphere(1);
  const auto refuse = [&](const std::string& text) {
    const fs::path path = Put("picks.pp", text);
    return Message<InputError>(path, [&] { ReadPicks(path, mesh); });
  };
  EXPECT_TRUE(
      Says(refuse("<Foo><point x=\"0\" y=\"0\" z=\"0\" name=\"a\"/></Foo>"), "PickedPoints"));
  EXPECT_TRUE(Says(refuse("<?xml version=\"1.0\"?>\n"), "PickedPoints"));
  std::string deep;
  for (int k = 0; k < 200000; ++k) deep += "<a>";
  EXPECT_TRUE(Says(refuse(deep), "levels"));
  std::string hidden;  // end tags without a start tag must not hide the depth
  for (int k = 0; k < 200000; ++k) hidden += "<a b=\"/></a>\"><!-- </a></a> -->";
  EXPECT_TRUE(Says(refuse(hidden), "levels"));
  refuse("<PickedPoints><point x=\"1e300\" y=\"0\" z=\"0\" name=\"a\"/></PickedPoints>");
  std::string flat = "<!DOCTYPE PickedPoints>\n<PickedPoints>\n";
  for (int k = 0; k < 300; ++k)
    flat += "<point x=\"1\" y=\"0\" z=\"0\" active=\"1\" name=\"p" + std::to_string(k) + "\"/>\n";
  EXPECT_EQ(ReadPicks(Put("flat.pp", flat + "</PickedPoints>\n"), MakeIcosphere(3)).size(), 300u);
}

TEST_F(HostilePicks, JsonNestedDeepIsAnInputError) {
  const Mesh mesh = MakeIcosphere(1);
  const std::string deep = std::string(500000, '[') + std::string(500000, ']');
  const fs::path picks = Put("picks.json", R"({"mesh":)" + deep + R"(,"landmarks":[]})");
  Message<InputError>(picks, [&] { ReadPicks(picks, mesh); });
  const fs::path pairs = Put("pairs.json", R"({"source":)" + deep + R"(,"pairs":[]})");
  Message<InputError>(pairs, [&] { ReadLandmarkPairs({pairs}, mesh, mesh); });
  const fs::path transforms = Put("transforms.json", R"({"frames":)" + deep + "}");
  Message<InputError>(transforms, [&] { ReadPoses(transforms); });
  EXPECT_THROW(ParseTimeline(R"({"fps":24,"keys":)" + deep + "}", "timeline.json"), Error);
  EXPECT_TRUE(IsShallowJson(R"({"a":"[[[[[[[[[[[[\"[[[[[[[[[[[[[","b":[[1]]})"));
  EXPECT_TRUE(IsShallowJson("[" + std::string(150, '"') + "]"));
  EXPECT_FALSE(IsShallowJson(deep));
}

using HostileImageSet = HostileFile;

TEST_F(HostileImageSet, NamesThatLeadOutsideOfTheFolderAreRefused) {
  const fs::path images = folder_ / "images";
  fs::create_directories(images / "masks");
  Put("secret.jpg", "x");
  WriteFile(images / "a.jpg", "x");
  WriteFile(images / "masks" / "a.jpg.png", "x");
  fs::create_symlink("../secret.jpg", images / "link.jpg");
  fs::create_symlink("..", images / "way");
  const auto read = [&](const std::string& name, const std::string& mask) {
    WriteFile(images / "capture.json", R"({"images":[{"name":")" + name + R"(","mask":")" + mask +
                                           R"(","width":4,"height":3}]})");
    return ReadImageSet(images);
  };
  EXPECT_EQ(read("a.jpg", "masks/a.jpg.png").images.size(), 1u);
  EXPECT_EQ(read("a.jpg", "").images.size(), 1u);
  for (const std::string bad :
       {"../secret.jpg", "/etc/passwd", "masks/../../secret.jpg", "masks/a.jpg.png", "..", ".", "",
        "link.jpg", "way/secret.jpg", "a.jpg\\u0000b"})
    EXPECT_TRUE(Says(Message<InputError>("capture.json", [&] { read(bad, ""); }), "photograph"))
        << bad;
  for (const std::string bad : {"../secret.jpg", "/etc/passwd", "masks/../../secret.jpg",
                                "link.jpg", "way/secret.jpg", "."})
    EXPECT_TRUE(Says(Message<InputError>("capture.json", [&] { read("a.jpg", bad); }), "mask"))
        << bad;
}

TEST_F(HostileImageSet, SizesThatCannotBeAndNamesTwiceAreRefused) {
  WriteFile(folder_ / "a.jpg", "x");
  const auto refuse = [&](const std::string& images) {
    WriteFile(folder_ / "capture.json", R"({"images":[)" + images + "]}");
    return Message<InputError>("capture.json", [&] { ReadImageSet(folder_); });
  };
  refuse(R"({"name":"a.jpg","width":-1,"height":3})");
  refuse(R"({"name":"a.jpg","width":100000,"height":100000})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"focal_px":-1})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"photograph":[-8,6]})");
  refuse(R"({"name":"a.jpg","width":4,"height":3,"photograph":[8]})");
  EXPECT_TRUE(
      Says(refuse(R"({"name":"a.jpg","width":4,"height":3},{"name":"a.jpg","width":4,"height":3})"),
           "twice"));
  refuse(R"({"name":"a.jpg","width":4,"height":3,"group":)" + std::string(500000, '['));
}

TEST(Utf8, KnowsWhatIsAndNamesWhatIsNot) {
  for (const char* good : {"", "clay", "T\xc3\xb6pferei", "\xe2\x82\xac", "\xf0\x9f\x90\xa2"})
    EXPECT_TRUE(IsValidUtf8(good)) << good;
  for (const char* bad :
       {"\xff", "\xc3", "a\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82"})
    EXPECT_FALSE(IsValidUtf8(bad));
  EXPECT_EQ(WithoutOddBytes("T\xf6pferei \xe2\x82\xac"), "T?pferei \xe2\x82\xac");
  EXPECT_EQ(PrintableName("photos/T\xf6pf.jpg"), "T\\xf6pf.jpg");
}

}  // namespace keypose::hostile_files_test
