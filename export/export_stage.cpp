// keypose-export: writes frames as a GLB, a film, and sequences of OBJ and PLY files.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/mesh_io.h"
#include "core/size_of.h"
#include "core/stage/stage.h"
#include "export/film/film.h"
#include "export/gltf/gltf.h"
#include "export/film/mp4.h"

namespace {

namespace fs = std::filesystem;
using keypose::InputError;
using keypose::Mesh;
using keypose::SizeOf;
using keypose::exporting::Clip;
using keypose::exporting::EncodedImage;
using keypose::exporting::FilmOptions;
using keypose::exporting::FilmScene;
using keypose::exporting::GlbTextures;
using keypose::exporting::TextureMoment;

struct ExportOptions {
  keypose::exporting::PlaybackOptions playback;
  std::string up = "z";  // axis that points up in the frames
  std::string poses;
  std::string pose_textures = "jpeg";
  bool video = true;
  int video_width = 960, video_height = 720;
  double video_azimuth = -1;
  bool obj = true;
  bool ply = true;

  void Describe(keypose::OptionVisitor& visit) {
    visit("fps", playback.fps, {"frames per second", "1/s", 0.1, 1000, {}});
    visit("hold", playback.hold,
          {"extra frames for which the first and the last frame are held", "frames", 0, 10000, {}});
    visit("loop", playback.loop,
          {"pingpong plays forwards and then back", "", -INFINITY, INFINITY, {"none", "pingpong"}});
    visit("up", up,
          {"axis that points up in the frames; in the GLB it is y",
           "",
           -INFINITY,
           INFINITY,
           {"z", "y"}});
    visit("poses", poses,
          {"names of the keys' poses in order, separated by commas, one per texture in `textures`",
           ""});
    visit("pose_textures", pose_textures,
          {.help = "format of the GLB's textures after the first, for viewers that can blend "
                   "textures; none: leave them out",
           .unit = "",
           .choices = {"jpeg", "png", "none"}});
    visit("video", video, {"also write a film of the animation, character.mp4", ""});
    visit("video_width", video_width, {"of the film; even", "px", 64, 7680, {}});
    visit("video_height", video_height, {"of the film; even", "px", 64, 4320, {}});
    visit("video_azimuth", video_azimuth,
          {"azimuth of the film's camera, counter-clockwise seen from above, 0: from -y; -1: the "
           "direction in the front half that shows most motion",
           "deg",
           -1,
           360,
           {}});
    visit("obj", obj, {"also write numbered OBJ files", ""});
    visit("ply", ply, {"also write numbered PLY files", ""});
  }
  std::vector<std::string> Problems() const {
    if (video_width % 2 == 0 && video_height % 2 == 0) return {};
    return {"video_width and video_height are " + std::to_string(video_width) + " and " +
            std::to_string(video_height) +
            ", but must be even: the film's colours have half its resolution"};
  }
};

struct Frames {
  std::vector<std::string> names;  // "frame_0000"
  std::vector<Mesh> meshes;
};

Frames ReadFrames(const fs::path& folder, keypose::Progress* progress) {
  if (!fs::is_directory(folder))
    throw InputError("export: " + folder.string() +
                     " is not a folder of frames; pass the folder that `interpolate` wrote");
  std::map<long, fs::path> numbered;
  const std::regex pattern("frame_([0-9]{1,9})\\.ply");
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::smatch match;
    const std::string name = entry.path().filename().string();
    if (!std::regex_match(name, match, pattern)) continue;
    const auto [at, inserted] = numbered.emplace(std::stol(match[1]), entry.path());
    if (!inserted)
      throw InputError("export: " + name + " and " + at->second.filename().string() + " in " +
                       folder.string() + " have the same number; remove one");
  }
  if (numbered.empty())
    throw InputError("export: " + folder.string() +
                     " has no frames (frame_0000.ply, ...); run `interpolate` first");
  Frames frames;
  for (const auto& [number, path] : numbered) {
    const auto index = static_cast<long>(frames.names.size());
    if (number != index)
      throw InputError("export: frame " + std::to_string(index) + " is missing in " +
                       folder.string() + " (found " + path.filename().string() +
                       " in its place); run `interpolate` again");
    keypose::ReportProgress(progress,
                            0.3 * static_cast<double>(index) / static_cast<double>(numbered.size()),
                            "reading frames");
    frames.names.push_back(path.stem().string());
    frames.meshes.push_back(keypose::ReadMesh(path));
  }
  return frames;
}

