// Each feature of glTF 2.0 and of its extensions that tells where a surface lies or what colour it
// has is either read, with these numbers, or refused by its name.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/meshes/glb_mesh.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::gltf_features_test {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Json = nlohmann::json;
using Numbers = std::vector<double>;

constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123,
              kUnsignedInt = 5125, kFloat = 5126, kDouble = 5130;

template <class T>
void PutAs(double number, std::string* bytes) {
  const T value = static_cast<T>(number);
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

void PutNumber(double number, int component, std::string* bytes) {
  if (component == kByte) PutAs<std::int8_t>(number, bytes);
  if (component == kUnsignedByte) PutAs<std::uint8_t>(number, bytes);
  if (component == kShort) PutAs<std::int16_t>(number, bytes);
  if (component == kUnsignedShort) PutAs<std::uint16_t>(number, bytes);
  if (component == kUnsignedInt) PutAs<std::uint32_t>(number, bytes);
  if (component == kFloat) PutAs<float>(number, bytes);
  if (component == kDouble) PutAs<double>(number, bytes);
}

std::string Packed(const Numbers& numbers, int component = kFloat) {
  std::string bytes;
  for (const double number : numbers) PutNumber(number, component, &bytes);
  return bytes;
}

/// The corners of a triangle in glTF's xy plane.
const Numbers kPoints = {0, 0, 0, 2, 0, 0, 0, 4, 0};
const Numbers kUvs = {0.125, 0.25, 0.5, 0.25, 0.125, 0.75};

/// A glTF that tests change before it is written. It begins as one triangle on one node.
class Maker {
 public:
  Maker() {
    root["asset"]["version"] = "2.0";
    root["buffers"] = Json::array({Json::object()});
    root["scene"] = 0;
    root["scenes"] = Json::parse(R"([{"nodes": [0]}])");
    root["nodes"] = Json::parse(R"([{"mesh": 0}])");
    part()["attributes"]["POSITION"] = Accessor(kPoints, "VEC3");
  }

  Json& part() { return root["meshes"][0]["primitives"][0]; }
  Json& node() { return root["nodes"][0]; }

  int View(const std::string& bytes, int stride = 0) {
    Json view = {{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", bytes.size()}};
    if (stride > 0) view["byteStride"] = stride;
    root["bufferViews"].push_back(view);
    binary += bytes;
    binary.resize((binary.size() + 3) / 4 * 4);
    return static_cast<int>(root["bufferViews"].size()) - 1;
  }

  int Accessor(const Numbers& numbers, const std::string& type, int component = kFloat,
               bool normalized = false) {
    const std::size_t columns = type == "MAT4" ? 16 : type == "SCALAR" ? 1 : type.back() - '0';
    root["accessors"].push_back({{"bufferView", View(Packed(numbers, component))},
                                 {"componentType", component},
                                 {"count", numbers.size() / columns},
                                 {"type", type},
                                 {"normalized", normalized}});
    return static_cast<int>(root["accessors"].size()) - 1;
  }

  /// A texture, a material that shows it, and coordinates.
  void Look(const std::string& picture) {
    root["images"] = {{{"bufferView", View(picture)}}};
    root["textures"] = Json::parse(R"([{"source": 0}])");
    root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 0;
    part()["material"] = 0;
    part()["attributes"]["TEXCOORD_0"] = Accessor(kUvs, "VEC2");
  }
  Json& color() { return root["materials"][0]["pbrMetallicRoughness"]; }

  std::string Glb() {
    root["buffers"][0]["byteLength"] = binary.size();
    std::string json = root.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::string bytes = "glTF";
    const auto word = [&](std::size_t value) {
      PutAs<std::uint32_t>(static_cast<double>(value), &bytes);
    };
    word(2);
    word(12 + 8 + json.size() + 8 + binary.size());
    word(json.size());
    bytes += "JSON" + json;
    word(binary.size());
    bytes += std::string("BIN\0", 4) + binary;
    return bytes;
  }

  Json root;
  std::string binary;
};

Image8 Gradient() {
  Image8 image(16, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(16 * x);
      image.at(x, y)[1] = static_cast<std::uint8_t>(16 * y);
      image.at(x, y)[2] = 50;
    }
  return image;
}

class GltfFeatures : public ::testing::Test, public TestingFolder {
 protected:
  Scan Read(Maker maker, bool join = true) {
    WriteFile(folder_ / "a.glb", maker.Glb());
    return ReadScan(folder_ / "a.glb", join);
  }
  std::string Refusal(const Maker& maker) {
    try {
      Read(maker);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("a.glb"));
      return error.what();
    }
    return "was read";
  }
  /// The three corners of the only face, in glTF's axes, one after the other.
  static Numbers Corners(const Scan& scan, int face = 0) {
    Numbers numbers;
    for (int k = 0; k < 3; ++k) {
      const auto p = scan.mesh.points.row(scan.mesh.faces(face, k));
      numbers.insert(numbers.end(), {p[0], p[2], -p[1]});
    }
    return numbers;
  }
  /// Their texture coordinates, v down.
  static Numbers Uvs(const Scan& scan) {
    Numbers numbers;
    for (int k = 0; k < 3; ++k) {
      const auto uv = scan.mesh.uvs.row(scan.mesh.uv_faces(0, k));
      numbers.insert(numbers.end(), {uv[0], 1 - uv[1]});
    }
    return numbers;
  }
  static void ExpectNear(const Numbers& read, const Numbers& right, double tolerance = 1e-6) {
    ASSERT_EQ(read.size(), right.size());
    for (std::size_t i = 0; i < read.size(); ++i) EXPECT_NEAR(read[i], right[i], tolerance) << i;
  }
  /// The colour that the texture shows at a corner of a face, in its middle where `inward` is 1/3.
  static Eigen::Vector3i ColorAt(const Scan& scan, int corner, double inward = 0, int face = 0) {
    const Image8 texture = DecodePicture(scan.texture, "texture");
    Eigen::RowVector2d uv = Eigen::RowVector2d::Zero();
    for (int k = 0; k < 3; ++k)
      uv +=
          (k == corner ? 1 - 2 * inward : inward) * scan.mesh.uvs.row(scan.mesh.uv_faces(face, k));
    const int x = std::min(texture.width - 1, static_cast<int>(uv[0] * texture.width)),
              y = std::min(texture.height - 1, static_cast<int>((1 - uv[1]) * texture.height));
    return {texture.at(x, y)[0], texture.at(x, y)[1], texture.at(x, y)[2]};
  }
};

TEST_F(GltfFeatures, PositionsOfAllComponentTypes) {
  for (const int component :
       {kByte, kUnsignedByte, kShort, kUnsignedShort, kUnsignedInt, kFloat, kDouble}) {
    Maker maker;
    maker.part()["attributes"]["POSITION"] = maker.Accessor(kPoints, "VEC3", component);
    ExpectNear(Corners(Read(maker)), kPoints);
  }
  for (const auto& [component, white] :
       {std::pair{kByte, 127.0}, {kUnsignedByte, 255}, {kShort, 32767}, {kUnsignedShort, 65535}}) {
    Maker maker;
    const bool is_signed = component == kByte || component == kShort;
    const double least = is_signed ? -white - 1 : 0;
    maker.part()["attributes"]["POSITION"] =
        maker.Accessor({least, 0, 0, white, 0, 0, 0, white, 0}, "VEC3", component, true);
    ExpectNear(Corners(Read(maker)), {is_signed ? -1.0 : 0.0, 0, 0, 1, 0, 0, 0, 1, 0});
  }
  Maker maker;
  maker.root["accessors"][0]["componentType"] = 5131;
  EXPECT_THAT(Refusal(maker), HasSubstr("componentType 5131"));
}

TEST_F(GltfFeatures, IndicesOfAllTypesAndNone) {
  for (const int component : {kUnsignedByte, kUnsignedShort, kUnsignedInt}) {
    Maker maker;
    maker.part()["indices"] = maker.Accessor({1, 2, 0}, "SCALAR", component);
    ExpectNear(Corners(Read(maker)), {2, 0, 0, 0, 4, 0, 0, 0, 0});
  }
}

TEST_F(GltfFeatures, TrianglesStripsAndFansAreReadAndOthersAreSaid) {
  const Numbers square = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
  Maker strip;
  strip.part() = {{"attributes", {{"POSITION", strip.Accessor(square, "VEC3")}}}, {"mode", 5}};
  ExpectNear(Corners(Read(strip), 1), {1, 0, 0, 1, 1, 0, 0, 1, 0});
  Maker fan;
  const Numbers around = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  fan.part() = {{"attributes", {{"POSITION", fan.Accessor(around, "VEC3")}}}, {"mode", 6}};
  ExpectNear(Corners(Read(fan), 1), {0, 0, 0, 1, 1, 0, 0, 1, 0});
  for (int mode = 0; mode < 4; ++mode) {
    Maker maker;
    maker.part()["mode"] = mode;
    EXPECT_THAT(Refusal(maker), HasSubstr("no triangles"));
    maker.root["meshes"][0]["primitives"].push_back(maker.part());
    maker.part()["mode"] = 4;
    EXPECT_THAT(Read(maker).warnings, ::testing::ElementsAre(HasSubstr("lines or points")));
  }
}

TEST_F(GltfFeatures, StridesAndOffsets) {
  Maker maker;
  const Numbers mixed = {9, 0, 0, 0, 9, 9, 2, 0, 0, 9, 9, 0, 4, 0, 9};
  maker.root["accessors"][0] = {{"bufferView", maker.View(Packed(mixed), 20)},
                                {"byteOffset", 4},
                                {"componentType", kFloat},
                                {"count", 3},
                                {"type", "VEC3"}};
  ExpectNear(Corners(Read(maker)), kPoints);
}

TEST_F(GltfFeatures, SparseAccessorsWithAndWithoutABase) {
  for (const bool base : {true, false})
    for (const int component : {kUnsignedByte, kUnsignedShort, kUnsignedInt}) {
      Maker maker;
      Json& accessor = maker.root["accessors"][0];
      if (!base) accessor.erase("bufferView");
      const int places = maker.View(Packed({1, 2}, component)),
                values = maker.View(Packed({5, 0, 0, 0, 6, 1}));
      maker.root["accessors"][0]["sparse"] = {
          {"count", 2},
          {"indices", {{"bufferView", places}, {"componentType", component}}},
          {"values", {{"bufferView", values}}}};
      ExpectNear(Corners(Read(maker)), {0, 0, 0, 5, 0, 0, 0, 6, 1});
      maker.root["accessors"][0]["count"] = 2;
      EXPECT_THAT(Refusal(maker), HasSubstr("a sparse entry beyond its list"));
    }
}

TEST_F(GltfFeatures, ShapesThatAreSwitchedOn) {
  Maker maker;
  const int target = maker.Accessor({0, 0, 1, 0, 0, 1, 0, 0, 3}, "VEC3");
  maker.part()["targets"] = {{{"POSITION", target}}};
  ExpectNear(Corners(Read(maker)), kPoints);
  maker.root["meshes"][0]["weights"] = {0.5};
  ExpectNear(Corners(Read(maker)), {0, 0, 0.5, 2, 0, 0.5, 0, 4, 1.5});
  maker.node()["weights"] = {-1};
  ExpectNear(Corners(Read(maker)), {0, 0, -1, 2, 0, -1, 0, 4, -3});
}

/// A skin of two joints: the first is moved, the second turned; the mesh's node must not count.
Maker Skinned() {
  Maker maker;
  maker.root["nodes"] = Json::parse(
      R"([{"mesh": 0, "skin": 0, "translation": [100, 0, 0], "scale": [7, 7, 7]},
          {"translation": [1, 0, 0], "children": [2]},
          {"translation": [0, 1, 0], "scale": [2, 2, 2]}])");
  maker.root["scenes"][0]["nodes"] = {0, 1};
  maker.part()["attributes"]["JOINTS_0"] =
      maker.Accessor({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, "VEC4", kUnsignedByte);
  maker.part()["attributes"]["WEIGHTS_0"] =
      maker.Accessor({255, 0, 0, 0, 0, 255, 0, 0, 51, 204, 0, 0}, "VEC4", kUnsignedByte, true);
  Numbers binds(32, 0);
  for (int j = 0; j < 2; ++j)
    for (int d = 0; d < 4; ++d) binds[static_cast<std::size_t>(16 * j + 5 * d)] = 1;
  binds[16 + 14] = 3;  // moves z before the second joint
  maker.root["skins"] = {
      {{"joints", {1, 2}}, {"inverseBindMatrices", maker.Accessor(binds, "MAT4")}}};
  return maker;
}

TEST_F(GltfFeatures, OfASkinTheJointsCountAndNotTheNode) {
  // First joint: p + (1 0 0). Second: 2 (p + (0 0 3)) + (1 1 0).
  ExpectNear(Corners(Read(Skinned())), {1, 0, 0, 5, 1, 6, 1, 0.2 * 4 + 0.8 * 9, 0.8 * 6});
  Maker none = Skinned();
  none.root["skins"][0].erase("inverseBindMatrices");
  ExpectNear(Corners(Read(none)), {1, 0, 0, 5, 1, 0, 1, 0.2 * 4 + 0.8 * 9, 0});
  Maker second = Skinned();
  second.part()["attributes"]["JOINTS_1"] = second.part()["attributes"]["JOINTS_0"];
  second.part()["attributes"]["WEIGHTS_1"] = second.part()["attributes"]["WEIGHTS_0"];
  ExpectNear(Corners(Read(second)), Corners(Read(Skinned())));
  Maker broken = Skinned();
  broken.root["skins"][0]["joints"] = {1};
  broken.root["skins"][0].erase("inverseBindMatrices");
  EXPECT_THAT(Refusal(broken), HasSubstr("a joint that does not exist"));
}

TEST_F(GltfFeatures, NodesPlaceByMatrixOrByPartsAndMayRepeatAMesh) {
  Maker maker;
  maker.root["nodes"] = Json::parse(
      R"([{"children": [1, 2], "translation": [0, 0, 1]},
          {"mesh": 0, "rotation": [0, 0, 0.70710678, 0.70710678], "scale": [2, 1, 1]},
          {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1]}])");
  const Scan scan = Read(maker);
  ASSERT_EQ(scan.mesh.face_count(), 2);
  ExpectNear(Corners(scan, 0), {0, 0, 1, 0, 4, 1, -4, 0, 1});
  ExpectNear(Corners(scan, 1), {5, 6, 8, 7, 6, 8, 5, 10, 8});
  Maker mirrored;
  mirrored.node()["scale"] = {-1, 1, 1};
  ExpectNear(Corners(Read(mirrored)), {0, 0, 0, 0, 4, 0, -2, 0, 0});
}

