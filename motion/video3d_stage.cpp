// keypose-video3d: a texture for each frame of a moving mesh, from films of several cameras.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "motion/films/video3d_input.h"
#include "motion/video3d/free_view.h"
#include "motion/video3d/picture_difference.h"
#include "motion/video3d/texture_sequence.h"
#include "motion/video3d_options.h"
#include "views/film/frame_painter.h"
#include "views/film/ground_shadow.h"
#include "views/film/mp4.h"
#include "views/shot/shot_views.h"

namespace keypose::motion {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualRate = 25;

StageSpec Spec() {
  StageSpec spec;
  spec.name = "video3d";
  spec.version = "8";
  spec.summary = "Paints a moving mesh from the films of several cameras, a texture a frame.";
  spec.title = "Painted by the films";
  spec.inputs = MovingMeshPorts();
  spec.inputs.push_back(
      {"texture", "file", "the mesh's own texture, for what no camera ever sees", "", true, false});
  spec.inputs.push_back(
      {"camera_path", "path",
       "the film's camera: a path (.json), or a calibration whose first camera is meant", "", true,
       false});
  spec.outputs = {
      {"textures", "folder", "frame_0000.png ..., one for each frame", "textures", false, false},
      {"film", "file", "the textured mesh from a free viewpoint (.mp4)", "free_view.mp4", true,
       false},
      {"picture", "file", "films beside the textured mesh (.jpg)", "video3d.jpg", true, false}};
  spec.memory_gib = 2;
  spec.common = {"texture_size", "cameras", "view", "turns"};
  return spec;
}

std::string TextureName(int frame, const std::string& extension) {
  char name[32];
  std::snprintf(name, sizeof name, "frame_%04d.", frame);
  return name + extension;
}

/// Colours of frames as raw files in a folder.
ColorStore StoreIn(const fs::path& folder) {
  const auto path = [folder](int frame) { return folder / ("colors_" + std::to_string(frame)); };
  ColorStore store;
  store.put = [path](int frame, const TexelColors& colors) {
    std::string bytes(colors.color.begin(), colors.color.end());
    bytes.append(colors.sure.begin(), colors.sure.end());
    WriteFile(path(frame), bytes);
  };
  store.get = [path](int frame) {
    const std::string bytes = ReadFile(path(frame));
    const std::size_t count = bytes.size() / 4;
    TexelColors colors;
    colors.color.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(3 * count));
    colors.sure.assign(bytes.begin() + static_cast<std::ptrdiff_t>(3 * count), bytes.end());
    return colors;
  };
  return store;
}

SequenceOptions OptionsOf(const Video3dOptions& given, const Video3dInput& input) {
  SequenceOptions options;
  options.texture_size =
      given.texture_size > 0 ? given.texture_size : AdviseSequenceSize(input.mesh(), input.views());
  options.level_exposure = given.level_exposure;
  options.view.erosion_px = given.erosion_px;
  options.blend = {given.smoothing, given.agreement};
  options.fill = {given.fill_frames, given.gutter};
  return options;
}

Image8 OwnTexture(StageContext& stage, int size) {
  if (!stage.Has("texture")) return {};
  const Image8 texture = ReadImage(stage.Input("texture"), 3);
  return texture.width == size && texture.height == size ? texture : Resized(texture, size, size);
}

/// All cameras of the shot; `cameras` may have left some out.
SyncedFilms AllFilms(StageContext& stage, const Video3dInput& input) {
  return SyncedFilms(stage, {"video3d", "compared", "", SizeOf(input.meshes()), false});
}

std::vector<View> AllViews(StageContext& stage, const Video3dInput& input,
                           const Video3dOptions& options) {
  return options.cameras.empty() ? input.views() : AllFilms(stage, input).views();
}

