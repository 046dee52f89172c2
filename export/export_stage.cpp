// keypose-export: writes the animation in the formats of other programs.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/io/pictures/frame_folder.h"
#include "core/values/name_list.h"
#include "core/values/size_of.h"
#include "core/stage/stage.h"
#include "export/formats.h"
#include "export/read_scene.h"

namespace {

namespace fs = std::filesystem;
using keypose::exporting::FormatOptions;
using keypose::exporting::Scene;
using keypose::exporting::WrittenFormat;

constexpr double kUsualRate = 24, kLeastRate = 0.1, kMostRate = 1000;  // frames per second

std::string Joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

struct ExportOptions {
  std::string formats = "glb,video,obj,ply";
  double fps = 0;
  keypose::exporting::PlaybackOptions playback;
  std::string up = "z";    // axis that points up in the frames
  std::string unit = "m";  // of the frames
  std::string poses;
  FormatOptions format;

  void Describe(keypose::OptionVisitor& visit) {
    visit("formats", formats,
          {"formats to write, separated by commas: " + Joined(keypose::exporting::FormatNames()),
           ""});
    visit("fps", fps,
          {"frames per second; 0: those of the frames' folder, else 24", "1/s", 0, kMostRate, {}});
    visit("hold", playback.hold,
          {"extra frames for which the first and the last frame are held", "frames", 0, 10000, {}});
    visit("loop", playback.loop,
          {.help = "pingpong plays forwards and then back",
           .unit = "",
           .choices = {"none", "pingpong"}});
    visit("up", up,
          {.help = "axis that points up in the frames; each format gets its own",
           .unit = "",
           .choices = {"z", "y"}});
    visit("unit", unit,
          {.help = "unit of the frames; what is exported is in metres",
           .unit = "",
           .choices = {"m", "cm", "mm"}});
    visit("poses", poses,
          {"names of the keys' poses in order, separated by commas, one per texture in `textures`",
           ""});
    visit("pose_textures", format.pose_textures,
          {.help = "format of the GLB's textures after the first, for viewers that can blend "
                   "textures; none: leave them out",
           .unit = "",
           .choices = {"jpeg", "png", "none"}});
    visit("max_targets", format.few.max_targets, {"most morph targets of glb-few", "", 1, 255, {}});
    visit(
        "error_bound", format.few.error_bound,
        {"largest error of glb-few, relative to the figure's diagonal; as few targets as keep it, "
         "within max_targets",
         "",
         1e-9,
         1,
         {}});
    DescribeFilm(visit);
  }

  std::vector<std::string> Problems() const {
    std::vector<std::string> problems;
    const std::vector<std::string> known = keypose::exporting::FormatNames();
    const std::vector<std::string> wanted = keypose::NamesIn(formats);
    for (const std::string& name : wanted)
      if (std::find(known.begin(), known.end(), name) == known.end())
        problems.push_back("formats names '" + name + "', but the formats are " + Joined(known));
    if (wanted.empty()) problems.push_back("formats is empty; the formats are " + Joined(known));
    if (fps > 0 && fps < kLeastRate) problems.push_back("fps must be 0 or at least 0.1");
    if (format.film.width % 2 != 0 || format.film.height % 2 != 0)
      problems.push_back("video_width and video_height are " + std::to_string(format.film.width) +
                         " and " + std::to_string(format.film.height) +
                         ", but must be even: the film's colours have half its resolution");
    return problems;
  }

 private:
  void DescribeFilm(keypose::OptionVisitor& visit) {
    visit("video_width", format.film.width, {"of the film; even", "px", 64, 7680, {}});
    visit("video_height", format.film.height, {"of the film; even", "px", 64, 4320, {}});
    visit("video_azimuth", format.film.azimuth_deg,
          {"azimuth of the film's camera, counter-clockwise seen from above, 0: from -y; -1: the "
           "direction in the front half that shows most motion",
           "deg",
           -1,
           360,
           {}});
    visit("video_turntable", format.turntable,
          {"what character_turntable.mp4 shows: a frame's number or a key's name; empty: the first "
           "key",
           ""});
    visit("video_pictures", format.pictures,
          {"also write every picture of the film as PNG with alpha", ""});
  }
};

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
  std::int64_t pictures = 0;
  for (int i = 0; i < scene.frame_count(); ++i) pictures += scene.clip.picture[i] == i;
  stage.Report("frames", scene.frame_count());
  stage.Report("morph_targets", pictures - 1);
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
  }
}

/// A motion that was filmed or recorded has a rate of its own.
double RateOf(const fs::path& frames, const ExportOptions& options) {
  if (options.fps > 0) return options.fps;
  const double own = keypose::FrameRateOf(frames);
  return own >= kLeastRate && own <= kMostRate ? own : kUsualRate;
}

double MetresOf(const std::string& unit) { return unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1; }

/// Meshes that were made elsewhere are often in millimetres.
void WarnOfSize(keypose::StageContext& stage, const Scene& scene) {
  constexpr double kLargest = 20;  // no puppet and no actor is larger [m]
  const double diagonal = SceneDiagonal(scene);
  if (diagonal > kLargest)
    stage.Warn("the figure is " + std::to_string(std::lround(diagonal)) +
               " metres large for other programs, because a unit of the frames counts as a metre; "
               "if it is a millimetre, give the option unit: mm");
}

void Run(keypose::StageContext& stage, const ExportOptions& options) {
  keypose::exporting::PlaybackOptions playback = options.playback;
  playback.fps = RateOf(stage.Input("frames"), options);
  const Scene scene = keypose::exporting::ReadScene(
      stage, playback, options.up == "z", MetresOf(options.unit), keypose::NamesIn(options.poses));
  WarnOfSize(stage, scene);
  const fs::path out = stage.Output("animation");
  const bool per_frame = !scene.frame_texture_names.empty();
  const auto texture_names =
      WriteTextures(scene, per_frame ? stage.Inputs("textures")[0] : fs::path(), out / "textures");
  const nlohmann::json formats = WriteFormats(stage, scene, options, texture_names);
  const nlohmann::json summary = Summary(scene, texture_names, formats);
  keypose::WriteFile(out / "animation.json", summary.dump(1) + "\n");
  ReportScene(stage, scene, formats);
  stage.Report("animation_seconds", summary["seconds"].get<double>());
}

}  // namespace

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "export";
  spec.version = "10";
  spec.summary = "Writes the animation in the formats of other programs.";
  spec.inputs = {{"frames", "folder",
                  "frame_0000.ply, ... of one connectivity, and distortion.json", "", false, false},
                 {"textures", "path",
                  "of each key on the timeline, in order, in the frames' UV layout; or one for "
                  "all; or a folder with one for each frame",
                  "", true, true},
                 {"layout", "file", "mesh with texture coordinates, for frames that have none", "",
                  true, false}};
  spec.outputs = {{"animation", "folder", "the files of each format, textures/, animation.json",
                   "animation", false, false}};
  spec.cores = 0;
  spec.memory_gib = 2;
  return keypose::RunStage<ExportOptions>(argc, argv, spec, Run);
}
