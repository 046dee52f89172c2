// keypose-export: frames become a GLB, and sequences of OBJ and PLY files.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/mesh_io.h"
#include "core/stage/stage.h"
#include "export/gltf.h"

namespace {

namespace fs = std::filesystem;
using keypose::InputError;
using keypose::Mesh;
using keypose::exporting::EncodedImage;

struct ExportOptions {
  keypose::exporting::PlaybackOptions playback;
  std::string up = "z";  // axis that points up in the frames
  bool obj = true;
  bool ply = true;

  void Describe(keypose::OptionVisitor& visit) {
    visit("fps", playback.fps, {"frames a second", "1/s", 0.1, 1000, {}});
    visit("hold", playback.hold, {"extra frames for which the first and the last frame stay", "frames", 0, 10000, {}});
    visit("loop", playback.loop, {"pingpong plays forwards and then back", "", -INFINITY, INFINITY, {"none", "pingpong"}});
    visit("up", up, {"axis that points up in the frames; the GLB's own is y", "", -INFINITY, INFINITY, {"z", "y"}});
    visit("obj", obj, {"also write numbered OBJ files", ""});
    visit("ply", ply, {"also write numbered PLY files", ""});
  }
};

struct Frames {
  std::vector<std::string> names;  // "frame_0000"
  std::vector<Mesh> meshes;
};

Frames ReadFrames(const fs::path& folder, keypose::Progress* progress) {
  if (!fs::is_directory(folder))
    throw InputError("export: " + folder.string() + " is not a folder of frames; pass what `interpolate` wrote");
  std::map<long, fs::path> numbered;
  const std::regex pattern("frame_([0-9]{1,9})\\.ply");
  for (const auto& entry : fs::directory_iterator(folder)) {
    std::smatch match;
    const std::string name = entry.path().filename().string();
    if (!std::regex_match(name, match, pattern)) continue;
    const auto [at, inserted] = numbered.emplace(std::stol(match[1]), entry.path());
    if (!inserted)
      throw InputError("export: " + name + " and " + at->second.filename().string() + " in " + folder.string() +
                       " have the same number; remove one");
  }
  if (numbered.empty()) throw InputError("export: " + folder.string() + " has no frames (frame_0000.ply, ...); run `interpolate` first");
  Frames frames;
  for (const auto& [number, path] : numbered) {
    const auto index = static_cast<long>(frames.names.size());
    if (number != index)
      throw InputError("export: frame " + std::to_string(index) + " is missing in " + folder.string() + " (found " +
                       path.filename().string() + " in its place); run `interpolate` again");
    keypose::Step(progress, 0.3 * static_cast<double>(index) / static_cast<double>(numbered.size()), "reading frames");
    frames.names.push_back(path.stem().string());
    frames.meshes.push_back(keypose::ReadMesh(path));
  }
  return frames;
}

// PNG and JPEG go in as they are; other kinds become PNG, as glTF knows only these two.
EncodedImage ReadTexture(const fs::path& path, const fs::path& scratch) {
  EncodedImage out;
  out.name = path.stem().string();
  const std::string format = keypose::ReadImageInfo(path).format;
  const keypose::Image8 pixels = keypose::ReadImage(path);  // proves that the file is whole
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

// Textures of several poses may have the same file name: the number keeps them apart. @return names in the folder
std::vector<std::string> WriteTextures(const std::vector<EncodedImage>& textures, const fs::path& folder) {
  std::vector<std::string> names;
  if (!textures.empty()) fs::create_directories(folder);
  for (std::size_t i = 0; i < textures.size(); ++i) {
    names.push_back("texture_" + std::to_string(i) + (textures[i].mime_type == "image/png" ? ".png" : ".jpg"));
    keypose::WriteFile(folder / names[i], textures[i].bytes);
  }
  return names;
}

void WriteSequence(const Frames& frames, const fs::path& folder, const std::string& extension, const std::string& texture,
                   keypose::Progress* progress) {
  fs::create_directories(folder);
  for (std::size_t i = 0; i < frames.meshes.size(); ++i) {
    keypose::Step(progress, static_cast<double>(i) / static_cast<double>(frames.meshes.size()), "writing " + extension + " files");
    Mesh mesh = frames.meshes[i];
    mesh.uvs = frames.meshes[0].uvs;
    mesh.uv_faces = frames.meshes[0].uv_faces;
    keypose::WriteMesh(folder / (frames.names[i] + "." + extension), mesh, mesh.has_uvs() ? texture : "");
  }
}

// The moments at which the animation shows each frame, and what `interpolate` measured of it.
nlohmann::json Summary(const Frames& frames, const ExportOptions& options, const fs::path& frames_folder,
                       const std::vector<std::string>& textures) {
  nlohmann::json measured = nlohmann::json::array();
  const fs::path distortion = frames_folder / "distortion.json";
  if (fs::exists(distortion)) {
    const auto json = nlohmann::json::parse(keypose::ReadFile(distortion), nullptr, false);
    if (json.is_discarded() || !json.contains("frames") || !json["frames"].is_array())
      throw InputError("export: " + distortion.string() + " is not JSON with a list `frames`; run `interpolate` again");
    measured = json["frames"];
  }
  nlohmann::json out = {{"schema", 1}, {"glb", "character.glb"}, {"fps", options.playback.fps}, {"loop", options.playback.loop}};
  out["vertices"] = frames.meshes[0].vertex_count();
  out["faces"] = frames.meshes[0].face_count();
  out["textures"] = textures;
  const auto moments = keypose::exporting::PlaybackMoments(static_cast<int>(frames.names.size()), options.playback);
  out["seconds"] = moments.back().seconds;
  for (const auto& moment : moments) out["moments"].push_back({{"seconds", moment.seconds}, {"frame", moment.frame}});
  for (std::size_t i = 0; i < frames.names.size(); ++i) {
    nlohmann::json frame = {{"name", frames.names[i]}};
    if (i < measured.size() && measured[i].is_object() && measured[i].contains("t")) frame["t"] = measured[i]["t"];
    out["frames"].push_back(frame);
  }
  return out;
}

void Run(keypose::StageContext& stage, const ExportOptions& options) {
  const fs::path folder = stage.Input("frames");
  const Frames frames = ReadFrames(folder, stage.progress());
  std::vector<EncodedImage> textures;
  for (const auto& path : stage.Inputs("textures")) textures.push_back(ReadTexture(path, stage.Scratch()));
  const auto mesh = keypose::exporting::MakeAnimatedMesh(frames.meshes, frames.names);

  keypose::Step(stage.progress(), 0.4, "writing the GLB");
  const keypose::exporting::GlbOptions glb{options.playback, options.up == "z", "character"};
  const std::string bytes = MakeGlb(mesh, frames.names, textures.empty() ? EncodedImage{} : textures[0], glb);
  const fs::path out = stage.Output("animation");
  keypose::WriteFile(out / "character.glb", bytes);
  const auto texture_names = WriteTextures(textures, out / "textures");
  const std::string map = texture_names.empty() ? "" : "../textures/" + texture_names[0];
  keypose::SubProgress obj_progress(stage.progress(), 0.5, 0.8), ply_progress(stage.progress(), 0.8, 1);
  if (options.obj) WriteSequence(frames, out / "obj", "obj", map, &obj_progress);
  if (options.ply) WriteSequence(frames, out / "ply", "ply", "", &ply_progress);
  const auto summary = Summary(frames, options, folder, texture_names);
  keypose::WriteFile(out / "animation.json", summary.dump(1) + "\n");

  stage.Report("frames", static_cast<std::int64_t>(frames.names.size()));
  stage.Report("morph_targets", static_cast<std::int64_t>(frames.names.size()) - 1);
  stage.Report("vertices", frames.meshes[0].vertex_count());
  stage.Report("split_vertices", static_cast<std::int64_t>(mesh.source_vertex.size()));
  stage.Report("faces", frames.meshes[0].face_count());
  stage.Report("textures", static_cast<std::int64_t>(textures.size()));
  stage.Report("animation_seconds", summary["seconds"].get<double>());
  stage.Report("glb_bytes", static_cast<std::int64_t>(bytes.size()));
}

}  // namespace

int main(int argc, char** argv) {
  keypose::StageSpec spec;
  spec.name = "export";
  spec.version = "1";
  spec.summary = "Writes the animation as one GLB with morph targets, and as numbered OBJ and PLY files.";
  spec.inputs = {{"frames", "folder", "frame_0000.ply, ... of one connectivity, and distortion.json", "", false, false},
                 {"textures", "file", "images in the frames' UV layout; the first goes into the GLB, all go beside it", "", true, true}};
  spec.outputs = {{"animation", "folder", "character.glb, obj/, ply/, textures/, animation.json", "animation", false, false}};
  spec.cores = 0;
  spec.memory_gib = 2;
  return keypose::RunStage<ExportOptions>(argc, argv, spec, Run);
}