std::vector<View> FilmViews(StageContext& stage, const Video3dInput& input,
                            const Video3dOptions& options) {
  FreeViewOptions how;
  how.width = options.view_width;
  how.height = options.view_height;
  how.up = input.up();
  how.turns = options.turns;
  const int frames = SizeOf(input.meshes());
  const auto standing = [&](const View& view) {
    return std::vector<View>(static_cast<std::size_t>(frames), view);
  };
  if (stage.Has("camera_path")) {
    const fs::path path = stage.Input("camera_path");
    if (path.extension() == ".json" && fs::is_regular_file(path)) {
      const std::string text = ReadFile(path), name = path.filename().string();
      RequireShallowJson(text, "video3d: " + name);
      return PathViews(ParseCameraPath(text, name), frames, how);
    }
    View view = ReadRigCalibration(path).views.front();
    if (view.camera.width % 2 || view.camera.height % 2 || view.camera.width == 0)
      throw InputError("video3d: the camera of " + path.filename().string() + " has pictures of " +
                       std::to_string(view.camera.width) + " x " +
                       std::to_string(view.camera.height) + "; a film needs even numbers");
    return standing(view);
  }
  if (options.view == "orbit") return OrbitViews(input.meshes(), how);
  std::vector<std::string> names;
  for (const View& view : AllViews(stage, input, options)) {
    names.push_back(view.name);
    if (view.name != options.view) continue;
    View even = view;
    even.camera.width -= even.camera.width % 2;
    even.camera.height -= even.camera.height % 2;
    return standing(even);
  }
  throw UsageError("video3d: --view " + options.view +
                   " is neither orbit nor a camera; there are " + Listed(names));
}

/// The textured frames, for pictures of them.
class Painted {
 public:
  Painted(const Video3dInput& input, const fs::path& textures, const Video3dOptions& options)
      : scene_{input.meshes(), no_textures_} {
    scene_.shading = 0;  // the films' light is in the textures
    scene_.texture_of_frame = [textures, extension = options.pictures](int frame) {
      return ReadImage(textures / TextureName(frame, extension), 3);
    };
    if (options.shadow) ground_ = GroundUnder(input.meshes(), input.up());
    shadow_ = options.shadow;
  }
  Image8 Picture(int frame, const View& view, bool shadow) const {
    return RenderPicture(scene_, frame, view, shadow && shadow_ ? &ground_ : nullptr);
  }

 private:
  std::vector<Image8> no_textures_;
  FilmScene scene_;
  Ground ground_{};
  bool shadow_ = false;
};

void WriteFilm(StageContext& stage, const Painted& painted, const std::vector<View>& views,
               double fps, Progress* progress) {
  const fs::path path = stage.Output("film");
  Mp4Writer writer(path, views[0].camera.width, views[0].camera.height, fps);
  for (int f = 0; f < SizeOf(views); ++f) {
    ReportProgress(progress, static_cast<double>(f) / SizeOf(views), "rendering the film");
    writer.Add(painted.Picture(f, views[f], true));
  }
  writer.Finish();
}

/// Films beside the textured mesh, in some frames of some cameras.
void WritePicture(StageContext& stage, Video3dInput& input, const Painted& painted) {
  const fs::path path = stage.Output("picture");
  if (path.empty()) return;
  constexpr int kMoments = 3, kWidth = 480;
  const int frames = SizeOf(input.meshes()), cameras = SizeOf(input.views());
  const int moments = std::min(kMoments, frames);
  std::vector<Image8> tiles;
  for (int m = 0; m < moments; ++m) {
    const int f = static_cast<int>((m + 0.5) * frames / moments), v = m * cameras / moments;
    const FilmedFrame frame = input.Read(f);
    if (frame.pictures[v].empty()) continue;
    const View& view = input.views()[v];
    const int height = std::max(1, kWidth * view.camera.height / view.camera.width);
    tiles.push_back(Resized(frame.pictures[v], kWidth, height));
    tiles.push_back(
        Resized(LaidOver(painted.Picture(f, view, false), kFilmBackground), kWidth, height));
  }
  if (!tiles.empty()) WriteImage(path, TileImages(tiles, 2), 88);
}

