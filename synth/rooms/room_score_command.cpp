#include "synth/rooms/room_score_command.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "synth/photographs/truth_files.h"
#include "synth/rooms/room_score.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

Json CamerasJson(const fs::path& truth, const Scene& of_figure, const Scene& model,
                 const RoomCameraScore& score) {
  const Scene of_room = ReadColmapModel(truth / "cameras_of_room");
  return {{"total", score.total},
          {"placed", score.placed},
          {"good", score.good()},
          {"wrong", score.wrong},
          {"missing", score.missing},
          {"median_deg", score.median_deg},
          {"median_over_distance", score.median_over_distance},
          {"agree_with_figure", AgreeingTurns(of_figure, model)},
          {"agree_with_room", AgreeingTurns(of_room, model)}};
}

/// A photograph without a mask has an overlap of 0.
Json MasksJson(const fs::path& truth, const fs::path& masks, const Scene& of_figure) {
  Json each = Json::object();
  std::vector<double> overlaps;
  std::string worst;
  for (const View& view : of_figure.views) {
    const std::string name = view.name + ".png";
    const double overlap =
        fs::exists(masks / name)
            ? MaskOverlap(ReadImage(truth / "masks" / name, 1), ReadImage(masks / name, 1))
            : 0;
    each[view.name] = overlap;
    if (overlaps.empty() || overlap < *std::min_element(overlaps.begin(), overlaps.end()))
      worst = view.name;
    overlaps.push_back(overlap);
  }
  std::sort(overlaps.begin(), overlaps.end());
  if (overlaps.empty()) throw InputError("synth: " + truth.string() + " holds no cameras");
  return {{"median", overlaps[overlaps.size() / 2]},
          {"worst", overlaps.front()},
          {"worst_of", worst},
          {"each", each}};
}

Json BaseJson(const Mesh& truth, const Mesh& mesh, const Similarity3& truth_from_model) {
  const BaseScore score = ScoreBase(truth, mesh, truth_from_model);
  return {{"below", score.below},       {"beside", score.beside},
          {"anywhere", score.anywhere}, {"mean_to_truth", score.mean_to_truth},
          {"missing", score.missing},   {"closed", CheckClosed(mesh).closed()}};
}

}  // namespace

std::string RunRoomScore(const RoomScoreCommand& command) {
  if (!command.mesh.empty() && command.model.empty())
    throw InputError("synth: --mesh needs --model, in whose frame it is");
  const Truth truth = ReadTruth(command.truth);
  Json json = Json::object();
  if (!command.model.empty()) {
    const Scene model = ReadColmapModel(command.model);
    const Eigen::Vector3d center = truth.surface.points.colwise().mean();
    const RoomCameraScore score = ScoreRoomCameras(truth.cameras, model, center);
    json["cameras"] = CamerasJson(command.truth, truth.cameras, model, score);
    if (!command.mesh.empty())
      json["base"] = BaseJson(truth.outer, ReadMesh(command.mesh), score.truth_from_model);
  }
  if (!command.masks.empty())
    json["masks"] = MasksJson(command.truth, command.masks, truth.cameras);
  return json.dump(1) + "\n";
}

}  // namespace keypose::synth