// PNG and JPEG files are embedded unchanged; other formats become PNG, since glTF allows only these
// two.
EncodedImage ReadTexture(const fs::path& path, const fs::path& scratch) {
  EncodedImage out;
  out.name = path.stem().string();
  const std::string format = keypose::ReadImageInfo(path).format;
  const keypose::Image8 pixels = keypose::ReadImage(path);  // checks that the file is complete
  if (format == "png" || format == "jpeg") {
    out.mime_type = "image/" + format;
    out.bytes = keypose::ReadFile(path);
    return out;
  }
  const fs::path converted = scratch / (out.name + ".png");
  keypose::WriteImage(converted, pixels);
  out.mime_type = "image/png";
  out.bytes = keypose::ReadFile(converted);
  return out;
}

/// The keys' textures, without duplicates.
struct PoseTextures {
  std::vector<EncodedImage> images;
  std::vector<std::string> poses;       // the pose of each image
  std::vector<keypose::Image8> pixels;  // pixels of each image
  std::vector<int> of_key;              // index of the image, per given texture
};

std::vector<std::string> SplitNames(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) names.push_back(name);
  return names;
}

PoseTextures ReadTextures(keypose::StageContext& stage, const std::string& pose_list) {
  PoseTextures textures;
  const std::vector<fs::path> paths = stage.Inputs("textures");
  const std::vector<std::string> names = SplitNames(pose_list);
  if (!names.empty() && paths.size() > 1 && names.size() != paths.size())
    throw keypose::UsageError("export: `poses` names " + std::to_string(names.size()) +
                              " keys, but there are " + std::to_string(paths.size()) +
                              " textures; give one name for each");
  for (std::size_t i = 0; i < paths.size(); ++i) {
    EncodedImage image = ReadTexture(paths[i], stage.Scratch());
    const auto same =
        std::find_if(textures.images.begin(), textures.images.end(),
                     [&](const EncodedImage& other) { return other.bytes == image.bytes; });
    textures.of_key.push_back(static_cast<int>(same - textures.images.begin()));
    if (same != textures.images.end()) continue;
    textures.poses.push_back(i < names.size() ? names[i] : "key-" + std::to_string(i));
    textures.images.push_back(std::move(image));
    textures.pixels.push_back(keypose::ReadImage(paths[i], 3));
  }
  return textures;
}

/// The image converted to JPEG.
EncodedImage AsJpeg(const EncodedImage& image, const fs::path& scratch) {
  if (image.mime_type == "image/jpeg") return image;
  const fs::path from = scratch / "pose.png", to = scratch / "pose.jpg";
  keypose::WriteFile(from, image.bytes);
  keypose::WriteImage(to, keypose::ReadImage(from));
  return {keypose::ReadFile(to), "image/jpeg", image.name};
}

// Textures of several poses may have the same file name, so a number is added. @return names in the
// folder
std::vector<std::string> WriteTextures(const std::vector<EncodedImage>& textures,
                                       const fs::path& folder) {
  std::vector<std::string> names;
  if (!textures.empty()) fs::create_directories(folder);
  for (std::size_t i = 0; i < textures.size(); ++i) {
    names.push_back("texture_" + std::to_string(i) +
                    (textures[i].mime_type == "image/png" ? ".png" : ".jpg"));
    keypose::WriteFile(folder / names[i], textures[i].bytes);
  }
  return names;
}

/// What `interpolate` wrote about its frames; lists are empty if it wrote nothing.
struct FrameNotes {
  nlohmann::json frames = nlohmann::json::array();
  std::vector<char> stands;  // one per frame; empty from older versions of `interpolate`
  std::vector<double> t;     // one per frame
  bool loop = false;
  std::size_t keys = 0;
};

FrameNotes ReadDistortion(const fs::path& folder, std::size_t frame_count) {
  FrameNotes told;
  const fs::path path = folder / "distortion.json";
  if (!fs::exists(path)) return told;
  const auto json = nlohmann::json::parse(keypose::ReadFile(path), nullptr, false);
  if (json.is_discarded() || !json.contains("frames") || !json["frames"].is_array())
    throw InputError("export: " + path.string() +
                     " is not JSON with a list `frames`; run `interpolate` again");
  told.frames = json["frames"];
  if (told.frames.size() != frame_count) return told;
  told.loop = json.contains("loop") && json["loop"] == true;
  if (json.contains("key_frames")) told.keys = json["key_frames"].size();
  bool says_what_stands = false;
  for (const auto& frame : told.frames) {
    if (frame.is_object() && frame.contains("t") && frame["t"].is_number())
      told.t.push_back(frame["t"].get<double>());
    says_what_stands |= frame.is_object() && frame.contains("stands");
    told.stands.push_back(frame.is_object() && frame.value("stands", false));
  }
  if (told.t.size() != frame_count) told.t.clear();
  if (!says_what_stands) told.stands.clear();
  return told;
}