TEST_F(GltfFeatures, TheSceneThatIsShownCounts) {
  Maker maker;
  maker.root["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, 9}}});
  maker.root["scenes"].push_back({{"nodes", {1}}});
  maker.root["scene"] = 1;
  ExpectNear(Corners(Read(maker)), {0, 0, 9, 2, 0, 9, 0, 4, 9});
  maker.root.erase("scene");
  const Scan first = Read(maker);
  ExpectNear(Corners(first), kPoints);
  EXPECT_THAT(first.warnings, ::testing::ElementsAre(HasSubstr("has 2 scenes")));
  maker.root.erase("scenes");
  EXPECT_EQ(Read(maker).mesh.face_count(), 2);
}

TEST_F(GltfFeatures, InstancesHiddenNodesAndFarOrigins) {
  Maker maker;
  maker.node()["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
      {"TRANSLATION", maker.Accessor({0, 0, 0, 10, 0, 0}, "VEC3")},
      {"ROTATION", maker.Accessor({0, 0, 0, 1, 0, 0, 1, 0}, "VEC4")},
      {"SCALE", maker.Accessor({1, 1, 1, 2, 2, 2}, "VEC3")}};
  const Scan twice = Read(maker);
  ASSERT_EQ(twice.mesh.face_count(), 2);
  ExpectNear(Corners(twice, 1), {10, 0, 0, 6, 0, 0, 10, -8, 0});
  Maker hidden;
  hidden.root["nodes"].push_back(
      Json::parse(R"({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}})"));
  hidden.root["scenes"][0]["nodes"] = {0, 1};
  EXPECT_EQ(Read(hidden).mesh.face_count(), 1);
  Maker far;
  far.root["extensions"]["CESIUM_RTC"]["center"] = {500000.125, 10, 4600000.5};
  ExpectNear(Corners(Read(far)),
             {500000.125, 10, 4600000.5, 500002.125, 10, 4600000.5, 500000.125, 14, 4600000.5});
}

TEST_F(GltfFeatures, TexturesAreMovedTurnedAndScaledAndTakeOtherCoordinates) {
  Maker maker;
  maker.Look(PngBytes(Gradient()));
  ExpectNear(Uvs(Read(maker)), kUvs);
  Json& moved = maker.color()["baseColorTexture"]["extensions"]["KHR_texture_transform"];
  moved = {{"offset", {0.25, 0.125}}, {"scale", {0.5, 0.25}}};
  ExpectNear(Uvs(Read(maker)), {0.3125, 0.1875, 0.5, 0.1875, 0.3125, 0.3125});
  // The example of the extension's page: the lower left quarter, turned.
  moved = {{"offset", {0, 1}}, {"rotation", M_PI / 2}, {"scale", {0.5, 0.5}}};
  ExpectNear(Uvs(Read(maker)), {0.125, 0.9375, 0.125, 0.75, 0.375, 0.9375});
  maker.color()["baseColorTexture"]["texCoord"] = 3;
  moved = {{"texCoord", 2}};
  maker.part()["attributes"]["TEXCOORD_2"] =
      maker.Accessor({0, 65535, 65535, 0, 0, 0}, "VEC2", kUnsignedShort, true);
  ExpectNear(Uvs(Read(maker)), {0, 1, 1, 0, 0, 0});
  maker.color()["baseColorTexture"].erase("extensions");
  const Scan without = Read(maker);
  EXPECT_FALSE(without.mesh.has_uvs());
  EXPECT_THAT(without.warnings, ::testing::ElementsAre(HasSubstr("has no TEXCOORD_3")));
}

TEST_F(GltfFeatures, RepeatsMirrorsAndClampsAreBaked) {
  const auto at = [&](const char* wrap, double u, double v) {
    Maker maker;
    maker.Look(PngBytes(Gradient()));
    const double step = 1.0 / 64;
    maker.part()["attributes"]["TEXCOORD_0"] =
        maker.Accessor({u, v, u + 1 + step, v, u, v + step}, "VEC2");
    if (wrap) {
      maker.root["samplers"] =
          Json::array({{{"wrapS", std::stoi(wrap)}, {"wrapT", std::stoi(wrap)}}});
      maker.root["textures"][0]["sampler"] = 0;
    }
    return ColorAt(Read(maker), 0);
  };
  const double u = 4.5 / 16, v = 9.5 / 16;
  EXPECT_EQ(at(nullptr, u + 3, v - 2), Eigen::Vector3i(64, 144, 50));
  EXPECT_EQ(at("10497", u - 1, v), Eigen::Vector3i(64, 144, 50));
  EXPECT_EQ(at("33648", u + 1, v), Eigen::Vector3i(16 * 11, 144, 50));
  EXPECT_EQ(at("33648", u - 2, v), Eigen::Vector3i(64, 144, 50));
  EXPECT_EQ(at("33071", u + 1, v - 1), Eigen::Vector3i(240, 0, 50));
}

TEST_F(GltfFeatures, WholeRepeatsKeepThePictureAsItIs) {
  Maker maker;
  maker.Look(PngBytes(Gradient()));
  maker.part()["attributes"]["TEXCOORD_0"] =
      maker.Accessor({3.125, -1.75, 3.5, -1.75, 3.125, -1.25}, "VEC2");
  const Scan scan = Read(maker);
  ExpectNear(Uvs(scan), kUvs);
  EXPECT_EQ(scan.texture, PngBytes(Gradient()));
}

TEST_F(GltfFeatures, FactorsColorsAndKindsOfMaterials) {
  const double half = 0.2158605;  // linear light of the level 128
  Maker factor;
  factor.Look(PngBytes(Image8(4, 4, 3, 255)));
  factor.color()["baseColorFactor"] = {half, 1, 0, 1};
  const Eigen::Vector3i mixed(128, 255, 0);
  EXPECT_EQ(ColorAt(Read(factor), 0, 0.3), mixed);
  Maker unlit = factor;
  unlit.root["materials"][0]["extensions"]["KHR_materials_unlit"] = Json::object();
  EXPECT_EQ(ColorAt(Read(unlit), 0, 0.3), mixed);
  Maker gloss = factor;
  gloss.root["materials"][0] = Json::parse(
      R"({"extensions": {"KHR_materials_pbrSpecularGlossiness":
          {"diffuseTexture": {"index": 0}, "diffuseFactor": [1, 0, 0, 1]}}})");
  EXPECT_EQ(ColorAt(Read(gloss), 0, 0.3), Eigen::Vector3i(255, 0, 0));
  Maker shining = factor;
  shining.root["materials"][0] = Json::parse(
      R"({"pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 1]},
          "emissiveTexture": {"index": 0}, "emissiveFactor": [0, 1, 0]})");
  EXPECT_EQ(ColorAt(Read(shining), 0, 0.3), Eigen::Vector3i(0, 255, 0));
  Maker tinted = factor;
  tinted.part()["attributes"]["COLOR_0"] =
      tinted.Accessor({0, 255, 255, 0, 255, 255, 0, 255, 255}, "VEC3", kUnsignedByte, true);
  EXPECT_EQ(ColorAt(Read(tinted), 0, 0.3), Eigen::Vector3i(0, 255, 0));
  tinted.part()["attributes"]["COLOR_0"] =
      tinted.Accessor({0, 255, 255, 255, 255, 255, 0, 255, 255}, "VEC3", kUnsignedByte, true);
  EXPECT_THAT(Read(tinted).warnings, ::testing::ElementsAre(HasSubstr("COLOR_0")));
}

