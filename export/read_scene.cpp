#include "export/read_scene.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <utility>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

namespace fs = std::filesystem;

/// @param folder  of numbered frames, or a mesh, which is the only frame
void ReadFrames(const fs::path& folder, Scene& scene, Progress* progress) {
  if (!fs::is_directory(folder)) {
    scene.frame_names.emplace_back("frame_0000");
    scene.frames.push_back(ReadMesh(folder));
    return;
  }
  const std::vector<fs::path> numbered = NumberedFrames(folder, "export");
  for (const fs::path& path : numbered) {
    ReportProgress(progress,
                   static_cast<double>(scene.frames.size()) / static_cast<double>(numbered.size()),
                   "reading frames");
    scene.frame_names.push_back(path.stem().string());
    scene.frames.push_back(ReadMesh(path));
  }
}

/// Texture coordinates for frames that have none.
void TakeLayout(const fs::path& path, Scene& scene) {
  Mesh& first = scene.frames.front();
  if (first.has_uvs()) return;
  const Mesh layout = ReadMesh(path);
  if (!SameFaces(layout.faces, first.faces) || !layout.has_uvs())
    throw InputError(
        "export: the layout " + PrintableName(path) +
        (layout.has_uvs() ? " has other faces than the frames" : " has no texture coordinates") +
        "; pass what `keypose unwrap` made of their first frame");
  first.uvs = layout.uvs;
  first.uv_faces = layout.uv_faces;
}

/// The template's own net, where its file has polygons.
void TakePolygons(StageContext& stage, Scene& scene) {
  const fs::path path = stage.Input("polygons");
  const Polygons polygons = ReadPolygonMesh(path).polygons;
  if (polygons.sizes.empty())
    return stage.Warn(PrintableName(path) +
                      " gives no polygons, which are read of OBJ files: triangles are exported");
  try {
    scene.net = NetOf(scene.frames[0], polygons);
    if (scene.net.taken_apart > 0)
      stage.Warn("polygons of " + PrintableName(path) +
                 " that are exported as triangles: " + std::to_string(scene.net.taken_apart) +
                 ", because a seam of the texture runs through them or a vertex comes twice");
    stage.Report("polygons", scene.net.face_count());
  } catch (const InputError& error) {
    throw InputError("export: the polygons of " + PrintableName(path) +
                     " do not belong to the frames: " + error.what() +
                     "; pass the mesh that they were made from, or none");
  }
}

// PNG and JPEG files are embedded unchanged; other formats become PNG, since glTF allows only these
// two.
EncodedImage ReadTexture(const fs::path& path, const fs::path& scratch) {
  EncodedImage out;
  out.name = path.stem().string();
  const std::string format = ReadImageInfo(path).format;
  const Image8 pixels = keypose::ReadTexture(path);  // checks that the file is complete
  if (format == "png" || format == "jpeg") {
    out.mime_type = "image/" + format;
    out.bytes = ReadFile(path);
    return out;
  }
  const fs::path converted = scratch / (out.name + ".png");
  WriteImage(converted, pixels);
  out.mime_type = "image/png";
  out.bytes = ReadFile(converted);
  return out;
}

/// The pictures of a folder, by the numbers in their names.
std::vector<fs::path> NumberedTextures(const fs::path& folder, int frame_count) {
  std::map<int, fs::path> numbered;
  for (const auto& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    const std::string kind = entry.path().extension().string();
    const auto digits = name.find_last_not_of("0123456789") + 1;
    if (name.starts_with(".") || (kind != ".png" && kind != ".jpg")) continue;
    if (digits == name.size() || name.size() - digits > 8) continue;
    if (!numbered.emplace(std::stoi(name.substr(digits)), entry.path()).second)
      throw InputError("export: " + PrintableName(folder) + " has two textures of number " +
                       name.substr(digits));
  }
  std::vector<fs::path> paths;
  for (int f = 0; f < frame_count; ++f) {
    if (!numbered.count(f))
      throw InputError("export: the folder " + PrintableName(folder) + " has no texture of frame " +
                       std::to_string(f) + ", but there are " + std::to_string(frame_count) +
                       " frames; make textures and frames of one motion");
    paths.push_back(numbered[f]);
  }
  return paths;
}

/// A texture for each frame, as `video3d` writes them.
void ReadFrameTextures(const fs::path& folder, const fs::path& scratch, Scene& scene) {
  const std::vector<fs::path> paths = NumberedTextures(folder, SizeOf(scene.frames));
  for (const fs::path& path : paths) scene.frame_texture_names.push_back(path.filename().string());
  scene.textures.push_back(ReadTexture(paths[0], scratch));
  scene.texture_pixels.push_back(keypose::ReadTexture(paths[0]));
  scene.poses.push_back("");
  scene.texture_of_frame = [paths](int frame) { return keypose::ReadTexture(paths[frame]); };
}

/// Textures with equal content are one. @return index of the texture, per key
std::vector<int> ReadTextures(StageContext& stage, const std::vector<std::string>& poses,
                              Scene& scene) {
  const std::vector<fs::path> paths = stage.Inputs("textures");
  if (!poses.empty() && paths.size() > 1 && poses.size() != paths.size())
    throw UsageError("export: `poses` names " + std::to_string(poses.size()) +
                     " keys, but there are " + std::to_string(paths.size()) +
                     " textures; give one name for each");
  std::vector<int> of_key;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    EncodedImage image = ReadTexture(paths[i], stage.Scratch());
    const auto same =
        std::find_if(scene.textures.begin(), scene.textures.end(),
                     [&](const EncodedImage& other) { return other.bytes == image.bytes; });
    of_key.push_back(static_cast<int>(same - scene.textures.begin()));
    if (same != scene.textures.end()) continue;
    scene.poses.push_back(i < poses.size() ? poses[i] : "key-" + std::to_string(i));
    scene.textures.push_back(std::move(image));
    scene.texture_pixels.push_back(keypose::ReadTexture(paths[i]));
  }
  return of_key;
}

