#include "synth/commands/pair_command.h"

#include <nlohmann/json.hpp>
#include <set>
#include <string>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/numbers/kd_tree.h"
#include "core/values/errors.h"

namespace keypose::synth {
namespace {

using Json = nlohmann::ordered_json;

std::string WorldJson(const ClayPairOptions& o, const ClayPair& pair) {
  Json places = Json::array();
  for (const Place& place : pair.places)
    places.push_back({{"name", place.name},
                      {"position", {place.position[0], place.position[1], place.position[2]}}});
  const Json json{{"schema", 1},
                  {"shape", o.shape.shape},
                  {"seed", o.shape.seed},
                  {"bend_deg", o.shape.bend_deg},
                  {"twist_deg", o.shape.twist_deg},
                  {"squash", o.shape.squash},
                  {"landmarks", pair.picks.size()},
                  {"noise", o.noise},
                  {"landmark_noise", o.landmark_noise < 0 ? 4 * o.noise : o.landmark_noise},
                  {"holes", o.holes},
                  {"hole_area", o.holes > 0 ? o.hole_area : 0},
                  {"ratio", o.ratio},
                  {"turn_deg", o.turn_deg},
                  {"scale", o.scale},
                  {"source_vertices", pair.source.vertex_count()},
                  {"source_faces", pair.source.face_count()},
                  {"target_vertices", pair.target.vertex_count()},
                  {"target_faces", pair.target.face_count()},
                  {"target_diagonal", pair.diagonal},
                  {"places", places}};
  return json.dump(1) + "\n";
}

int CornerOf(const Mesh& mesh, const Landmark& landmark) {
  int corner = 0;
  landmark.barycentric.maxCoeff(&corner);
  return mesh.faces(landmark.face, corner);
}

// A target vertex appears only once: if two picks share their nearest corner, the later one is left
// out.
std::string VertexPairs(const ClayPair& pair) {
  std::set<int> used;
  std::string text;
  for (const LandmarkPair& pick : pair.picks) {
    const int target = CornerOf(pair.target, pick.target);
    if (used.insert(target).second)
      text +=
          std::to_string(CornerOf(pair.source, pick.source)) + " " + std::to_string(target) + "\n";
  }
  return text;
}

void WritePicks(const std::filesystem::path& folder, const ClayPair& pair) {
  std::vector<Landmark> source, target;
  for (const LandmarkPair& pick : pair.picks) {
    source.push_back(pick.source);
    target.push_back(pick.target);
  }
  WriteLandmarks(folder / "source_landmarks.json", pair.source, source);
  WriteLandmarks(folder / "target_landmarks.json", pair.target, target);
  WriteFile(folder / "landmarks.txt", VertexPairs(pair));
}

}  // namespace

std::string RunPair(const PairCommand& command) {
  const ClayPair pair = MakeClayPair(command.pair);
  std::error_code error;
  std::filesystem::create_directories(command.output, error);
  if (error)
    throw DiskError("synth: cannot create the folder " + command.output.string() + ": " +
                    error.message());
  // Picks of an earlier run must not remain beside a pair without picks.
  for (const char* name : {"source_landmarks.json", "target_landmarks.json", "landmarks.txt"})
    std::filesystem::remove(command.output / name, error);
  Mesh truth = pair.source;
  truth.points = pair.truth;
  WriteMesh(command.output / "source.ply", pair.source);
  WriteMesh(command.output / "target.ply", pair.target);
  WriteMesh(command.output / "truth.ply", truth);
  if (!pair.picks.empty()) WritePicks(command.output, pair);
  WriteFile(command.output / "world.json", WorldJson(command.pair, pair));
  return std::to_string(pair.source.vertex_count()) + " vertices onto " +
         std::to_string(pair.target.vertex_count()) + ", " + std::to_string(pair.picks.size()) +
         " landmarks, in " + command.output.string();
}

}  // namespace keypose::synth