TEST_F(GltfFeatures, ColorsOfVerticesWithoutATexture) {
  for (const auto& [component, white] :
       {std::pair{kUnsignedByte, 255.0}, {kUnsignedShort, 65535.0}, {kFloat, 1.0}})
    for (const int columns : {3, 4}) {
      Numbers colors;
      for (int v = 0; v < 3; ++v)
        for (int c = 0; c < columns; ++c) colors.push_back(c == v ? white : 0);
      Maker maker;
      maker.part()["attributes"]["COLOR_0"] =
          maker.Accessor(colors, "VEC" + std::to_string(columns), component, component != kFloat);
      const Scan scan = Read(maker);
      ASSERT_EQ(scan.mesh.colors.rows(), 3);
      EXPECT_EQ(scan.mesh.colors.cast<int>(), Eigen::Matrix3i(255 * Eigen::Matrix3i::Identity()));
    }
}

TEST_F(GltfFeatures, PartsWithAndWithoutATextureShareOneTexture) {
  Maker maker;
  maker.Look(PngBytes(Image8(4, 4, 3, 200)));
  maker.root["meshes"][0]["primitives"].push_back(
      {{"attributes",
        {{"POSITION", maker.part()["attributes"]["POSITION"]},
         {"COLOR_0", maker.Accessor({1, 0, 0, 0, 1, 0, 0, 0, 1}, "VEC3")}}}});
  const Scan scan = Read(maker);
  EXPECT_THAT(scan.warnings, IsEmpty());
  EXPECT_EQ(ColorAt(scan, 0, 0.3, 0), Eigen::Vector3i(200, 200, 200));
  EXPECT_EQ(ColorAt(scan, 0, 0, 1), Eigen::Vector3i(255, 0, 0));
  EXPECT_EQ(ColorAt(scan, 1, 0, 1), Eigen::Vector3i(0, 255, 0));
  EXPECT_EQ(ColorAt(scan, 2, 0, 1), Eigen::Vector3i(0, 0, 255));
}