/// What `interpolate` wrote about its frames; lists are empty if it wrote nothing.
struct FrameNotes {
  std::vector<char> stands;     // one per frame; empty from older versions of `interpolate`
  std::vector<double> t;        // one per frame
  std::vector<int> key_frames;  // one per key
  bool loop = false;
};

nlohmann::json ReadDistortion(const fs::path& path) {
  if (!fs::exists(path)) return {};
  auto json = nlohmann::json::parse(ReadFile(path), nullptr, false);
  if (json.is_discarded() || !json.is_object() || !json.contains("frames") ||
      !json["frames"].is_array())
    throw InputError("export: " + path.string() +
                     " is not JSON with a list `frames`; run `interpolate` again");
  return json;
}

FrameNotes ReadNotes(const fs::path& folder, int frame_count) {
  FrameNotes notes;
  if (!fs::is_directory(folder)) {
    notes.key_frames = {0};
    return notes;
  }
  const nlohmann::json json = ReadDistortion(folder / "distortion.json");
  if (json.is_null() || SizeOf(json["frames"]) != frame_count) return notes;
  notes.loop = json.contains("loop") && json["loop"] == true;
  for (const auto& frame : json.value("key_frames", nlohmann::json::array()))
    if (frame.is_number_integer() && frame >= 0 && frame < frame_count)
      notes.key_frames.push_back(frame);
  bool says_what_stands = false;
  for (const auto& frame : json["frames"]) {
    if (!frame.is_object()) continue;
    if (frame.contains("t") && frame["t"].is_number()) notes.t.push_back(frame["t"].get<double>());
    says_what_stands |= frame.contains("stands");
    notes.stands.push_back(frame.value("stands", false));
  }
  if (SizeOf(notes.t) != frame_count) notes.t.clear();
  if (!says_what_stands) notes.stands.clear();
  return notes;
}

/// The weights of the textures over time; none if there is only one texture, or if they are not
/// the textures of the keys.
void BlendTextures(StageContext& stage, const FrameNotes& notes, const std::vector<int>& of_key,
                   Scene& scene) {
  const int count = SizeOf(scene.textures);
  if (count < 2) return;
  if (notes.t.empty() || notes.key_frames.size() != of_key.size()) {
    stage.Warn("the animation shows only the first texture: there are " +
               std::to_string(of_key.size()) + " textures, and " +
               (notes.t.empty() ? "the frames have no distortion.json with a `t` for each"
                                : "the frames were made from " +
                                      std::to_string(notes.key_frames.size()) + " keys") +
               "; pass one texture for each key, in the keys' order");
    return;
  }
  scene.texture_moments = TextureMoments(SceneKeyframes(scene), notes.t, of_key, count);
  for (const double t : notes.t) scene.texture_weights.push_back(TextureWeights(t, of_key, count));
}

std::vector<KeyMark> MarkKeys(const FrameNotes& notes, const std::vector<std::string>& poses) {
  std::vector<KeyMark> marks;
  for (std::size_t i = 0; i < notes.key_frames.size(); ++i) {
    const bool named = poses.size() == notes.key_frames.size();
    marks.push_back({notes.key_frames[i], named ? poses[i] : "key-" + std::to_string(i)});
  }
  return marks;
}

/// Turns the figure so that its front lies where that of a figure with front 0 does.
void TurnToFront(const FramePlacement& placement, std::vector<Mesh>& frames) {
  const Eigen::Vector3d up = placement.z_up ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
  const double angle = -placement.front_deg * std::numbers::pi / 180;
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(angle, up).toRotationMatrix();
  for (Mesh& frame : frames) {
    frame.points = (frame.points * turn.transpose()).eval();
    if (frame.normals.rows() > 0) frame.normals = (frame.normals * turn.transpose()).eval();
  }
}

}  // namespace

Scene ReadScene(StageContext& stage, const PlaybackOptions& playback,
                const FramePlacement& placement, const std::vector<std::string>& poses) {
  const fs::path folder = stage.Input("frames");
  SubProgress reading(stage.progress(), 0, kReadingShare);
  Scene scene;
  scene.playback = playback;
  scene.z_up = placement.z_up;
  ReadFrames(folder, scene, &reading);
  if (placement.metres != 1)
    for (Mesh& frame : scene.frames) frame.points *= placement.metres;
  if (placement.front_deg != 0) TurnToFront(placement, scene.frames);
  if (stage.Has("layout")) TakeLayout(stage.Input("layout"), scene);
  scene.net = NetOf(scene.frames[0], {});
  if (stage.Has("polygons")) TakePolygons(stage, scene);
  const FrameNotes notes = ReadNotes(folder, SizeOf(scene.frames));
  const std::vector<fs::path> given = stage.Inputs("textures");
  const bool per_frame = given.size() == 1 && fs::is_directory(given[0]);
  std::vector<int> of_key;
  if (per_frame)
    ReadFrameTextures(given[0], stage.Scratch(), scene);
  else
    of_key = ReadTextures(stage, poses, scene);
  scene.split = MakeAnimatedMesh(scene.frames, scene.frame_names);
  scene.clip = MakeClip(scene.split.points, notes.stands, notes.loop);
  scene.frame_t = notes.t;
  scene.keys = MarkKeys(notes, poses);
  BlendTextures(stage, notes, of_key, scene);
  return scene;
}

}  // namespace keypose::exporting
