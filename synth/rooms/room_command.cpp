#include "synth/rooms/room_command.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/project/colmap_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/angles.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/fresh_folder.h"
#include "synth/photographs/photographer.h"
#include "synth/photographs/truth_files.h"
#include "synth/rooms/room_photographer.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct RoomFolders {
  fs::path photos, truth;
};

RoomFolders MakeRoomFolders(const fs::path& output) {
  const RoomFolders folders{output / "photos/figure", output / "truth/figure"};
  MakeFreshFolder(folders.photos, folders.truth / "masks");
  MakeFreshFolder(folders.truth / "masks", folders.truth / "masks");
  MakeFreshFolder(folders.truth / "parts", folders.truth / "masks");
  for (const char* file : {"smooth.ply", "outer.ply"}) fs::remove(folders.truth / file);
  return folders;
}

ExifToWrite ExifOfLens(const RoomPlan& plan, int lens) {
  ExifToWrite exif;
  exif.focal_35mm = std::round(plan.focal_35mm[lens]);  // telephones say no more
  exif.focal_mm = plan.focal_35mm[lens] / 6.5;          // a telephone
  exif.make = "Keypose";
  exif.model = "Synthetic telephone";
  return exif;
}

/// What the truth says of one photograph.
struct Seen {
  int pixels = 0;             // of the figure
  bool cut = false;           // by the photograph's border
  std::array<int, 2> inside;  // a pixel well within the figure; -1 where there is none
  /// x, y of both ends of a level line within another thing; -1 where none is seen
  std::array<int, 4> beside{-1, -1, -1, -1};
};

/// Distance to the nearest pixel outside the mask, by rows and columns (city blocks).
std::vector<int> DepthInside(const Image8& mask) {
  const int w = mask.width, h = mask.height;
  std::vector<int> depth(mask.data.size(), 0);
  const auto at = [&](int x, int y) {
    return x < 0 || y < 0 || x >= w || y >= h ? 0 : depth[static_cast<std::size_t>(y) * w + x];
  };
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      if (*mask.at(x, y)) depth[y * w + x] = std::min(at(x - 1, y), at(x, y - 1)) + 1;
  for (int y = h - 1; y >= 0; --y)
    for (int x = w - 1; x >= 0; --x)
      if (*mask.at(x, y))
        depth[y * w + x] = std::min(depth[y * w + x], std::min(at(x + 1, y), at(x, y + 1)) + 1);
  return depth;
}

Seen SeenOf(const Image8& mask) {
  Seen seen{0, false, {-1, -1}};
  const std::vector<int> depth = DepthInside(mask);
  int deepest = 0;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (!*mask.at(x, y)) continue;
      ++seen.pixels;
      seen.cut |= x == 0 || y == 0 || x == mask.width - 1 || y == mask.height - 1;
      const int here = depth[static_cast<std::size_t>(y) * mask.width + x];
      if (here > deepest) {
        deepest = here;
        seen.inside = {x, y};
      }
    }
  return seen;
}

/// A level line through the widest place of another thing, within it.
/// @param second  of the thing that stands nearest to the figure: on a table are others; may be
/// empty
std::array<int, 4> LineOnThing(const Image8& parts, const PointsX3& second, const View& view) {
  constexpr auto thing = static_cast<std::uint8_t>(Part::kThing);
  Eigen::AlignedBox2d box;
  for (Eigen::Index i = 0; i < second.rows(); ++i) box.extend(view.Project(second.row(i)));
  Image8 mask(parts.width, parts.height, 1, 0);
  for (int y = 0; y < parts.height; ++y)
    for (int x = 0; x < parts.width; ++x)
      if (*parts.at(x, y) == thing && (second.rows() == 0 || box.contains(Eigen::Vector2d(x, y))))
        *mask.at(x, y) = 255;
  const auto [x, y] = SeenOf(mask).inside;
  if (x < 0) return {-1, -1, -1, -1};
  int left = x, right = x;
  while (left > 0 && *mask.at(left - 1, y)) --left;
  while (right + 1 < mask.width && *mask.at(right + 1, y)) ++right;
  const int margin = (right - left) / 6;
  return {left + margin, y, right - margin, y};
}

Json PhotographJson(const RoomPhotographer& photographer, int i, const Seen& seen) {
  const RoomView& room_view = photographer.room_views()[i];
  const Camera& camera = room_view.view.camera;
  Json json{{"name", room_view.view.name},
            {"part", room_view.part},
            {"turn_deg", room_view.turn_rad / kDegree},
            {"lens", room_view.lens},
            {"portrait", camera.height > camera.width},
            {"gain", room_view.gain},
            {"hand", photographer.HasHand(i)},
            {"figure_pixels", seen.pixels},
            {"cut", seen.cut},
            {"inside", seen.inside},
            {"beside", seen.beside}};
  json["tripod"] = room_view.tripod >= 0 ? Json(room_view.tripod) : Json(nullptr);
  return json;
}