TEST_F(GltfFeatures, TexturesOfExtensionsAreReadOrNamed) {
  for (const char* extension :
       {"EXT_texture_webp", "KHR_texture_basisu", "MSFT_texture_dds", "EXT_texture_avif"}) {
    Maker maker;
    maker.Look("\xabKTX 20\xbb and so on");
    maker.root["textures"][0] = {{"extensions", {{extension, {{"source", 0}}}}}};
    maker.root["extensionsUsed"] = {extension};
    const Scan scan = Read(maker);
    EXPECT_EQ(scan.texture, "");
    EXPECT_THAT(scan.warnings, ::testing::ElementsAre(HasSubstr(extension)));
    maker.root["extensionsRequired"] = {extension};
    EXPECT_THAT(Refusal(maker), HasSubstr(extension));
    // With a picture that any program reads beside it.
    maker.root["images"].push_back({{"bufferView", maker.View(PngBytes(Gradient()))}});
    maker.root["textures"][0]["source"] = 1;
    EXPECT_EQ(Read(maker).texture, PngBytes(Gradient()));
  }
}

TEST_F(GltfFeatures, FilesBesideAndDataInside) {
  Maker maker;
  maker.Look(PngBytes(Gradient()));
  Json root = maker.root;
  root["buffers"][0] = {{"uri", "my%20data.bin"}, {"byteLength", maker.binary.size()}};
  root["images"][0] = {{"uri", "maps/skin.png"}};
  WriteFile(folder_ / "my data.bin", maker.binary);
  std::filesystem::create_directories(folder_ / "maps");
  WriteFile(folder_ / "maps/skin.png", PngBytes(Gradient()));
  WriteFile(folder_ / "a.gltf", root.dump());
  Scan scan = ReadScan(folder_ / "a.gltf");
  ExpectNear(Corners(scan), kPoints);
  ExpectNear(Uvs(scan), kUvs);
  EXPECT_EQ(scan.texture, PngBytes(Gradient()));
  EXPECT_EQ(ReadMesh(folder_ / "a.gltf").face_count(), 1);

  root["images"][0] = {{"uri", "gone.png"}};
  WriteFile(folder_ / "a.gltf", root.dump());
  EXPECT_THAT(ReadScan(folder_ / "a.gltf").warnings, ::testing::ElementsAre(HasSubstr("gone.png")));
  root["buffers"][0]["uri"] = "../other.bin";
  WriteFile(folder_ / "a.gltf", root.dump());
  EXPECT_THROW(ReadScan(folder_ / "a.gltf"), InputError);

  // 36 bytes: three points.
  Json small = Maker().root;
  small["buffers"][0] = {
      {"uri",
       "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAAAAQAAAAAAAAAAAAAAAAAAAgEAAAAAA"},
      {"byteLength", 36}};
  WriteFile(folder_ / "a.gltf", small.dump());
  ExpectNear(Corners(ReadScan(folder_ / "a.gltf")), kPoints);
}

