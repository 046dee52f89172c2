#include "report/player_gathering_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"
#include "report/player/player_data.h"

namespace keypose::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Keeps a page of two poses below 8 MB: the script has half a megabyte, the pictures of a pose one
// or two, and base64 adds a third.
constexpr std::size_t kPositionBytes = 2'200'000, kMeshBytes = 3'600'000;
constexpr int kTextureSide = 1024, kManyTextures = 4;

/// The pose of each key, as an index into the project's poses.
std::vector<int> PosesOfKeys(const RunRecord& run) {
  std::vector<int> poses;
  if (run.timeline.empty()) return poses;
  const json timeline = json::parse(run.timeline);
  for (const json& key : timeline.value("keys", json::array())) {
    const auto found = std::find(run.poses.begin(), run.poses.end(), key.value("pose", ""));
    if (found == run.poses.end()) return {};
    poses.push_back(static_cast<int>(found - run.poses.begin()));
  }
  return poses;
}

/// Textures that the project itself gives to the export, of meshes that were made elsewhere: one,
/// or one for each pose.
std::vector<Image8> GivenTextures(const RunRecord& run, const std::vector<std::string>& poses) {
  const StepRecord* frames = run.Find("interpolate");
  const StepRecord* step = frames ? run.ExportOf(frames->Output("frames")) : nullptr;
  if (!step || !step->inputs.contains("textures")) return {};
  const std::vector<fs::path>& paths = step->inputs.at("textures");
  if (paths.size() == 1 && fs::is_regular_file(paths[0])) return {ReadImage(paths[0], 3)};
  std::vector<int> pose_of_key = PosesOfKeys(run);
  for (int i = 0; run.timeline.empty() && i < SizeOf(run.poses); ++i) pose_of_key.push_back(i);
  if (paths.size() != pose_of_key.size()) return {};
  std::vector<Image8> textures;
  for (const std::string& pose : poses) {
    const auto number = std::find(run.poses.begin(), run.poses.end(), pose) - run.poses.begin();
    const auto key = std::find(pose_of_key.begin(), pose_of_key.end(), number);
    if (key == pose_of_key.end()) return {};
    textures.push_back(ReadImage(paths[key - pose_of_key.begin()], 3));
  }
  return textures;
}

double FpsOf(const std::vector<FrameDistortion>& frames) {
  const double seconds = frames.back().time_s - frames.front().time_s;
  return seconds > 0 ? static_cast<double>(frames.size() - 1) / seconds : 24;
}

/// The textures at the size for the page.
std::vector<Image8> Shrunken(std::vector<Image8> textures) {
  const int most = SizeOf(textures) > kManyTextures ? kTextureSide / 2 : kTextureSide;
  for (Image8& texture : textures) {
    const double factor = static_cast<double>(most) / std::max(texture.width, texture.height);
    if (factor < 1)
      texture = Resized(texture, static_cast<int>(texture.width * factor),
                        static_cast<int>(texture.height * factor));
  }
  return textures;
}

std::size_t MeshBytes(const Mesh& mesh) {
  // Seams add about a tenth of the vertices. From 65,536 drawn vertices on, indices have four
  // bytes.
  const auto drawn = static_cast<std::size_t>(std::max(mesh.uvs.rows(), mesh.points.rows()));
  const std::size_t index = drawn > 65535 ? 4 : 2;
  return 3 * index * static_cast<std::size_t>(mesh.face_count()) + (index + 4) * drawn;
}

std::optional<Picture> PosterOf(const Contents& contents) {
  for (const PosePart& pose : contents.poses)
    if (pose.name == contents.run.template_pose && !pose.sides.empty()) return pose.sides.front();
  return std::nullopt;
}

void Finish(PlayerData& data, PlayerPart& part, const Encoder& encode) {
  part.pictures = SizeOf(data.moments);
  part.keys = SizeOf(data.keys);
  part.stored = SizeOf(data.frames);
  part.textured = !data.textures.empty();
  part.json = PlayerJson(data, encode);
}

