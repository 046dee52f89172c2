#include "synth/photographs/truth_files.h"

#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "synth/photographs/board_picture.h"
#include "synth/worlds/outer_surface.h"

namespace keypose::synth {
namespace {

using Json = nlohmann::ordered_json;

std::string LandmarksJson(const Truth& truth) {
  Json list = Json::array();
  for (const TruthLandmark& landmark : truth.landmarks) {
    const Eigen::Vector3d p = truth.surface.points.row(landmark.vertex);
    list.push_back(
        {{"name", landmark.name}, {"vertex", landmark.vertex}, {"position", {p[0], p[1], p[2]}}});
  }
  return Json{{"schema", 1}, {"vertices", truth.surface.vertex_count()}, {"landmarks", list}}.dump(
             1) +
         "\n";
}

std::string PhotographName(int i) {
  char name[32];
  std::snprintf(name, sizeof name, "IMG_%04d.jpg", i + 1);
  return name;
}

Json Names(const std::vector<int>& views) {
  Json names = Json::array();
  for (const int i : views) names.push_back(PhotographName(i));
  return names;
}

Json NamesAfter(double share, int views) {
  Json names = Json::array();
  for (int i = FirstAfter(share, views); i < views; ++i) names.push_back(PhotographName(i));
  return names;
}

Json MishapsJson(const PhotographerOptions& options, std::uint64_t world_seed) {
  const Mishaps& m = options.mishaps;
  constexpr double kDegPerRad = 180 / 3.141592653589793;
  Json json = Json::object();
  if (m.strays > 0)
    json["stray"] = {{"photographs", Names(StrayViews(m, options.views))},
                     {"seed", StraySeed(m, world_seed)}};
  if (m.hands > 0) json["hand"] = {{"photographs", Names(HandViews(m, options.views))}};
  if (m.lamp_falls_after < 1)
    json["lamp_fall"] = {{"photographs", NamesAfter(m.lamp_falls_after, options.views)}};
  if (m.moved_from >= 1) return json;
  json["moved"] = {{"photographs", NamesAfter(m.moved_from, options.views)}};
  if (m.moved_pose.empty())
    json["moved"].update({{"mm", 1000 * m.moved_m}, {"deg", kDegPerRad * m.moved_rad}});
  else
    json["moved"]["pose"] = m.moved_pose;
  return json;
}

Json LimbAngles(const World& world, const Pose& pose) {
  Json angles = Json::object();
  for (const PosableLimb& limb : world.limbs) angles[limb.name] = LimbAngleDeg(pose, limb);
  return angles;
}

std::string WorldJson(const World& world, const Pose& pose, const Mesh& outer,
                      const std::vector<std::string>& rig_photographs,
                      const WorldOptions& world_options, const PhotographerOptions& options) {
  Json json{{"schema", 1},
            {"pose", pose.name},
            {"character", world_options.character},
            {"genus", Genus(outer)},
            {"seed", world_options.seed},
            {"spacing_m", world_options.spacing_m},
            {"texture", world_options.texture},
            {"prints_move", world_options.prints_move},
            {"print_height_m", world_options.print_height_m},
            {"print_spacing_m", world_options.print_spacing_m},
            {"lumps", world.clay.lumps.size()},
            {"photographs",
             {{"views", options.views},
              {"elevations_deg", options.elevations_deg},
              {"width", options.width},
              {"height", options.height},
              {"focal_35mm", options.focal_35mm},
              {"background", options.background},
              {"noise", options.noise},
              {"blur_px", options.blur_px},
              {"table_shadow", options.table_shadow},
              {"vignetting", options.vignetting},
              {"seed", options.seed}}}};
  if (world_options.pose_seed > 0) json["pose_seed"] = world_options.pose_seed;
  if (pose.name == "limbs") json["limbs_deg"] = LimbAngles(world, pose);
  if (!rig_photographs.empty()) json["rig_photographs"] = rig_photographs;
  if (options.mishaps.any()) json["mishaps"] = MishapsJson(options, world_options.seed);
  if (options.board.charuco) {
    const BoardPicture board = MakeBoardPicture(options.board);
    Json corners = Json::array();
    for (Eigen::Index i = 0; i < board.corners.rows(); ++i)
      corners.push_back({board.corners(i, 0), board.corners(i, 1), board.corners(i, 2)});
    json["board"] = {{"dictionary", DictionaryName(options.board.print.dictionary)},
                     {"squares_x", options.board.squares_x},
                     {"squares_y", options.board.squares_y},
                     {"square_m", options.board.square_m},
                     {"marker_m", options.board.marker_m},
                     {"corners_m", corners}};
    if (options.board.print.first_white) json["board"]["first_white"] = true;
    if (options.board.print.inverted) json["board"]["inverted"] = true;
  }
  return json.dump(1) + "\n";
}

}  // namespace

Truth ReadTruth(const std::filesystem::path& folder) {
  Truth truth{
      ReadColmapModel(folder / "cameras"), ReadMesh(folder / "surface.ply"), {}, {}, {}, {}};
  truth.outer = std::filesystem::exists(folder / "outer.ply") ? ReadMesh(folder / "outer.ply")
                                                              : truth.surface;
  truth.smooth = std::filesystem::exists(folder / "smooth.ply")
                     ? ReadMesh(folder / "smooth.ply").points
                     : truth.surface.points;
  if (truth.smooth.rows() != truth.surface.points.rows())
    throw InputError("synth: " + (folder / "smooth.ply").string() +
                     " does not belong to surface.ply; render the world again");
  const std::filesystem::path path = folder / "landmarks.json";
  try {
    const Json json = Json::parse(ReadFile(path));
    for (const Json& entry : json.at("landmarks"))
      truth.landmarks.push_back(
          {entry.at("name").get<std::string>(), entry.at("vertex").get<int>()});
  } catch (const nlohmann::json::exception& fault) {
    throw InputError("synth: " + path.string() + " is not a list of true landmarks (" +
                     fault.what() + "); render the world again");
  }
  for (const TruthLandmark& landmark : truth.landmarks)
    if (landmark.vertex < 0 || landmark.vertex >= truth.surface.vertex_count())
      throw InputError("synth: " + path.string() + ": landmark '" + landmark.name +
                       "' is on vertex " + std::to_string(landmark.vertex) +
                       ", but surface.ply has " + std::to_string(truth.surface.vertex_count()) +
                       "; render the world again");
  return truth;
}

void WriteTruth(const std::filesystem::path& folder, const Truth& truth, const World& world,
                const Pose& pose, const WorldOptions& world_options,
                const PhotographerOptions& options) {
  std::error_code error;
  std::filesystem::create_directories(folder / "cameras", error);
  if (error)
    throw DiskError("synth: cannot create the folder " + (folder / "cameras").string() + ": " +
                    error.message());
  WriteColmapModel(folder / "cameras", truth.cameras);
  WriteMesh(folder / "surface.ply", truth.surface);
  if (pose.touches) WriteMesh(folder / "outer.ply", truth.outer);
  if (truth.smooth != truth.surface.points) {
    Mesh smooth = truth.surface;
    smooth.points = truth.smooth;
    WriteMesh(folder / "smooth.ply", smooth);
  }
  WriteFile(folder / "landmarks.json", LandmarksJson(truth));
  WriteFile(folder / "world.json",
            WorldJson(world, pose, truth.outer, truth.rig_photographs, world_options, options));
}

}  // namespace keypose::synth