TEST_F(GltfFeatures, MeshoptModesAndFilters) {
  const auto pack = [](Maker* maker, int view, const std::string& bytes, std::size_t stride,
                       const char* mode, const char* filter) {
    const std::size_t count = maker->root["bufferViews"][view]["byteLength"].get<std::size_t>();
    const int packed = maker->View(bytes);
    Json& target = maker->root["bufferViews"][view];
    target["extensions"]["EXT_meshopt_compression"] = {
        {"buffer", 0},
        {"byteOffset", maker->root["bufferViews"][packed]["byteOffset"]},
        {"byteLength", bytes.size()},
        {"byteStride", stride},
        {"count", count / stride},
        {"mode", mode},
        {"filter", filter}};
    target["buffer"] = 1;
    target["byteOffset"] = 0;
    maker->root["buffers"][1] = {{"byteLength", 1000}};
  };
  const auto vertices = [](const std::string& bytes, std::size_t stride) {
    std::string out(meshopt_encodeVertexBufferBound(bytes.size() / stride, stride), '\0');
    out.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(out.data()), out.size(),
                                          bytes.data(), bytes.size() / stride, stride));
    return out;
  };
  Maker points;
  pack(&points, 0, vertices(Packed(kPoints), 12), 12, "ATTRIBUTES", "NONE");
  ExpectNear(Corners(Read(points)), kPoints);

  Maker rounded;
  std::vector<float> floats(kPoints.begin(), kPoints.end());
  std::string filtered(36, '\0');
  meshopt_encodeFilterExp(filtered.data(), 3, 12, 15, floats.data());
  pack(&rounded, 0, vertices(filtered, 12), 12, "ATTRIBUTES", "EXPONENTIAL");
  ExpectNear(Corners(Read(rounded)), kPoints, 1e-3);

  const unsigned corners[] = {1, 2, 0};
  std::string triangles(meshopt_encodeIndexBufferBound(3, 3), '\0');
  triangles.resize(meshopt_encodeIndexBuffer(reinterpret_cast<unsigned char*>(triangles.data()),
                                             triangles.size(), corners, 3));
  std::string sequence(meshopt_encodeIndexSequenceBound(3, 3), '\0');
  sequence.resize(meshopt_encodeIndexSequence(reinterpret_cast<unsigned char*>(sequence.data()),
                                              sequence.size(), corners, 3));
  for (const auto& [mode, bytes] :
       {std::pair<const char*, std::string>{"TRIANGLES", triangles}, {"INDICES", sequence}}) {
    Maker maker;
    maker.part()["indices"] = maker.Accessor({1, 2, 0}, "SCALAR", kUnsignedShort);
    pack(&maker, 1, bytes, 2, mode, "NONE");
    Numbers read = Corners(Read(maker));
    std::rotate(read.begin(), read.begin() + 3, read.end());  // a triangle may begin anywhere
    EXPECT_THAT(
        (std::vector<Numbers>{
            {0, 4, 0, 0, 0, 0, 2, 0, 0}, {0, 0, 0, 2, 0, 0, 0, 4, 0}, {2, 0, 0, 0, 4, 0, 0, 0, 0}}),
        ::testing::Contains(read));
  }
  Maker damaged;
  pack(&damaged, 0, "\xa1 of a later version, or damaged", 12, "ATTRIBUTES", "NONE");
  EXPECT_THAT(Refusal(damaged), HasSubstr("EXT_meshopt_compression"));
}

