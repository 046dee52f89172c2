#include "export/formats.h"

#include <algorithm>
#include <functional>
#include <utility>

#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/mesh_io.h"
#include "core/size_of.h"
#include "export/film/mp4.h"
#include "export/gltf/gltf.h"

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
  return Save(job, made);
}

WrittenFormat WriteSequence(const Job& job, const std::string& extension,
                            const std::string& texture) {
  const fs::path folder = job.folder / extension;
  fs::create_directories(folder);
  const auto count = job.scene.frames.size();
  for (std::size_t i = 0; i < count; ++i) {
    ReportProgress(job.progress, static_cast<double>(i) / static_cast<double>(count),
                   "writing " + extension + " files");
    Mesh mesh = job.scene.frames[i];
    mesh.uvs = job.scene.frames[0].uvs;
    mesh.uv_faces = job.scene.frames[0].uv_faces;
    WriteMesh(folder / (job.scene.frame_names[i] + "." + extension), mesh,
              mesh.has_uvs() ? texture : "");
  }
  WrittenFormat written;
  written.files.push_back(extension + "/");
  return written;
}

WrittenFormat WriteObj(const Job& job) {
  const bool textured = !job.texture_names.empty();
  return WriteSequence(job, "obj", textured ? "../textures/" + job.texture_names[0] : "");
}

WrittenFormat WritePly(const Job& job) { return WriteSequence(job, "ply", ""); }

/// The animation as a film from one direction. A single frame is no film.
WrittenFormat WriteVideo(const Job& job) {
  WrittenFormat written;
  if (job.scene.frame_count() < 2) return written;
  if (!CanWriteMp4()) {
    job.stage.Warn(
        "no film was written: libavcodec has no x264 here; install Debian's libavcodec59, or "
        "leave `video` out of `formats`");
    return written;
  }
  const FilmScene film{job.scene.frames, job.scene.texture_pixels, job.scene.texture_weights};
  std::vector<int> order = ShownFrames(job.scene);
  // When the film is looped, its last picture is the first picture of the next round.
  const bool loops = job.scene.clip.loop || job.scene.playback.loop == "pingpong";
  if (loops && order.size() > 1) order.pop_back();
  Mp4Writer writer(job.folder / "character.mp4", job.options.film.width, job.options.film.height,
                   job.scene.playback.fps);
  RenderFilm(
      film, order, job.options.film, [&](const Image8& picture) { writer.Add(picture); },
      job.progress);
  writer.Finish();
  written.files.push_back("character.mp4");
  written.measured["pictures"] = SizeOf(order);
  return written;
}

using Write = std::function<WrittenFormat(const Job&)>;
const std::vector<std::pair<std::string, Write>>& Formats() {
  static const std::vector<std::pair<std::string, Write>> formats = {
      {"glb", WriteGlb}, {"video", WriteVideo}, {"obj", WriteObj}, {"ply", WritePly}};
  return formats;
}

}  // namespace

std::vector<std::string> FormatNames() {
  std::vector<std::string> names;
  for (const auto& [name, write] : Formats()) names.push_back(name);
  return names;
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
