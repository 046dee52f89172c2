// A scan of 300,000 faces with one texture or two in a GLB, as scanning apps export it: from the
// file to one mesh with one texture.
#include <benchmark/benchmark.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/scan_file.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace {

using namespace keypose;
using nlohmann::json;

constexpr int kAround = 500, kAlong = 300;  // 2 * 500 * 300 faces

template <class T>
void Append(std::string* bytes, const T& value) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof value);
}

/// JPEG of 2048 x 2048, full of noise.
std::string Texture(unsigned seed, const TestingFolder& folder) {
  Image8 image(2048, 2048, 3);
  std::mt19937 random(seed);
  for (std::uint8_t& value : image.data) value = static_cast<std::uint8_t>(100 + random() % 56);
  WriteImage(folder.path() / "texture.jpg", image);
  return ReadFile(folder.path() / "texture.jpg");
}

/// A tube of rings in one part or two, a texture each, whose seam along has its vertices twice.
class Glb {
 public:
  Glb(int parts, const TestingFolder& folder) : parts_(parts), folder_(folder) {}
  std::string Text() {
    for (int part = 0; part < parts_; ++part) AddPart(part);
    json head = {{"asset", {{"version", "2.0"}}},
                 {"scene", 0},
                 {"scenes", json::array({{{"nodes", {0}}}})},
                 {"nodes", json::array({{{"mesh", 0}}})},
                 {"meshes", json::array({{{"primitives", primitives_}}})},
                 {"materials", materials_},
                 {"textures", textures_},
                 {"images", images_},
                 {"accessors", accessors_},
                 {"bufferViews", views_},
                 {"buffers", json::array({{{"byteLength", bytes_.size()}}})}};
    std::string text = head.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string file = "glTF";
    Append(&file, std::uint32_t{2});
    Append(&file, static_cast<std::uint32_t>(28 + text.size() + bytes_.size()));
    Append(&file, static_cast<std::uint32_t>(text.size()));
    file += "JSON" + text;
    Append(&file, static_cast<std::uint32_t>(bytes_.size()));
    file += std::string("BIN\0", 4) + bytes_;
    return file;
  }

 private:
  int View(const std::string& data) {
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", data.size()}});
    bytes_ += data;
    bytes_.resize((bytes_.size() + 3) / 4 * 4, '\0');
    return static_cast<int>(views_.size()) - 1;
  }
  int Accessor(const std::string& data, int component, std::size_t count, const char* type) {
    json accessor = {
        {"bufferView", View(data)}, {"componentType", component}, {"count", count}, {"type", type}};
    if (std::string(type) == "VEC3") {
      accessor["min"] = {-9, -9, -9};
      accessor["max"] = {9, 9, 9};
    }
    accessors_.push_back(accessor);
    return static_cast<int>(accessors_.size()) - 1;
  }
  void AddPart(int part) {
    std::string places, uvs, corners;
    const int rings = kAlong / parts_;
    for (int j = 0; j <= rings; ++j)
      for (int i = 0; i <= kAround; ++i) {
        const double along = j + part * rings, turn = 2 * M_PI * (i % kAround) / kAround;
        const double radius = 1 + 0.1 * std::sin(0.05 * along) * std::cos(3 * turn);
        Append(&places, static_cast<float>(radius * std::cos(turn)));
        Append(&places, static_cast<float>(0.02 * along));
        Append(&places, static_cast<float>(radius * std::sin(turn)));
        Append(&uvs, static_cast<float>(0.01 + 0.98 * i / kAround));
        Append(&uvs, static_cast<float>(0.01 + 0.98 * j / rings));
      }
    for (int j = 0; j < rings; ++j)
      for (int i = 0; i < kAround; ++i) {
        const auto at = [&](int di, int dj) {
          return static_cast<std::uint32_t>((j + dj) * (kAround + 1) + i + di);
        };
        for (const std::uint32_t corner :
             {at(0, 0), at(0, 1), at(1, 0), at(1, 0), at(0, 1), at(1, 1)})
          Append(&corners, corner);
      }
    const std::size_t vertices = places.size() / 12;
    images_.push_back({{"bufferView", View(Texture(static_cast<unsigned>(part) + 1, folder_))},
                       {"mimeType", "image/jpeg"}});
    textures_.push_back({{"source", part}});
    materials_.push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", part}}}}}});
    primitives_.push_back({{"attributes",
                            {{"POSITION", Accessor(places, 5126, vertices, "VEC3")},
                             {"TEXCOORD_0", Accessor(uvs, 5126, vertices, "VEC2")}}},
                           {"indices", Accessor(corners, 5125, corners.size() / 4, "SCALAR")},
                           {"material", part}});
  }

  const int parts_;
  const TestingFolder& folder_;
  std::string bytes_;
  json primitives_ = json::array(), materials_ = json::array(), textures_ = json::array(),
       images_ = json::array(), accessors_ = json::array(), views_ = json::array();
};

void LoadGlb(benchmark::State& state) {
  const TestingFolder folder;
  const auto file = folder.Put("scan.glb", Glb(static_cast<int>(state.range(0)), folder).Text());
  double faces = 0;
  for (auto _ : state) {
    const Scan scan = ReadScan(file);
    faces = static_cast<double>(scan.mesh.faces.rows());
    benchmark::DoNotOptimize(scan.texture.data());
  }
  state.counters["faces"] = faces;
}

/// The same mesh without its texture in other formats.
void LoadMesh(benchmark::State& state, const char* name) {
  const TestingFolder folder;
  WriteMesh(folder.path() / name, ReadScan(folder.Put("scan.glb", Glb(1, folder).Text())).mesh);
  for (auto _ : state) benchmark::DoNotOptimize(ReadMesh(folder.path() / name).points.data());
}
BENCHMARK(LoadGlb)
    ->Arg(1)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond)
    ->MeasureProcessCPUTime()
    ->UseRealTime();
BENCHMARK_CAPTURE(LoadMesh, ply, "scan.ply")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(LoadMesh, obj, "scan.obj")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