TEST_F(GltfFeatures, Draco) {
  draco::TriangleSoupMeshBuilder builder;
  builder.Start(1);
  const int position =
      builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
  const std::array<std::array<float, 3>, 3> p = {{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}}};
  builder.SetAttributeValuesForFace(position, draco::FaceIndex(0), p[0].data(), p[1].data(),
                                    p[2].data());
  const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
  draco::Encoder encoder;
  encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 14);
  draco::EncoderBuffer buffer;
  ASSERT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
  Maker maker;
  maker.root["accessors"][0].erase("bufferView");
  maker.root["accessors"].push_back(
      {{"componentType", kUnsignedShort}, {"count", 3}, {"type", "SCALAR"}});
  maker.part()["indices"] = 1;
  const int view = maker.View(std::string(buffer.data(), buffer.size()));
  maker.part()["extensions"]["KHR_draco_mesh_compression"] = {
      {"bufferView", view}, {"attributes", {{"POSITION", mesh->attribute(position)->unique_id()}}}};
  maker.root["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  const Scan scan = Read(maker);
  ASSERT_EQ(scan.mesh.face_count(), 1);
  Numbers read = Corners(scan);
  std::sort(read.begin(), read.end());
  ExpectNear(read, {0, 0, 0, 0, 0, 0, 0, 2, 4}, 4.0 / (1 << 13));
  maker.root["bufferViews"][view]["byteLength"] = 20;
  EXPECT_THAT(Refusal(maker), HasSubstr("KHR_draco_mesh_compression"));
}

