#include "export/formats.h"

#include <algorithm>
#include <functional>
#include <iomanip>
#include <optional>
#include <sstream>
#include <utility>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/size_of.h"
#include "export/blender/blender_files.h"
#include "export/caches/caches.h"
#include "export/fbx/fbx.h"
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

/// Everything that a format's function is given.
struct Job {
  const Scene& scene;
  const std::vector<std::string>& texture_names;
  const FormatOptions& options;
  StageContext& stage;
  fs::path folder;
  Progress* progress;
};

/// The image converted to JPEG.
EncodedImage AsJpeg(const EncodedImage& image, const fs::path& scratch) {
  if (image.mime_type == "image/jpeg") return image;
  const fs::path from = scratch / "pose.png", to = scratch / "pose.jpg";
  WriteFile(from, image.bytes);
  WriteImage(to, ReadImage(from));
  return {ReadFile(to), "image/jpeg", image.name};
}

GlbTextures TexturesOfGlb(const Job& job) {
  const std::string& kind = job.options.pose_textures;
  const Scene& scene = job.scene;
  const bool blends = !scene.texture_moments.empty() && kind != "none";
  GlbTextures glb;
  for (std::size_t i = 0; i < scene.textures.size() && (i == 0 || blends); ++i) {
    glb.images.push_back(i > 0 && kind == "jpeg" ? AsJpeg(scene.textures[i], job.stage.Scratch())
                                                 : scene.textures[i]);
    glb.poses.push_back(scene.poses[i]);
  }
  if (blends) glb.moments = scene.texture_moments;
  return glb;
}

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

WrittenFormat WriteGlb(const Job& job) {
  const Scene& scene = job.scene;
  const GlbOptions options{scene.playback, scene.z_up, scene.name};
  FormatFiles made;
  made.files.push_back({"character.glb", MakeGlb(scene.split, scene.clip, scene.frame_names,
                                                 TexturesOfGlb(job), options)});
  made.error_over_diagonal = GlbError(scene.split) / SceneDiagonal(scene);
  return Save(job, made);
}

WrittenFormat WriteFewTargets(const Job& job) {
  return Save(job, MakeFewTargetsGlb(job.scene, TexturesOfGlb(job), job.options.few, job.progress));
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
  return options;
}

/// The film as MP4 and GIF, and its pictures if they are wanted. A single frame is no film.
void WriteFilm(const Job& job, WrittenFormat& written, Progress* progress) {
  const FilmOptions options = OptionsOfFilm(job);
  const double fps = job.scene.playback.fps;
  const std::vector<int> order = RoundOf(job.scene);
  std::optional<Mp4Writer> mp4;
  if (CanWriteMp4()) {
    mp4.emplace(job.folder / "character.mp4", options.width, options.height, fps);
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
    if (mp4) mp4->Add(picture);
    gif.Add(picture);
    if (job.options.pictures)
      WriteFile(job.folder / "video" / "png" / PictureName(number), EncodePng(picture));
    ++number;
  };
  RenderFilm(SceneOfFilm(job.scene), order, options, take, progress);
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
      SceneOfFilm(job.scene), frame, fps, options, [&](const Image8& picture) { mp4.Add(picture); },
      progress);
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

using Write = std::function<WrittenFormat(const Job&)>;
const std::vector<std::pair<std::string, Write>>& Formats() {
  static const std::vector<std::pair<std::string, Write>> formats = {
      {"glb", WriteGlb},
      {"glb-few", WriteFewTargets},
      {"video", WriteVideo},
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
