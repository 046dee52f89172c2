// The generated shot on which the program keypose-composite is tested.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "composite/composing/join.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "synth/commands/shot_command.h"
#include "tests/run_program.h"

namespace keypose::tests {

namespace fs = std::filesystem;
using nlohmann::json;

inline constexpr int kPictures = 5;

/// A texture in which each face has a cell of its own, with the mean colour of its corners.
struct PaintedFaces {
  UvsX2 uvs;
  FacesX3 uv_faces;
  Image8 texture;

  explicit PaintedFaces(const Mesh& colored) {
    constexpr int kCell = 4;
    const int faces = colored.face_count(),
              side = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(faces))));
    texture = Image8(side * kCell, side * kCell, 3);
    uvs.resize(3 * faces, 2), uv_faces.resize(faces, 3);
    const double corners[3][2] = {{0.3, 0.3}, {0.7, 0.3}, {0.3, 0.7}};
    for (int f = 0; f < faces; ++f) {
      const int column = f % side, row = f / side;
      for (int k = 0; k < 3; ++k) {
        uv_faces(f, k) = 3 * f + k;
        uvs.row(3 * f + k) << (column + corners[k][0]) / side, 1 - (row + corners[k][1]) / side;
      }
      for (int y = 0; y < kCell; ++y)
        for (int x = 0; x < kCell; ++x)
          for (int c = 0; c < 3; ++c) {
            int sum = 0;
            for (int k = 0; k < 3; ++k) sum += colored.colors(colored.faces(f, k), c);
            texture.at(column * kCell + x, row * kCell + y)[c] = static_cast<std::uint8_t>(sum / 3);
          }
    }
  }
};

/// A generated shot, and its true animation as frames and texture: made once for all tests of a
/// program, also those of suites that are derived from this one and film nothing else.
class GeneratedShot : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!still_) {
      Film({});
      still_ = std::move(own_);
    }
    folder_ = still_->path();
  }
  /// @param command  what differs from the test's shot
  static void Film(synth::ShotCommand command) {
    own_ = std::make_unique<TestingFolder>();
    folder_ = own_->path();
    command.output = folder_;
    command.shows = {{0, "rest"}, {2, "wave"}};
    command.world.spacing_m = 0.004;
    command.set.width = 384, command.set.height = 216;
    command.photographs = false, command.meshes = true, command.clean_plate = true;
    command.travel_m = 0.12;
    synth::RunShot(command, nullptr);
    WriteFrames(command);
    WriteShot();
  }
  static void TearDownTestSuite() { own_.reset(); }

  static void WriteFrames(const synth::ShotCommand& command) {
    const synth::World world = synth::MakeWorld(command.world);
    const Mesh colored = synth::TruthSurface(world, world.PoseNamed("rest"), true);
    const PaintedFaces painted(colored);
    fs::create_directories(folder_ / "frames");
    json notes = {{"schema", 2}, {"fps", 24}, {"key_frames", {0, 4}}, {"frames", json::array()}};
    for (int n = 0; n < kPictures; ++n) {
      Mesh frame = ReadMesh(folder_ / fmt::format("truth/shot/meshes/frame_{:04}.ply", n));
      frame.uvs = painted.uvs, frame.uv_faces = painted.uv_faces;
      WriteMesh(folder_ / "frames" / fmt::format("frame_{:04}.ply", n), frame);
      notes["frames"].push_back({{"t", n / 4.0}});
    }
    WriteFile(folder_ / "frames" / "distortion.json", notes.dump());
    WritePng(folder_ / "texture.png", painted.texture);
  }

  /// The true meshes are in the set's world.
  static void WriteShot() {
    FilmedShot shot = ReadShot(folder_ / "truth/shot/shot.json");
    for (ShotFrame& frame : shot.frames) frame.world_from_character = {};
    shot.frames.erase(shot.frames.begin() + 1);  // only the keys were located
    WriteFile(folder_ / "shot.json", ShotText(shot));
  }

  static std::vector<std::string> Words(const std::string& output,
                                        const std::map<std::string, std::string>& other) {
    std::map<std::string, std::string> flags = {{"frames", "frames"},  {"textures", "texture.png"},
                                                {"shot", "shot.json"}, {"plate", "film"},
                                                {"filmed", "film"},    {"pictures", output},
                                                {"samples", "3"},      {"video", "false"},
                                                {"blender", "false"},  {"compare", "false"}};
    for (const auto& [name, value] : other) flags[name] = value;
    std::vector<std::string> arguments{"keypose-composite"};
    for (const auto& [name, value] : flags) {
      if (value.empty()) continue;
      arguments.push_back("--" + name);
      const bool path = fs::exists(folder_ / value) || name == "pictures" || name == "report";
      arguments.push_back(path ? (folder_ / value).string() : value);
    }
    return arguments;
  }
  static RunResult Composite(const std::string& output,
                             const std::map<std::string, std::string>& other = {},
                             const std::vector<std::string>& environment = {}) {
    return RunProgram(Words(output, other), folder_, environment);
  }

  static double PsnrOf(const std::string& pictures, int n) {
    const Image8 mine = ReadImage(folder_ / pictures / fmt::format("{:04}.png", n), 3),
                 truth = ReadImage(folder_ / fmt::format("truth/shot/frames/{:04}.png", n), 3),
                 matte = ReadImage(folder_ / fmt::format("truth/shot/between/{:04}.png", n), 1);
    int box[4] = {matte.width, matte.height, 0, 0};
    for (int y = 0; y < matte.height; ++y)
      for (int x = 0; x < matte.width; ++x)
        if (*matte.at(x, y) > 127) {
          box[0] = std::min(box[0], x), box[2] = std::max(box[2], x + 1);
          box[1] = std::min(box[1], y), box[3] = std::max(box[3], y + 1);
        }
    return composite::PsnrWithin(mine, truth, box);
  }

  static inline std::unique_ptr<TestingFolder> still_;  ///< of the camera that stands still
  static inline std::unique_ptr<TestingFolder> own_;    ///< of another shot, of one suite
  static inline fs::path folder_;
};

}  // namespace keypose::tests
