#include "core/io/pictures/frame_folder.h"

#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {

namespace fs = std::filesystem;

std::vector<fs::path> NumberedFrames(const fs::path& folder, const std::string& stage) {
  if (!fs::is_directory(folder))
    throw InputError(stage + ": " + folder.string() +
                     " is not a folder of frames; pass the folder that `interpolate` wrote");
  std::map<long, fs::path> numbered;
  const std::regex pattern("frame_([0-9]{1,9})\\.ply");
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::smatch match;
    const std::string name = entry.path().filename().string();
    if (!std::regex_match(name, match, pattern)) continue;
    const auto [at, inserted] = numbered.emplace(std::stol(match[1]), entry.path());
    if (!inserted)
      throw InputError(stage + ": " + name + " and " + at->second.filename().string() + " in " +
                       folder.string() + " have the same number; remove one");
  }
  if (numbered.empty())
    throw InputError(stage + ": " + folder.string() +
                     " has no frames (frame_0000.ply, ...); run `interpolate` first");
  std::vector<fs::path> frames;
  for (const auto& [number, path] : numbered) {
    if (number != std::ssize(frames))
      throw InputError(stage + ": frame " + std::to_string(frames.size()) + " is missing in " +
                       folder.string() + " (found " + path.filename().string() +
                       " in its place); run `interpolate` again");
    frames.push_back(path);
  }
  return frames;
}

std::string FrameFileName(int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%04d.ply", frame);
  return name;
}

double FrameRateOf(const fs::path& folder) {
  const fs::path path = folder / "distortion.json";
  if (!fs::exists(path)) return 0;
  const auto notes = nlohmann::json::parse(ReadFile(path), nullptr, false);
  if (!notes.is_object() || !notes.contains("fps") || !notes["fps"].is_number()) return 0;
  const double fps = notes["fps"];
  return fps > 0 && fps < 1e6 ? fps : 0;
}

FrameTimes ReadFrameTimes(const fs::path& folder, int frame_count) {
  FrameTimes times;
  const fs::path path = folder / "distortion.json";
  if (!fs::exists(path)) return times;
  const std::string text = ReadFile(path);
  RequireShallowJson(text, path.string());
  const auto notes = nlohmann::json::parse(text, nullptr, false);
  if (!notes.is_object() || !notes.contains("frames") || !notes["frames"].is_array())
    throw InputError(path.string() +
                     " is not JSON with a list `frames`; make the frames again, or delete it");
  times.fps = FrameRateOf(folder);
  if (static_cast<int>(notes["frames"].size()) != frame_count) return times;
  if (notes.contains("key_frames") && notes["key_frames"].is_array())
    for (const auto& frame : notes["key_frames"])
      if (frame.is_number_integer() && frame >= 0 && frame < frame_count)
        times.key_frames.push_back(frame);
  for (const auto& frame : notes["frames"])
    if (frame.is_object() && frame.contains("t") && frame["t"].is_number())
      times.t.push_back(frame["t"].get<double>());
  if (SizeOf(times.t) != frame_count || times.key_frames.empty()) times.t.clear();
  return times;
}

std::string FrameNotesText(const std::vector<FrameMeasures>& frames, double fps,
                           const std::string& method) {
  const int count = SizeOf(frames);
  nlohmann::ordered_json notes = {{"schema", 2},
                                  {"method", method},
                                  {"fps", fps},
                                  {"loop", false},
                                  {"key_frames", nlohmann::ordered_json::array()},
                                  {"frames", nlohmann::ordered_json::array()}};
  for (int i = 0; i < count; ++i)
    notes["frames"].push_back({{"t", count > 1 ? i / (count - 1.0) : 0.0},
                               {"time", i / fps},
                               {"area", frames[i].area},
                               {"volume", frames[i].volume},
                               {"linear_area", frames[i].area},
                               {"linear_volume", frames[i].volume},
                               {"stands", false}});
  return notes.dump(1) + "\n";
}

}  // namespace keypose
