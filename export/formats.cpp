#include "export/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

#include "core/io/text/files.h"
#include "core/values/size_of.h"
#include "export/blender/blender_files.h"
#include "export/caches/caches.h"
#include "export/fbx/fbx.h"
#include "export/film/exposure_sheet.h"
#include "export/glb_textures.h"
#include "export/gltf/gltf.h"
#include "export/sequences/sequences.h"
#include "export/usd/usda.h"
#include "export/vat/vat.h"
#include "views/film/frame_painter.h"
#include "views/film/gif.h"
#include "views/film/mp4.h"

namespace keypose::exporting {
namespace {

namespace fs = std::filesystem;

/// Most targets of the light GLB; with more the pictures themselves are not much larger.
constexpr int kMostLightTargets = 64;

/// Everything that a format's function is given.
struct Job {
  const Scene& scene;
  const std::vector<std::string>& texture_names;
  const FormatOptions& options;
  StageContext& stage;
  fs::path folder;
  Progress* progress;
};

/// Writes the files of a format that gives them as values.
WrittenFormat Save(const Job& job, const FormatFiles& made) {
  WrittenFormat written;
  for (const FormatFile& file : made.files) {
    const fs::path path = job.folder / file.path;
    fs::create_directories(path.parent_path());
    WriteFile(path, file.bytes);
    written.files.push_back(file.path);
  }
  written.error_over_diagonal = made.error_over_diagonal;
  written.measured = made.measured;
  return written;
}

/// How many frames differ from all before them.
int PictureCount(const Clip& clip) {
  int count = 0;
  for (int i = 0; i < clip.frame_count(); ++i) count += clip.picture[i] == i;
  return count;
}

/// The pictures themselves as targets.
FormatFiles FullGlb(const Scene& scene, const std::string& file, const GlbTextures& textures) {
  const GlbOptions options{scene.playback, scene.z_up, scene.name};
  FormatFiles made;
  made.files.push_back(
      {file, MakeGlb(scene.split, scene.clip, scene.frame_names, textures, options)});
  made.error_over_diagonal = GlbError(scene.split) / SceneDiagonal(scene);
  made.measured["morph_targets"] = PictureCount(scene.clip) - 1;
  return made;
}

/// What the other poses' textures are in a full GLB: as asked for, by default JPEG.
std::string OfPoses(const Job& job, const std::string& usual) {
  return job.options.pose_textures == "auto" ? usual : job.options.pose_textures;
}

/// Few targets, and textures of a size for phones. Where as many targets are needed as there are
/// pictures, these are the targets.
WrittenFormat WriteGlb(const Job& job) {
  const Scene& scene = job.scene;
  const LightGlbOptions& options = job.options.light;
  const LightTextures light =
      MakeLightTextures(scene, OfPoses(job, "none"), options.texture, job.stage.Scratch());
  FormatFiles made = MakeFewTargetsGlb(
      scene, light.textures, {kMostLightTargets, options.error, "character.glb"}, job.progress);
  if (made.measured["morph_targets"] >= PictureCount(scene.clip) - 1)
    made = FullGlb(scene, "character.glb", light.textures);
  if (made.error_over_diagonal > options.error)
    job.stage.Warn(fmt::format(
        "character.glb is off by up to {:.2g} of the figure's diagonal, although it has {} shapes: "
        "so rich a motion needs the format glb-full",
        made.error_over_diagonal, kMostLightTargets));
  if (light.width > 0) {
    made.measured["texture_width"] = light.width;
    made.measured["texture_height"] = light.height;
    if (std::isfinite(light.psnr_db)) made.measured["texture_psnr_db"] = light.psnr_db;
  }
  return Save(job, made);
}

WrittenFormat WriteFullGlb(const Job& job) {
  return Save(job, FullGlb(job.scene, "character_full.glb",
                           FullTextures(job.scene, OfPoses(job, "jpeg"), job.stage.Scratch())));
}

WrittenFormat WriteFewTargets(const Job& job) {
  return Save(job,
              MakeFewTargetsGlb(job.scene,
                                FullTextures(job.scene, OfPoses(job, "jpeg"), job.stage.Scratch()),
                                job.options.few, job.progress));
}

WrittenFormat SavedSequence(const WrittenSequence& sequence, const std::string& folder) {
  WrittenFormat written;
  written.files.push_back(folder + "/");
  written.error_over_diagonal = sequence.error_over_diagonal;
  written.measured["pictures"] = sequence.pictures;
  return written;
}

WrittenFormat WriteObj(const Job& job) {
  const std::string texture = job.texture_names.empty() || !job.scene.frame_texture_names.empty()
                                  ? ""
                                  : "../textures/" + job.texture_names[0];
  return SavedSequence(WriteObjSequence(job.scene, job.folder / "obj", texture, job.progress),
                       "obj");
}

WrittenFormat WritePly(const Job& job) {
  return SavedSequence(WritePlySequence(job.scene, job.folder / "ply", job.progress), "ply");
}

/// @return a function that writes what `make` gives
auto Saved(FormatFiles (*make)(const Scene&, Progress*)) {
  return [make](const Job& job) { return Save(job, make(job.scene, job.progress)); };
}

std::string PictureName(int number) {
  std::ostringstream name;
  name << "frame_" << std::setw(4) << std::setfill('0') << number << ".png";
  return name.str();
}

FilmOptions OptionsOfFilm(const Job& job) {
  FilmOptions options = job.options.film;
  options.z_up = job.scene.z_up;
  options.background = FilmColor(job.options.background).value_or(kFilmBackground);
  return options;
}

/// The film as MP4 and GIF, and its pictures if they are wanted. A single frame is no film.
void WriteFilm(const Job& job, WrittenFormat& written, Progress* progress) {
  const FilmOptions options = OptionsOfFilm(job);
  const double fps = job.scene.playback.fps;
  const std::vector<int> order = RoundOf(job.scene);
  std::optional<Mp4Writer> mp4;
  if (CanWriteMp4()) {
    mp4.emplace(job.folder / "character.mp4", options.width, options.height, fps,
                job.options.sound);
    written.files.push_back("character.mp4");
  }
  GifWriter gif(job.folder / "character.gif", fps);
  written.files.push_back("character.gif");
  if (job.options.pictures) {
    fs::create_directories(job.folder / "video" / "png");
    written.files.push_back("video/");
  }
  int number = 0;
  const auto take = [&](const Image8& picture) {
    const Image8 flat = LaidOver(picture, options.background);
    if (mp4) mp4->Add(flat);
    gif.Add(flat);
    if (job.options.pictures)
      WriteFile(job.folder / "video" / "png" / PictureName(number), EncodePng(picture));
    ++number;
  };
  RenderFilm(SceneOfFilm(job.scene, options), order, options, take, progress);
  if (mp4) mp4->Finish();
  gif.Finish();
  if (gif.Shortened())
    job.stage.Note("export: character.gif has the first 12 seconds; the whole film is in the MP4");
  written.measured["pictures"] = SizeOf(order);
}

void WriteTurntable(const Job& job, WrittenFormat& written, Progress* progress) {
  const FilmOptions options = OptionsOfFilm(job);
  const double fps = job.scene.playback.fps;
  const int frame = FindFrame(job.scene, job.options.turntable);
  Mp4Writer mp4(job.folder / "character_turntable.mp4", options.width, options.height, fps);
  RenderTurntable(
      SceneOfFilm(job.scene, options), frame, fps, options,
      [&](const Image8& picture) { mp4.Add(LaidOver(picture, options.background)); }, progress);
  mp4.Finish();
  written.files.push_back("character_turntable.mp4");
}

/// The pictures of the film and of the turntable.
std::pair<int, int> VideoPictures(const Scene& scene) {
  return {scene.frame_count() > 1 ? SizeOf(RoundOf(scene)) : 0,
          CanWriteMp4() ? TurntablePictures(scene.playback.fps) : 0};
}

WrittenFormat WriteVideo(const Job& job) {
  WrittenFormat written;
  FindFrame(job.scene, job.options.turntable);  // a wrong name is said before the film is rendered
  if (!CanWriteMp4())
    job.stage.Warn(
        "no MP4 was written: libavcodec has no x264 here; install Debian's libavcodec59, or leave "
        "`video` out of `formats`");
  const auto [film, turntable] = VideoPictures(job.scene);
  const double share = film / std::max(1.0, static_cast<double>(film + turntable));
  SubProgress film_progress(job.progress, 0, share), turn_progress(job.progress, share, 1);
  if (film > 0) WriteFilm(job, written, &film_progress);
  if (turntable > 0) WriteTurntable(job, written, &turn_progress);
  return written;
}

/// A single frame is no film.
WrittenFormat WriteSheet(const Job& job) {
  if (job.scene.frame_count() == 1) return {};
  return Save(job, MakeExposureSheet(job.scene, job.options.sound));
}

using Write = std::function<WrittenFormat(const Job&)>;
const std::vector<std::pair<std::string, Write>>& Formats() {
  static const std::vector<std::pair<std::string, Write>> formats = {
      {"glb", WriteGlb},
      {"glb-full", WriteFullGlb},
      {"glb-few", WriteFewTargets},
      {"video", WriteVideo},
      {"sheet", WriteSheet},
      {"obj", WriteObj},
      {"ply", WritePly},
      {"fbx", Saved(MakeFbx)},
      {"pc2", Saved(MakePc2)},
      {"mdd", Saved(MakeMdd)},
      {"vat", Saved(MakeVat)},
      {"usda", Saved(MakeUsda)},
      {"blender", Saved(MakeBlenderFiles)}};
  return formats;
}

}  // namespace

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  for (const auto& [name, write] : Formats()) names.push_back(name);
  return names;
}

double FormatCost(const std::string& format, const Scene& scene) {
  constexpr double kFrame = 0.2;  // a frame in a file, against a rendered picture
  const auto [film, turntable] = VideoPictures(scene);
  return format == "video" ? film + turntable : std::max(1.0, kFrame * scene.frame_count());
}

WrittenFormat WriteFormat(const std::string& format, const Scene& scene,
                          const std::vector<std::string>& texture_names,
                          const FormatOptions& options, StageContext& stage, Progress* progress) {
  const auto& formats = Formats();
  const auto found = std::find_if(formats.begin(), formats.end(),
                                  [&](const auto& one) { return one.first == format; });
  if (found == formats.end()) throw UsageError("export: there is no format " + format);
  WrittenFormat written =
      found->second({scene, texture_names, options, stage, stage.Output("animation"), progress});
  written.format = format;
  return written;
}

}  // namespace keypose::exporting