/// What the painted mesh and the cameras that did not paint it have in common.
void CompareOthers(StageContext& stage, const Video3dInput& input, const Painted& painted,
                   Progress* progress) {
  constexpr int kEvery = 6;
  SyncedFilms films = AllFilms(stage, input);
  std::vector<std::size_t> others;
  for (std::size_t v = 0; v < films.views().size(); ++v)
    if (std::none_of(input.views().begin(), input.views().end(),
                     [&](const View& used) { return used.name == films.views()[v].name; }))
      others.push_back(v);
  std::vector<PictureDifference> differences(others.size());
  for (int f = 0; f < SizeOf(input.meshes()) && !others.empty(); f += kEvery) {
    ReportProgress(progress, static_cast<double>(f) / SizeOf(input.meshes()),
                   "comparing cameras that were left out");
    const FilmedPictures filmed = films.Read(f);
    for (std::size_t i = 0; i < others.size(); ++i) {
      const std::size_t v = others[i];
      if (filmed.pictures[v].empty()) continue;
      differences[i].Add(painted.Picture(f, films.views()[v], false), filmed.pictures[v],
                         filmed.masks[v]);
    }
  }
  nlohmann::json compared = nlohmann::json::array();
  for (std::size_t i = 0; i < others.size(); ++i)
    compared.push_back({{"name", films.views()[others[i]].name},
                        {"psnr_db", differences[i].Psnr()},
                        {"covered", differences[i].Covered()}});
  stage.ReportJson("other_cameras", compared.dump());
}

void ReportCameras(StageContext& stage, const Video3dInput& input, const SequenceReport& report) {
  nlohmann::json cameras = nlohmann::json::array();
  std::vector<std::string> alone;
  for (std::size_t v = 0; v < input.views().size(); ++v) {
    const Eigen::Vector3f& gain = report.exposure.gains[v];
    cameras.push_back({{"name", input.views()[v].name},
                       {"gain", {gain[0], gain[1], gain[2]}},
                       {"frames", report.frames_seen[v]},
                       {"in_masks", report.covered[v]}});
    if (!report.exposure.compared[v]) alone.push_back(input.views()[v].name);
  }
  stage.ReportJson("cameras", cameras.dump());
  if (!alone.empty() && input.views().size() > 1)
    stage.Warn("nothing that " + Listed(alone) +
               " shows of the mesh is shown by another camera too, so exposure could not be "
               "levelled there; place cameras so that neighbours overlap");
}

void ReportRun(StageContext& stage, const Video3dInput& input, const SequenceReport& report,
               int size) {
  const auto mean = [](const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
  };
  stage.Report("frames", SizeOf(input.meshes()));
  stage.Report("texture_size", size);
  stage.Report("own_fraction", mean(report.own));
  stage.Report("neighbours_fraction", mean(report.neighbours));
  stage.Report("never_seen_fraction", 1 - report.seen_ever);
  ReportCameras(stage, input, report);
}

void Run(StageContext& stage, const Video3dOptions& options) {
  Video3dInput input(stage, {options.cameras, options.up});
  const fs::path textures = stage.Output("textures"), film = stage.Output("film");
  // A wrong view is told before the work, not after it.
  const std::vector<View> views =
      film.empty() ? std::vector<View>() : FilmViews(stage, input, options);
  if (!film.empty() && !CanWriteMp4())
    throw ToolError(
        "video3d: libavcodec has no x264 here, so --film cannot be written; install "
        "Debian's libavcodec-extra or libavcodec59, or leave --film out");
  const SequenceOptions how = OptionsOf(options, input);
  SequenceInput sequence{input.mesh(), input.views(), SizeOf(input.meshes()),
                         [&](int frame) { return input.Read(frame); },
                         OwnTexture(stage, how.texture_size)};
  SubProgress painting(stage.progress(), 0, film.empty() ? 1 : 0.8),
      filming(stage.progress(), 0.8, 1);
  const SequenceReport report = MakeTextures(
      sequence, how, StoreIn(stage.Scratch()),
      [&](int frame, const Image8& texture) {
        WriteImage(textures / TextureName(frame, options.pictures), texture, 92);
      },
      &painting);
  ReportRun(stage, input, report, how.texture_size);
  const Painted painted(input, textures, options);
  const double fps = input.frames_per_second() > 0 ? input.frames_per_second() : kUsualRate;
  if (!film.empty()) WriteFilm(stage, painted, views, fps, &filming);
  WritePicture(stage, input, painted);
  if (!options.cameras.empty()) CompareOthers(stage, input, painted, stage.progress());
}

}  // namespace
}  // namespace keypose::motion

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::motion::Video3dOptions>(argc, argv, keypose::motion::Spec(),
                                                            keypose::motion::Run);
}