/// The extensions in Khronos's registry of 2026 that can be required, and one that nobody knows.
TEST_F(GltfFeatures, ARequiredExtensionIsReadOrNamed) {
  for (const char* extension : {"KHR_draco_mesh_compression",
                                "EXT_meshopt_compression",
                                "KHR_meshopt_compression",
                                "KHR_mesh_quantization",
                                "KHR_texture_transform",
                                "KHR_materials_unlit",
                                "KHR_materials_pbrSpecularGlossiness",
                                "EXT_texture_webp",
                                "KHR_texture_basisu",
                                "MSFT_texture_dds",
                                "EXT_texture_avif",
                                "EXT_mesh_gpu_instancing",
                                "KHR_node_visibility",
                                "CESIUM_RTC",
                                "KHR_materials_clearcoat",
                                "KHR_materials_ior",
                                "KHR_lights_punctual",
                                "KHR_animation_pointer",
                                "KHR_materials_variants",
                                "EXT_structural_metadata",
                                "MSFT_lod"}) {
    Maker maker;
    maker.root["extensionsRequired"] = {extension};
    ExpectNear(Corners(Read(maker)), kPoints);
  }
  for (const char* extension : {"KHR_techniques_webgl", "KHR_gaussian_splatting",
                                "KHR_implicit_shapes", "MPEG_mesh_linking", "ACME_folded"}) {
    Maker maker;
    maker.root["extensionsRequired"] = {extension};
    EXPECT_THAT(Refusal(maker), HasSubstr(std::string("the extension ") + extension));
  }
}