std::string RoomJson(const RoomPhotographer& photographer, const std::vector<Seen>& seen) {
  const RoomPlan& plan = photographer.plan();
  const RoomSet& set = photographer.set();
  Json json{{"schema", 1},
            {"kind", NameOf(plan.kind)},
            {"seed", plan.seed},
            {"free_standing", plan.free_standing()},
            {"stands_on", plan.support},
            {"base_z_m", 0.0},
            {"table_z_m", set.table_z},
            {"diagonal_m", BoundingDiagonal(set.figure().surface.points)},
            {"second", plan.second},
            {"exif", plan.exif},
            {"character", plan.character},
            {"pose", plan.pose},
            {"texture", plan.texture}};
  for (int lens = 0; lens < plan.lenses; ++lens)
    json["lenses"].push_back({{"focal_35mm", plan.focal_35mm[lens]}});
  for (int i = 0; i < SizeOf(seen); ++i)
    json["photographs"].push_back(PhotographJson(photographer, i, seen[i]));
  return json.dump(1) + "\n";
}

/// The options that WriteTruth records.
PhotographerOptions Recorded(const RoomPlan& plan) {
  PhotographerOptions options;
  options.views = plan.photographs;
  options.elevations_deg.clear();
  options.width = plan.width;
  options.height = plan.height;
  options.focal_35mm = plan.focal_35mm[0];
  options.background = "room";
  options.noise = plan.noise;
  options.seed = plan.seed;
  return options;
}

void WriteRoomTruth(const RoomPhotographer& photographer, const std::vector<Seen>& seen,
                    const fs::path& folder) {
  const RoomPlan& plan = photographer.plan();
  const World& world = photographer.set().world;
  const Pose& pose = world.PoseNamed(plan.pose);
  std::vector<SyntheticView> views;
  Scene of_room;
  for (const RoomView& room_view : photographer.room_views()) {
    views.push_back({room_view.OfFigure(), {}, {}});
    of_room.views.push_back(room_view.view);
  }
  Truth truth{TruthScene(world, pose, views),
              photographer.set().figure().surface,
              SeenSurface(world, pose),
              photographer.set().figure().surface.points,
              world.landmarks,
              {}};
  if (!plan.free_standing()) truth.cameras.points.clear();  // they are of another surface
  WorldOptions world_options;
  world_options.character = plan.character;
  world_options.seed = plan.figure_seed;
  world_options.spacing_m = plan.spacing_m;
  world_options.texture = plan.texture;
  WriteTruth(folder, truth, world, pose, world_options, Recorded(plan));
  fs::create_directories(folder / "cameras_of_room");
  WriteColmapModel(folder / "cameras_of_room", of_room);
  WriteFile(folder / "room.json", RoomJson(photographer, seen));
}

}  // namespace

std::string RunRoom(const RoomCommand& command, Progress* progress) {
  const RoomPlan plan = PlanRoom(command.room);
  const RoomFolders folders = MakeRoomFolders(command.output);
  ReportProgress(progress, 0, "a room of the kind " + NameOf(plan.kind));
  const RoomPhotographer photographer(plan);
  const int count = SizeOf(photographer.room_views());
  ReportProgress(progress, 0.2, std::to_string(count) + " photographs");
  std::vector<Seen> seen(static_cast<std::size_t>(count));
  // One photograph per thread, since JPEG encoding uses only one core.
  ParallelFor(count, [&](std::int64_t i) {
    if (progress && progress->cancelled()) throw Cancelled();
    const RoomPhotograph photograph = photographer.Take(static_cast<int>(i));
    const RoomView& room_view = photographer.room_views()[i];
    const ExifToWrite exif = ExifOfLens(plan, room_view.lens);
    WriteImage(folders.photos / room_view.view.name, photograph.image, command.jpeg_quality,
               plan.exif ? &exif : nullptr);
    WriteImage(folders.truth / "masks" / (room_view.view.name + ".png"), photograph.mask);
    WriteImage(folders.truth / "parts" / (room_view.view.name + ".png"), photograph.parts);
    seen[i] = SeenOf(photograph.mask);
    seen[i].beside = LineOnThing(photograph.parts, photographer.set().second, room_view.OfFigure());
  });
  WriteRoomTruth(photographer, seen, folders.truth);
  ReportProgress(progress, 1, "done");
  return std::to_string(count) + " photographs of a room of the kind " + NameOf(plan.kind) +
         " in " + folders.photos.string();
}

}  // namespace keypose::synth