void WriteSequence(const Frames& frames, const fs::path& folder, const std::string& extension,
                   const std::string& texture, keypose::Progress* progress) {
  fs::create_directories(folder);
  for (std::size_t i = 0; i < frames.meshes.size(); ++i) {
    keypose::ReportProgress(progress,
                            static_cast<double>(i) / static_cast<double>(frames.meshes.size()),
                            "writing " + extension + " files");
    Mesh mesh = frames.meshes[i];
    mesh.uvs = frames.meshes[0].uvs;
    mesh.uv_faces = frames.meshes[0].uv_faces;
    keypose::WriteMesh(folder / (frames.names[i] + "." + extension), mesh,
                       mesh.has_uvs() ? texture : "");
  }
}

/// The times and weights of the textures; empty if there is only one, or if they are not the
/// textures of the keys.
std::vector<TextureMoment> Blend(keypose::StageContext& stage, const PoseTextures& textures,
                                 const FrameNotes& told, const Clip& clip,
                                 const keypose::exporting::PlaybackOptions& playback) {
  if (textures.images.size() < 2) return {};
  if (told.t.empty() || told.keys != textures.of_key.size()) {
    stage.Warn("the animation shows only the first texture: there are " +
               std::to_string(textures.of_key.size()) + " textures, and " +
               (told.t.empty()
                    ? "the frames have no distortion.json with a `t` for each"
                    : "the frames were made from " + std::to_string(told.keys) + " keys") +
               "; pass one texture for each key, in the keys' order");
    return {};
  }
  const auto keyframes = LinearKeyframes(PlaybackMoments(clip, playback), clip, playback.fps);
  return TextureMoments(keyframes, told.t, textures.of_key, SizeOf(textures.images));
}

GlbTextures TexturesOfGlb(const PoseTextures& textures, std::vector<TextureMoment> moments,
                          const std::string& kind, const fs::path& scratch) {
  GlbTextures glb;
  const bool blends = !moments.empty() && kind != "none";
  for (std::size_t i = 0; i < textures.images.size() && (i == 0 || blends); ++i) {
    glb.images.push_back(i > 0 && kind == "jpeg" ? AsJpeg(textures.images[i], scratch)
                                                 : textures.images[i]);
    glb.poses.push_back(textures.poses[i]);
  }
  if (blends) glb.moments = std::move(moments);
  return glb;
}

/// Writes the animation as a film from one direction.
void WriteFilm(keypose::StageContext& stage, const Frames& frames, const PoseTextures& textures,
               const FrameNotes& told, const Clip& clip, bool blends, const ExportOptions& options,
               keypose::Progress* progress) {
  if (!options.video || frames.meshes.size() < 2) return;
  if (!keypose::exporting::CanWriteMp4()) {
    stage.Warn(
        "no film was written: libavcodec has no x264 here; install Debian's libavcodec59, or set "
        "`video: false`");
    return;
  }
  FilmScene scene{frames.meshes, textures.pixels, {}};
  const int count = SizeOf(textures.images);
  for (std::size_t i = 0; blends && i < told.t.size(); ++i)
    scene.blend.push_back(keypose::exporting::TextureWeights(told.t[i], textures.of_key, count));
  const auto moments = PlaybackMoments(clip, options.playback);
  std::vector<int> order = keypose::exporting::FilmFrames(moments, options.playback.fps);
  // When the film is looped, its last picture is the first picture of the next round.
  if ((clip.loop || options.playback.loop == "pingpong") && order.size() > 1) order.pop_back();
  const FilmOptions film{options.video_width, options.video_height, options.video_azimuth,
                         options.up == "z"};
  keypose::exporting::Mp4Writer writer(stage.Output("animation") / "character.mp4", film.width,
                                       film.height, options.playback.fps);
  RenderFilm(
      scene, order, film, [&](const keypose::Image8& picture) { writer.Add(picture); }, progress);
  writer.Finish();
  stage.Report("film_frames", std::ssize(order));
}