TEST_F(GltfFeatures, OtherVersionsAndDamageAreNamed) {
  Maker old;
  old.root["asset"]["version"] = "1.0";
  EXPECT_THAT(Refusal(old), HasSubstr("glTF 1.0"));
  std::string bytes = Maker().Glb();
  const auto message = [&](const std::string& text) -> std::string {
    WriteFile(folder_ / "b.glb", text);
    try {
      ReadScan(folder_ / "b.glb");
    } catch (const InputError& error) {
      return error.what();
    }
    return "was read";
  };
  EXPECT_THAT(message(bytes.substr(0, bytes.size() - 8)), HasSubstr("no whole binary glTF"));
  bytes[4] = 1;
  EXPECT_THAT(message(bytes), HasSubstr("of version 1"));
  EXPECT_THAT(message("{\"asset\": {\"version\": \"2.0\"}"), HasSubstr("JSON is not whole"));
  Maker splats;
  splats.part()["mode"] = 0;
  splats.part()["extensions"]["KHR_gaussian_splatting"] = Json::object();
  EXPECT_THAT(Refusal(splats), HasSubstr("Gaussian splats"));
  Maker twice;
  twice.root["nodes"] = Json::parse(R"([{"children": [1]}, {"mesh": 0}, {"children": [1]}])");
  EXPECT_THAT(Refusal(twice), HasSubstr("a node that lies in two others"));
  Maker uneven;
  uneven.part()["attributes"]["COLOR_0"] = uneven.Accessor({1, 1, 1}, "VEC3");
  EXPECT_THAT(Refusal(uneven), HasSubstr("COLOR_0"));
}

TEST_F(GltfFeatures, TheLeastVersionOfAReaderCounts) {
  Maker maker;
  maker.root["asset"]["version"] = "2.1";
  ExpectNear(Corners(Read(maker)), kPoints);
  maker.root["asset"]["minVersion"] = "2.0";
  ExpectNear(Corners(Read(maker)), kPoints);
  maker.root["asset"]["minVersion"] = "2.1";
  EXPECT_THAT(Refusal(maker), HasSubstr("needs a reader of glTF 2.1 (minVersion)"));
}

}  // namespace keypose::gltf_features_test
