#include "studio/meshes/frames.h"

#include <fmt/format.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "studio/meshes/frame_colours.h"
#include "studio/meshes/frame_order.h"
#include "studio/meshes/mesh_bytes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

fs::path FramesFolder(Snapshot& snapshot, const std::string& shot) {
  if (const auto folder = snapshot.FramesPath(shot)) return *folder;
  throw UsageError(
      fmt::format("there are no frames yet; run the steps up to {} first",
                  shot.empty() ? "interpolate" : fmt::format("track of shot '{}'", shot)));
}

std::vector<fs::path> FrameFiles(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("frame_") && name.ends_with(".ply")) files.push_back(entry.path());
  }
  SortByNumber(&files);
  return files;
}

json Column(const json& frames, const char* name) {
  json column = json::array();
  for (const json& frame : frames) column.push_back(frame.contains(name) ? frame[name] : json(1.0));
  return column;
}

/// When each frame is: key number plus share of the way to the next. Empty if a frame does not say.
json TimesOf(const json& frames, std::size_t count) {
  json times = json::array();
  for (const json& frame : frames) {
    if (!frame.contains("t") || !frame["t"].is_number()) return json::array();
    times.push_back(frame["t"]);
  }
  return times.size() == count ? times : json::array();
}

/// The pose of each frame that is a key; else "".
json KeysOf(const json& distortion, const std::vector<std::string>& poses, std::size_t count) {
  json keys = std::vector<std::string>(count);
  const json frames =
      distortion.is_object() ? distortion.value("key_frames", json::array()) : json::array();
  for (std::size_t i = 0; i < frames.size() && i < poses.size(); ++i)
    if (const std::size_t frame = frames[i]; frame < count) keys[frame] = poses[i];
  return keys;
}

}  // namespace

json FramesJson(Snapshot& snapshot, const std::string& shot) {
  const fs::path folder = FramesFolder(snapshot, shot);
  const std::vector<fs::path> files = FrameFiles(folder);
  if (files.empty()) throw UsageError("there are no frames yet");
  const json distortion = json::parse(ReadFile(folder / "distortion.json"), nullptr, false);
  const json frames =
      distortion.is_object() ? distortion.value("frames", json::array()) : json::array();
  const Mesh first = ReadMesh(files.front());
  return {
      {"count", files.size()},
      {"fps",
       distortion.is_object() ? distortion.value("fps", snapshot.file().fps) : snapshot.file().fps},
      {"vertices", first.vertex_count()},
      {"colours", shot.empty() ? json() : FrameColoursJson(snapshot, shot, first, files.size())},
      {"area", Column(frames, "area")},
      {"volume", Column(frames, "volume")},
      {"linear_area", Column(frames, "linear_area")},
      {"linear_volume", Column(frames, "linear_volume")},
      {"times", TimesOf(frames, files.size())},
      {"poses", snapshot.graph().keys},
      {"keys", KeysOf(distortion, snapshot.graph().keys, files.size())}};
}

std::string FramePositions(Snapshot& snapshot, const std::string& shot) {
  constexpr std::size_t kMostBytes = 1u << 30;
  const std::vector<fs::path> files = FrameFiles(FramesFolder(snapshot, shot));
  if (files.empty()) throw UsageError("there are no frames yet");
  const int vertices = ReadMesh(files.front()).vertex_count();
  const std::size_t frame_bytes = 12 * static_cast<std::size_t>(vertices);
  if (frame_bytes * files.size() > kMostBytes)
    throw UsageError(
        fmt::format("{} frames of {} vertices are too many to play here; open the film in "
                    "out/animation",
                    files.size(), vertices));
  std::string bytes(frame_bytes * files.size(), '\0');
  ParallelFor(static_cast<std::int64_t>(files.size()), [&](std::int64_t i) {
    const Mesh mesh = ReadMesh(files[static_cast<std::size_t>(i)]);
    if (mesh.vertex_count() != vertices)
      throw InputError(files[static_cast<std::size_t>(i)].string() + " has other vertices");
    const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> points =
        mesh.points.cast<float>();
    std::memcpy(bytes.data() + frame_bytes * static_cast<std::size_t>(i), points.data(),
                frame_bytes);
  });
  return bytes;
}

std::string FirstFrame(Snapshot& snapshot, const std::string& shot) {
  const std::vector<fs::path> files = FrameFiles(FramesFolder(snapshot, shot));
  if (files.empty()) throw UsageError("there are no frames yet");
  Mesh first = ReadMesh(files.front());
  return MeshBytes(shot.empty() ? first : FrameWithLayout(snapshot, shot, std::move(first)));
}

}  // namespace keypose::studio
