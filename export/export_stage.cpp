// keypose-export: writes the animation in the formats of other programs.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/pictures/frame_folder.h"
#include "core/io/text/files.h"
#include "core/stage/stage.h"
#include "core/values/name_list.h"
#include "core/values/size_of.h"
#include "export/export_options.h"
#include "export/formats.h"
#include "export/how_to_open.h"
#include "export/read_scene.h"
#include "views/decode/read_sound.h"

namespace {

namespace fs = std::filesystem;
using keypose::exporting::ExportOptions;
using keypose::exporting::Scene;
using keypose::exporting::WrittenFormat;

constexpr double kUsualRate = 24;  // frames per second

/// Textures of several poses may have the same file name, so they are numbered.
/// @param given  the folder of the frames' textures, where each has its own
/// @return names in the folder
std::vector<std::string> WriteTextures(const Scene& scene, const fs::path& given,
                                       const fs::path& folder) {
  std::vector<std::string> names;
  if (!scene.textures.empty()) fs::create_directories(folder);
  if (!scene.frame_texture_names.empty()) {
    for (const std::string& name : scene.frame_texture_names)
      keypose::WriteFile(folder / name, keypose::ReadFile(given / name));
    return scene.frame_texture_names;
  }
  for (std::size_t i = 0; i < scene.textures.size(); ++i) {
    names.push_back(scene.textures[i].FileName(static_cast<int>(i)));
    keypose::WriteFile(folder / names[i], scene.textures[i].bytes);
  }
  return names;
}

std::int64_t BytesOf(const fs::path& folder, const std::vector<std::string>& files) {
  std::int64_t bytes = 0;
  for (const std::string& file : files) {
    const fs::path path = folder / file;
    if (!fs::is_directory(path)) {
      bytes += static_cast<std::int64_t>(fs::file_size(path));
      continue;
    }
    for (const auto& entry : fs::recursive_directory_iterator(path))
      if (entry.is_regular_file()) bytes += static_cast<std::int64_t>(entry.file_size());
  }
  return bytes;
}

nlohmann::json FormatNote(const WrittenFormat& written, const fs::path& folder) {
  nlohmann::json note = {{"format", written.format},
                         {"files", written.files},
                         {"bytes", BytesOf(folder, written.files)}};
  if (written.error_over_diagonal >= 0) note["error_over_diagonal"] = written.error_over_diagonal;
  for (const auto& [name, value] : written.measured) note[name] = value;
  return note;
}

nlohmann::json FrameNotes(const Scene& scene) {
  nlohmann::json frames = nlohmann::json::array();
  for (int i = 0; i < scene.frame_count(); ++i) {
    frames.push_back(
        {{"name", scene.frame_names[i]}, {"picture", scene.frame_names[scene.clip.picture[i]]}});
    if (!scene.frame_t.empty()) frames.back()["t"] = scene.frame_t[i];
  }
  return frames;
}

// The times at which each frame, texture and pose is shown, and what was written.
nlohmann::json Summary(const Scene& scene, const std::vector<std::string>& texture_names,
                       const nlohmann::json& formats) {
  nlohmann::json out = {{"schema", 2},
                        {"fps", scene.playback.fps},
                        {"loop", scene.playback.loop},
                        {"vertices", scene.frames[0].vertex_count()},
                        {"faces", scene.frames[0].face_count()},
                        {"polygons", scene.net.face_count()},
                        {"textures", texture_names},
                        {"texture_per_frame", !scene.frame_texture_names.empty()},
                        {"poses", scene.poses},
                        {"formats", formats},
                        {"keys", nlohmann::json::array()},
                        {"texture_moments", nlohmann::json::array()},
                        {"frames", FrameNotes(scene)}};
  const auto moments = PlaybackMoments(scene.clip, scene.playback);
  out["seconds"] = moments.back().seconds;
  for (const auto& moment : moments)
    out["moments"].push_back(
        {{"seconds", moment.seconds}, {"frame", moment.frame}, {"stands", moment.stands}});
  for (const auto& moment : scene.texture_moments)
    out["texture_moments"].push_back({{"seconds", moment.seconds}, {"weights", moment.weights}});
  const std::vector<double> key_seconds = KeySeconds(scene);
  for (std::size_t i = 0; i < scene.keys.size(); ++i)
    out["keys"].push_back({{"seconds", key_seconds[i]},
                           {"frame", scene.keys[i].frame},
                           {"pose", scene.keys[i].pose}});
  return out;
}

/// Writes the wanted formats, each once. @return a note on each, for animation.json
nlohmann::json WriteFormats(keypose::StageContext& stage, const Scene& scene,
                            const ExportOptions& options,
                            const std::vector<std::string>& texture_names) {
  const std::vector<std::string> wanted = keypose::NamesIn(options.formats);
  std::vector<std::string> formats;
  for (const std::string& name : keypose::exporting::FormatNames())
    if (std::find(wanted.begin(), wanted.end(), name) != wanted.end()) formats.push_back(name);
  double cost = 0, before = 0;
  for (const std::string& format : formats) cost += keypose::exporting::FormatCost(format, scene);
  keypose::SubProgress writing(stage.progress(), keypose::exporting::kReadingShare, 1);
  nlohmann::json notes = nlohmann::json::array();
  for (std::size_t i = 0; i < formats.size(); ++i) {
    const double begin = before / cost;
    before += keypose::exporting::FormatCost(formats[i], scene);
    keypose::SubProgress progress(&writing, begin, before / cost);
    keypose::ReportProgress(&progress, 0, "writing " + formats[i]);
    const WrittenFormat written = keypose::exporting::WriteFormat(formats[i], scene, texture_names,
                                                                  options.format, stage, &progress);
    notes.push_back(FormatNote(written, stage.Output("animation")));
  }
  return notes;
}

void ReportScene(keypose::StageContext& stage, const Scene& scene, const nlohmann::json& formats) {
  stage.Report("frames", scene.frame_count());
  std::int64_t pictures = 0;
  for (int i = 0; i < scene.frame_count(); ++i) pictures += scene.clip.picture[i] == i;
  stage.Report("pictures", pictures);
  stage.Report("vertices", scene.frames[0].vertex_count());
  stage.Report("split_vertices", std::ssize(scene.split.source_vertex));
  stage.Report("faces", scene.frames[0].face_count());
  stage.Report("textures", scene.frame_texture_names.empty()
                               ? std::ssize(scene.textures)
                               : std::ssize(scene.frame_texture_names));
  for (const auto& format : formats) {
    std::string name = format["format"];
    std::replace(name.begin(), name.end(), '-', '_');
    stage.Report(name + "_bytes", format["bytes"].get<std::int64_t>());
    if (format.contains("error_over_diagonal"))
      stage.Report(name + "_error_over_diagonal", format["error_over_diagonal"].get<double>());
    if (format.contains("morph_targets"))
      stage.Report(name + "_targets", format["morph_targets"].get<int>());
  }
}

/// A motion that was filmed or recorded has a rate of its own.
double RateOf(const fs::path& frames, const ExportOptions& options) {
  if (options.fps > 0) return options.fps;
  const double own = keypose::FrameRateOf(frames);
  const bool usable = own >= keypose::exporting::kLeastRate && own <= keypose::exporting::kMostRate;
  return usable ? own : kUsualRate;
}

double MetresOf(const std::string& unit) {
  if (unit == "mm") return 1e-3;
  return unit == "cm" ? 1e-2 : 1;
}

/// Meshes that were made elsewhere are often in millimetres.
void WarnOfSize(keypose::StageContext& stage, const Scene& scene) {
  constexpr double kLargest = 20;  // no puppet and no actor is larger [m]
  const double diagonal = SceneDiagonal(scene);
  if (diagonal > kLargest)
    stage.Warn("the figure is " + std::to_string(std::lround(diagonal)) +
               " metres large for other programs, because a unit of the frames counts as a metre; "
               "if it is a millimetre, give the option unit: mm");
}

/// The options with the sound where there is one, at its time.
ExportOptions WithSound(keypose::StageContext& stage, const ExportOptions& options,
                        const Scene& scene) {
  ExportOptions heard = options;
  if (!stage.Has("sound")) return heard;
  if (scene.frame_count() == 1) {
    stage.Warn("the sound is not heard: the animation is one picture, which is no film");
    return heard;
  }
  const double seconds = PlaybackMoments(scene.clip, scene.playback).back().seconds;
  keypose::HeardSound sound =
      keypose::ReadSoundAt(stage.Input("sound"), options.sound_at, seconds, stage.progress());
  if (!sound.warning.empty()) stage.Warn(sound.warning);
  heard.format.sound = std::move(sound.sound);
  return heard;
}

void Run(keypose::StageContext& stage, const ExportOptions& options) {
  keypose::exporting::PlaybackOptions playback = options.playback;
  playback.fps = RateOf(stage.Input("frames"), options);
  const keypose::exporting::FramePlacement placement{options.up == "z", MetresOf(options.unit),
                                                     options.front};
  const Scene scene =
      keypose::exporting::ReadScene(stage, playback, placement, keypose::NamesIn(options.poses));
  WarnOfSize(stage, scene);
  const ExportOptions heard = WithSound(stage, options, scene);
  const fs::path out = stage.Output("animation");
  const bool per_frame = !scene.frame_texture_names.empty();
  const auto texture_names =
      WriteTextures(scene, per_frame ? stage.Inputs("textures")[0] : fs::path(), out / "textures");
  const nlohmann::json formats = WriteFormats(stage, scene, heard, texture_names);
  const nlohmann::json summary = Summary(scene, texture_names, formats);
  keypose::WriteFile(out / "animation.json", summary.dump(1) + "\n");
  std::vector<std::string> written;
  for (const auto& format : formats) written.push_back(format["format"]);
  keypose::WriteFile(out / "how_to_open.txt",
                     keypose::exporting::HowToOpen(written, scene.playback.fps));
  ReportScene(stage, scene, formats);
  stage.Report("animation_seconds", summary["seconds"].get<double>());
}

}  // namespace

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "export";
  spec.version = "15";
  spec.summary = "Writes the animation in the formats of other programs.";
  spec.title = "Export";
  spec.inputs = {
      {"frames", "path",
       "frame_0000.ply, ... of one connectivity, and distortion.json; or one mesh", "", false,
       false},
      {"textures", "path",
       "of each key on the timeline, in order, in the frames' UV layout; or one for "
       "all; or a folder with one for each frame",
       "", true, true},
      {"layout", "file", "mesh with texture coordinates, for frames that have none", "", true,
       false},
      {"polygons", "file",
       "OBJ that the frames' triangles were made from: its quads and polygons are the "
       "faces of OBJ, USD and FBX",
       "", true, false},
      {"sound", "file", "of the film: WAV, FLAC, MP3, Opus or another that ffmpeg decodes", "",
       true, false}};
  spec.outputs = {{"animation", "folder",
                   "the files of each format, textures/, animation.json, how_to_open.txt",
                   "animation", false, false}};
  spec.cores = 0;
  spec.memory_gib = 2;
  return keypose::RunStage<ExportOptions>(argc, argv, spec, Run);
}