PlayerPart OfAnimation(const Contents& contents, const fs::path& folder, const Encoder& encode,
                       const SidesOptions& sides) {
  const std::vector<FrameDistortion>& frames = contents.animation->frames;
  const auto read = [&](int i) { return ReadMesh(folder / fmt::format("frame_{:04}.ply", i)); };
  PlayerData data;
  data.mesh = read(0);
  data.up = sides.up;
  data.fps = FpsOf(frames);
  data.textures = Shrunken(TexturesOf(contents.run, contents.run.poses, data.mesh));
  std::vector<int> repeats;
  std::vector<char> keys;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const int own = static_cast<int>(i), same = frames[i].same_as;
    repeats.push_back(same >= 0 && same < own ? repeats[same] : own);
    keys.push_back(frames[i].key);
  }
  PlayerPart part;
  part.poster = PosterOf(contents);
  for (std::size_t i = 0; i < repeats.size(); ++i)
    part.distinct += i > 0 && repeats[i] == static_cast<int>(i);
  const std::size_t frame_bytes = 6 * static_cast<std::size_t>(data.mesh.vertex_count());
  const std::vector<int> stored = FramesToStore(repeats, keys, kPositionBytes / frame_bytes);
  if (MeshBytes(data.mesh) + frame_bytes * stored.size() > kMeshBytes) return part;
  for (std::size_t k = 0; k < stored.size(); ++k) {
    data.frames.push_back(read(stored[k]).points);
    if (data.frames.back().rows() != data.mesh.points.rows())
      throw InputError("frames have different vertex counts");
    if (keys[stored[k]]) data.keys.push_back(static_cast<int>(k));
  }
  data.moments = MomentsOf(repeats, stored);
  std::vector<int> pose_of_key = PosesOfKeys(contents.run);
  if (data.textures.size() < 2) pose_of_key.clear();
  for (std::size_t i = 0; i < frames.size(); ++i)
    data.moments[i].weights = TextureWeights(frames[i].t, pose_of_key, data.textures.size());
  Finish(data, part, encode);
  return part;
}

PlayerPart OfPose(const Contents& contents, const StepRecord& bake, const Encoder& encode,
                  const SidesOptions& sides) {
  PlayerData data;
  data.mesh = ReadMesh(bake.Input("mesh"));
  RequireUsable(data.mesh, bake.Input("mesh").string());
  data.up = sides.up;
  data.textures = Shrunken(TexturesOf(contents.run, {bake.pose}, data.mesh));
  data.frames = {data.mesh.points};
  data.moments = {{0, 0, 0, TextureWeights(0, {0}, data.textures.size())}};
  data.keys = {0};
  PlayerPart part;
  part.poster = PosterOf(contents);
  if (MeshBytes(data.mesh) + 6 * static_cast<std::size_t>(data.mesh.vertex_count()) <= kMeshBytes)
    Finish(data, part, encode);
  return part;
}

}  // namespace

std::vector<Image8> TexturesOf(const RunRecord& run, const std::vector<std::string>& poses,
                               Mesh& mesh) {
  const StepRecord* first = run.Find("bake", run.template_pose);
  if (!first) return mesh.has_uvs() ? GivenTextures(run, poses) : std::vector<Image8>();
  if (first->Input("mesh").empty()) return {};
  const Mesh baked = ReadMesh(first->Input("mesh"));
  if (!SameFaces(baked.faces, mesh.faces)) return {};
  mesh.uvs = baked.uvs;
  mesh.uv_faces = baked.uv_faces;
  std::vector<Image8> textures;
  for (const std::string& pose : poses) {
    const fs::path texture = run.TextureOf(pose);
    if (texture.empty()) return {};
    textures.push_back(ReadImage(texture, 3));
  }
  return textures;
}

std::optional<PlayerPart> GatherPlayer(const Contents& contents, const Encoder& encode,
                                       const SidesOptions& sides) {
  const StepRecord *frames = contents.run.Find("interpolate"),
                   *bake = contents.run.Find("bake", contents.run.template_pose);
  if (contents.animation && frames)
    return OfAnimation(contents, frames->Output("frames"), encode, sides);
  if (bake && !bake->Output("texture").empty() && !bake->Input("mesh").empty())
    return OfPose(contents, *bake, encode, sides);
  return std::nullopt;
}

}  // namespace keypose::report