// The times at which each frame and each texture is shown, and the measurements of `interpolate`.
nlohmann::json Summary(const Frames& frames, const ExportOptions& options, const FrameNotes& told,
                       const Clip& clip, const std::vector<std::string>& texture_names,
                       const PoseTextures& textures, const std::vector<TextureMoment>& blend) {
  nlohmann::json out = {{"schema", 1},
                        {"glb", "character.glb"},
                        {"fps", options.playback.fps},
                        {"loop", options.playback.loop}};
  out["vertices"] = frames.meshes[0].vertex_count();
  out["faces"] = frames.meshes[0].face_count();
  out["textures"] = texture_names;
  out["poses"] = textures.poses;
  const auto moments = PlaybackMoments(clip, options.playback);
  out["seconds"] = moments.back().seconds;
  for (const auto& moment : moments) {
    out["moments"].push_back(
        {{"seconds", moment.seconds}, {"frame", moment.frame}, {"stands", moment.stands}});
  }
  out["texture_moments"] = nlohmann::json::array();
  for (const auto& moment : blend)
    out["texture_moments"].push_back({{"seconds", moment.seconds}, {"weights", moment.weights}});
  for (std::size_t i = 0; i < frames.names.size(); ++i) {
    nlohmann::json frame = {{"name", frames.names[i]}, {"picture", frames.names[clip.picture[i]]}};
    if (i < told.t.size()) frame["t"] = told.t[i];
    out["frames"].push_back(frame);
  }
  return out;
}

void Run(keypose::StageContext& stage, const ExportOptions& options) {
  const fs::path folder = stage.Input("frames");
  const Frames frames = ReadFrames(folder, stage.progress());
  const FrameNotes told = ReadDistortion(folder, frames.names.size());
  const PoseTextures textures = ReadTextures(stage, options.poses);
  const auto mesh = keypose::exporting::MakeAnimatedMesh(frames.meshes, frames.names);
  const Clip clip = keypose::exporting::MakeClip(mesh.points, told.stands, told.loop);
  const std::vector<TextureMoment> blend = Blend(stage, textures, told, clip, options.playback);

  keypose::ReportProgress(stage.progress(), 0.4, "writing the GLB");
  const keypose::exporting::GlbOptions glb{options.playback, options.up == "z", "character"};
  const std::string bytes =
      MakeGlb(mesh, clip, frames.names,
              TexturesOfGlb(textures, blend, options.pose_textures, stage.Scratch()), glb);
  const fs::path out = stage.Output("animation");
  keypose::WriteFile(out / "character.glb", bytes);
  const auto texture_names = WriteTextures(textures.images, out / "textures");
  const std::string map = texture_names.empty() ? "" : "../textures/" + texture_names[0];
  keypose::SubProgress film_progress(stage.progress(), 0.5, 0.8),
      obj_progress(stage.progress(), 0.8, 0.9), ply_progress(stage.progress(), 0.9, 1);
  WriteFilm(stage, frames, textures, told, clip, !blend.empty(), options, &film_progress);
  if (options.obj) WriteSequence(frames, out / "obj", "obj", map, &obj_progress);
  if (options.ply) WriteSequence(frames, out / "ply", "ply", "", &ply_progress);
  const auto summary = Summary(frames, options, told, clip, texture_names, textures, blend);
  keypose::WriteFile(out / "animation.json", summary.dump(1) + "\n");

  std::int64_t pictures = 0;
  for (int i = 0; i < clip.frame_count(); ++i) pictures += clip.picture[i] == i;
  stage.Report("frames", std::ssize(frames.names));
  stage.Report("morph_targets", pictures - 1);
  stage.Report("vertices", frames.meshes[0].vertex_count());
  stage.Report("split_vertices", std::ssize(mesh.source_vertex));
  stage.Report("faces", frames.meshes[0].face_count());
  stage.Report("textures", std::ssize(textures.images));
  stage.Report("animation_seconds", summary["seconds"].get<double>());
  stage.Report("glb_bytes", std::ssize(bytes));
}

}  // namespace

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "export";
  spec.version = "3";
  spec.summary =
      "Writes the animation as one GLB with morph targets, as a film, and as numbered OBJ and PLY "
      "files.";
  spec.inputs = {{"frames", "folder",
                  "frame_0000.ply, ... of one connectivity, and distortion.json", "", false, false},
                 {"textures", "file",
                  "of each key on the timeline, in order, in the frames' UV layout; or one for all",
                  "", true, true}};
  spec.outputs = {{"animation", "folder",
                   "character.glb, character.mp4, obj/, ply/, textures/, animation.json",
                   "animation", false, false}};
  spec.cores = 0;
  spec.memory_gib = 2;
  return keypose::RunStage<ExportOptions>(argc, argv, spec, Run);
}
