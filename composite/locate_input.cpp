#include "composite/locate_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>

#include "composite/companion_film.h"
#include "composite/given_mattes.h"
#include "composite/locate_clicks.h"
#include "composite/locating/mattes/mattes.h"
#include "composite/locating/outline/shrunk.h"
#include "composite/scene/scene_plates.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/pictures/given_matte.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

constexpr double kUsualFocal35mm = 50, kExifDeviation = 0.03;
constexpr double kUsualFps = 12;
constexpr double kSensorDeviation = 0.06;  // where the sensor is a guess

std::vector<std::string> SplitByCommas(const std::string& text) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::size_t first = text.find_first_not_of(' ', begin);
    std::string part = first < end ? text.substr(first, end - first) : "";
    part.erase(part.find_last_not_of(' ') + 1);
    parts.push_back(std::move(part));
    begin = end + 1;
  }
  return parts;
}

std::optional<int> NumberIn(std::string_view text) {
  int number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || fault != std::errc() || end != text.data() + text.size() || number < 0)
    return {};
  return number;
}

/// The meshes' files: those of --mesh, or all of the folder --frames.
std::vector<fs::path> MeshFiles(StageContext& stage) {
  if (stage.Has("frames") == stage.Has("mesh"))
    throw UsageError(
        "locate: pass either --frames (the animation's folder) or --mesh (one for each "
        "pose)");
  return stage.Has("mesh") ? stage.Inputs("mesh") : NumberedFrames(stage.Input("frames"), "locate");
}

/// Which mesh each picture shows. Without --shows: the same for all, one each, or evenly spread.
class Shows {
 public:
  /// @param keys  the meshes that are the animation's keys; names may be those of the keys
  Shows(const LocateStageOptions& options, int meshes, const std::vector<int>& keys,
        const std::vector<FilmPicture>& pictures)
      : meshes_(meshes), pictures_(pictures), names_(SplitByCommas(options.poses)) {
    const bool of_keys = SizeOf(names_) != meshes && names_.size() == keys.size();
    if (!names_.empty() && SizeOf(names_) != meshes && !of_keys)
      throw UsageError(fmt::format(
          "locate: --poses names {} poses, but there are {} meshes, and {} keys among them",
          names_.size(), meshes, keys.size()));
    for (int k = 0; k < SizeOf(names_); ++k) mesh_of_name_.push_back(of_keys ? keys[k] : k);
    const std::vector<std::string> parts = SplitByCommas(options.shows);
    for (int k = 0; k < SizeOf(parts); ++k)
      AddPart(parts[k], parts.size() == names_.size() ? k : -1);
  }

  /// @return pictures to locate, and the mesh of each. With `between` also those between pictures
  /// that show a key: the animation's frames are spread evenly over them.
  std::vector<std::pair<FilmPicture, int>> Chosen(bool between) const {
    std::vector<std::pair<FilmPicture, int>> chosen;
    for (int i = 0; i < SizeOf(pictures_); ++i) {
      if (given_.empty())
        chosen.push_back({pictures_[i], MeshOf(i)});
      else if (const auto at = given_.find(pictures_[i].frame); at != given_.end())
        chosen.push_back({pictures_[i], at->second});
      else if (const int mesh = between ? MeshBetween(pictures_[i].frame) : -1; mesh >= 0)
        chosen.push_back({pictures_[i], mesh});
    }
    for (const auto& [frame, mesh] : given_)
      if (std::none_of(pictures_.begin(), pictures_.end(),
                       [&, f = frame](const FilmPicture& p) { return p.frame == f; }))
        throw InputError(fmt::format(
            "locate: --shows names frame {}, but the plate has no picture of that number; frames "
            "count from the film's first picture, so {} is frame 0 and {} frame {}",
            frame, PrintableName(pictures_.front().path.filename()),
            PrintableName(pictures_.back().path.filename()), pictures_.back().frame));
    return chosen;
  }
  std::string NameOf(int mesh) const {
    const auto at = std::find(mesh_of_name_.begin(), mesh_of_name_.end(), mesh);
    return at == mesh_of_name_.end() ? "" : names_[at - mesh_of_name_.begin()];
  }

 private:
  /// The mesh of a pose's name. A name that several keys have means the one of this index, where it
  /// is that key's name.
  std::optional<int> MeshNamed(const std::string& pose, int index) const {
    if (index >= 0 && names_[index] == pose) return mesh_of_name_[index];
    const auto at = std::find(names_.begin(), names_.end(), pose);
    if (at == names_.end()) return {};
    return mesh_of_name_[at - names_.begin()];
  }
  void AddPart(const std::string& part, int index) {
    const std::size_t equals = part.find('=');
    const std::string_view text(part);
    const std::optional<int> frame = NumberIn(text.substr(0, std::min(equals, text.size())));
    if (!frame || equals == std::string::npos)
      throw UsageError("locate: --shows has '" + part + "'; it needs FRAME=POSE, such as 4=wave");
    const std::string pose = part.substr(equals + 1);
    const std::optional<int> named = MeshNamed(pose, index);
    const int mesh = named ? *named : NumberIn(pose).value_or(-1);
    if (mesh < 0 || mesh >= meshes_)
      throw UsageError(
          fmt::format("locate: --shows has pose '{}', which is neither one of --poses "
                      "nor the number of a mesh from 0 to {}",
                      pose, meshes_ - 1));
    const auto [at, added] = given_.emplace(*frame, mesh);
    if (!added && at->second != mesh)
      throw UsageError(
          fmt::format("locate: --shows gives frame {} two poses; name each frame once", *frame));
  }
  /// The animation's frame between two keys; -1: before, after, or at no whole frame of it.
  int MeshBetween(int frame) const {
    const auto after = given_.upper_bound(frame);
    if (after == given_.begin() || after == given_.end()) return -1;
    const auto before = std::prev(after);
    const int meshes = after->second - before->second, frames = after->first - before->first;
    if (meshes <= 0 || meshes % frames) return -1;
    return before->second + (frame - before->first) * (meshes / frames);
  }
  int MeshOf(int i) const {
    if (meshes_ == 1) return 0;
    if (meshes_ == SizeOf(pictures_)) return i;
    // An animation over the whole film: its frames are spread evenly between the pictures.
    const int last = pictures_.back().frame;
    if (last > 0 && (meshes_ - 1) % last == 0) return pictures_[i].frame * ((meshes_ - 1) / last);
    throw UsageError(fmt::format(
        "locate: there are {} meshes and {} pictures; say by --shows which picture shows which, "
        "such as 0=0,4=1",
        meshes_, pictures_.size()));
  }

  int meshes_;
  const std::vector<FilmPicture>& pictures_;
  std::vector<std::string> names_;
  std::vector<int> mesh_of_name_;
  std::map<int, int> given_;
};

/// Reads the meshes that are used; `pose` of each frame becomes an index into shot.poses.
void ReadMeshes(const std::vector<fs::path>& files, const Shows& shows,
                std::vector<std::pair<FilmPicture, int>>& chosen, LocateInput& input) {
  std::map<int, int> index;
  for (auto& [picture, mesh] : chosen) {
    const auto [at, added] = index.emplace(mesh, SizeOf(input.shot.poses));
    if (added) {
      const bool is_first = input.shot.poses.empty();
      Mesh read = is_first ? ReadMesh(files[mesh]) : ReadMeshCutAs(files[mesh], input.mesh);
      RequireUsable(read, "locate: " + files[mesh].filename().string());
      if (!is_first && !SameFaces(read.faces, input.mesh.faces))
        throw InputError("locate: " + files[mesh].string() +
                         " has other faces than the first mesh; pass poses that register or fit "
                         "made from one template");
      input.shot.poses.push_back(read.points);
      input.pose_names.push_back(shows.NameOf(mesh));
      if (is_first) input.mesh = std::move(read);
    }
    mesh = at->second;
  }
}

void RequireSize(const Image8& image, const fs::path& path, const Camera& camera,
                 const std::string& of) {
  if (image.width == camera.width && image.height == camera.height) return;
  throw InputError(fmt::format("locate: {} has {} x {} pixels, but {} has {} x {}",
                               path.filename().string(), image.width, image.height, of,
                               camera.width, camera.height));
}

Image8 Reduced(const Image8& image, const Camera& camera) {
  return image.width == camera.width ? image : Shrunk(image, camera.width, camera.height);
}

/// The camera of the whole pictures: lens from EXIF, or as given.
void SetCamera(StageContext& stage, const LocateStageOptions& options, const fs::path& first,
               LocateInput& input) {
  const ImageInfo info = ReadImageInfo(first);
  Camera& camera = input.camera;
  camera.width = info.width;
  camera.height = info.height;
  camera.cx = info.width / 2.0;
  camera.cy = info.height / 2.0;
  const double longer = std::max(info.width, info.height);
  double focal_35mm = kUsualFocal35mm;
  if (options.focal_35mm > 0) {
    focal_35mm = options.focal_35mm;
    input.shot.focal_fixed = true;
  } else if (const double focal_px =
                 FocalPx(info.width, info.height, info.focal_35mm.value_or(0),
                         info.focal_mm.value_or(0), info.sensor_width_mm.value_or(0));
             focal_px > 0) {
    focal_35mm = focal_px * 36 / longer;
    input.shot.focal_deviation = info.focal_35mm ? kExifDeviation : kSensorDeviation;
  }
  camera.fx = camera.fy = focal_35mm / 36 * longer;
  input.scale = std::min(1.0, options.max_size / longer);
  input.shot.camera = camera.Scaled(input.scale);
  stage.Report("focal_start_px", camera.fx);
}

/// Pictures of scene light are looked at as sRGB, in whole: film and plates alike.
ShowLight ShowLightOf(StageContext& stage, const LocateStageOptions& options) {
  const StatedColors stated{options.plate_colorspace,
                            stage.Has("ocio_config") ? stage.Input("ocio_config") : fs::path()};
  return [stated, &stage, plates = std::shared_ptr<ScenePlates>()](const fs::path& path) mutable {
    if (!plates) {
      plates = std::make_shared<ScenePlates>(stated, path);
      stage.Note(fmt::format("locate: {} is read as {}", PrintableName(path.filename()),
                             plates->colors().meaning()));
      if (const std::string& doubt = plates->colors().doubt(); !doubt.empty())
        stage.Warn("locate: " + doubt);
    }
    return plates->ShownWhole(path);
  };
}

/// Colours that are stated of neither film nor plates would be lost without a word.
void RequireLight(StageContext& stage, const std::string& colorspace, const FilmFiles& film) {
  if (film.is_light() || (colorspace.empty() && !stage.Has("ocio_config"))) return;
  if (stage.Has("background") && !LightPictures(stage.Input("background")).empty()) return;
  throw UsageError(
      "locate: plate_colorspace and ocio_config are for OpenEXR and DPX plates; pictures of other "
      "kinds are sRGB");
}

/// What helps to see the figure in a picture; either may be missing.
struct Companions {
  std::optional<CompanionFilm> mattes, plates;
  int plates_a_frame = 1;

  /// @throws InputError  one matte for several pictures
  Companions(StageContext& stage, const LocateStageOptions& options,
             const std::vector<FilmPicture>& film, const std::vector<int>& frames) {
    if (stage.Has("matte")) {
      mattes.emplace(stage.Input("matte"), "matte");
      if (mattes->single() && frames.size() > 1)
        throw InputError(fmt::format(
            "locate: one matte for {} pictures; pass a folder with a matte for each, or a video",
            frames.size()));
      mattes->MatchNumbers(film);
      mattes->Decode(frames, 1, stage.progress());
    }
    const bool moves = options.camera == "moving";
    if (!stage.Has("background") || options.quick || (mattes && !moves)) return;
    plates.emplace(stage.Input("background"), "plate", ShowLightOf(stage, options));
    if (!moves) plates->TakeFirst();
    if (!plates->single()) plates_a_frame = PlatesAFrame(plates->last(), film.back().frame);
    plates->Decode(moves ? Numbers(frames) : frames, moves ? 1 : plates_a_frame, stage.progress());
  }

 private:
  /// Of all plates from the first frame to the last one.
  std::vector<int> Numbers(const std::vector<int>& frames) const {
    std::vector<int> numbers;
    for (int n = frames.front() * plates_a_frame; n <= frames.back() * plates_a_frame; ++n)
      numbers.push_back(n);
    return numbers;
  }
};

void AddFrame(const FilmPicture& picture, int pose, const Companions& companions,
              GivenMattes& mattes, LocateInput& input) {
  const std::string first =
      input.pictures.empty() ? "" : input.pictures[0].path.filename().string();
  LocateFrame frame;
  frame.name = picture.path.filename().string();
  frame.pose = pose;
  frame.time = picture.frame;
  const Image8 whole = ReadImage(picture.path, 3);
  RequireSize(whole, picture.path, input.camera, first);
  frame.picture = Reduced(whole, input.shot.camera);
  if (companions.mattes) {
    const fs::path path = companions.mattes->For(picture);
    frame.matte = Reduced(mattes.Read(path, {whole.width, whole.height,
                                             ReadImageInfo(picture.path).orientation, frame.name}),
                          input.shot.camera);
  } else if (companions.plates) {
    const fs::path path = companions.plates->For(picture, companions.plates_a_frame);
    const Image8 plate = ReadImage(path, 3);
    RequireSize(plate, path, input.camera, frame.name);
    frame.matte = Reduced(MatteFromPlate(whole, plate), input.shot.camera);
    frame.matte_deviation_px = 1;
  }
  input.shot.frames.push_back(std::move(frame));
  input.pictures.push_back(picture);
}

/// Of mattes that are white where the character is not.
void TurnMattesRound(StageContext& stage, LocateInput& input) {
  stage.Warn(
      "locate: the mattes are white where the character is not, and were turned round: black is "
      "taken for the character");
  for (LocateFrame& frame : input.shot.frames)
    if (!frame.matte.empty()) frame.matte = InvertedMatte(std::move(frame.matte));
}

/// The empty set as a moving camera passed it.
void AddPlates(const Companions& companions, LocateInput& input) {
  if (!companions.plates || companions.plates->single()) return;
  for (const auto& [time, path] : companions.plates->Within(
           input.pictures.front().frame, input.pictures.back().frame, companions.plates_a_frame)) {
    const Image8 plate = ReadImage(path, 1);
    RequireSize(plate, path, input.camera, input.shot.frames[0].name);
    input.shot.plates.push_back({time, Reduced(plate, input.shot.camera)});
  }
}

/// A rate that the user gives wins over the video's own.
void SetRate(StageContext& stage, double given, LocateInput& input) {
  const double own = input.film->fps();
  input.fps = own > 0 ? own : kUsualFps;
  if (given > 0) input.fps = given;
  if (own > 0 && std::abs(input.fps / own - 1) > 1e-3)
    stage.Warn(
        fmt::format("locate: the video has {:g} pictures a second, but they are taken for {:g}; if "
                    "that is not meant, change --fps (in a project `fps` of its shot)",
                    own, input.fps));
}

std::vector<int> FramesOf(const std::vector<std::pair<FilmPicture, int>>& chosen) {
  std::vector<int> frames;
  for (const auto& [picture, mesh] : chosen) frames.push_back(picture.frame);
  return frames;
}

void AddClicks(StageContext& stage, LocateInput& input) {
  if (!stage.Has("clicks")) return;
  const std::vector<FrameClick> clicks =
      ReadClicks(stage.Input("clicks"), input.mesh, input.camera.width, input.camera.height);
  for (const FrameClick& click : clicks) {
    int at = 0;
    while (click.frame >= 0 && at < SizeOf(input.pictures) &&
           input.pictures[at].frame != click.frame)
      ++at;
    if (at == SizeOf(input.pictures))
      throw InputError(fmt::format("locate: {} is on frame {}, of which there is no picture",
                                   click.click.name, click.frame));
    Click reduced = click.click;
    reduced.pixel *= static_cast<double>(input.shot.camera.width) / input.camera.width;
    input.shot.frames[at].clicks.push_back(reduced);
  }
}

/// A film that was keyed has its mattes within.
void NoteAlpha(StageContext& stage, const fs::path& first) {
  if (stage.Has("matte")) return;
  const Image8 alpha = ReadAlpha(first);
  if (std::any_of(alpha.data.begin(), alpha.data.end(), [](int level) { return level < 255; }))
    stage.Note(
        "locate: the film's pictures are transparent in part, as after a key; pass the film as "
        "--matte too, and its alpha tells the outline");
}

void RequireClicksEverywhere(const LocateInput& input) {
  for (const LocateFrame& frame : input.shot.frames)
    if (frame.clicks.size() < 4)
      throw InputError(fmt::format(
          "locate: --quick goes by clicks alone, but {} has {}; click four places in it, or leave "
          "it out of --shows",
          frame.name, frame.clicks.size()));
}

}  // namespace

void ReadLocateInput(StageContext& stage, const LocateStageOptions& options, LocateInput& input) {
  const std::vector<fs::path> files = MeshFiles(stage);
  input.film = std::make_unique<FilmFiles>(stage.Input("plate"), ShowLightOf(stage, options));
  RequireLight(stage, options.plate_colorspace, *input.film);
  for (const std::string& note : input.film->notes()) stage.Note("locate: " + note);
  const std::vector<FilmPicture>& pictures = input.film->pictures();
  SetRate(stage, options.fps, input);
  const std::vector<int> keys =
      stage.Has("frames") ? ReadFrameTimes(stage.Input("frames"), SizeOf(files)).key_frames
                          : std::vector<int>();
  const Shows shows(options, SizeOf(files), keys, pictures);
  std::vector<std::pair<FilmPicture, int>> chosen = shows.Chosen(options.camera == "moving");
  ReadMeshes(files, shows, chosen, input);
  const std::vector<int> frames = FramesOf(chosen);
  input.film->Decode(frames, stage.progress());  // of a video only the pictures that are used
  SetCamera(stage, options, chosen[0].first.path, input);
  NoteAlpha(stage, chosen[0].first.path);
  input.shot.quick = options.quick;
  const Companions companions(stage, options, pictures, frames);
  GivenMattes mattes("locate", "matte");
  for (const auto& [picture, pose] : chosen) AddFrame(picture, pose, companions, mattes, input);
  mattes.Tell(stage);
  if (mattes.AreInverted()) TurnMattesRound(stage, input);
  if (options.camera == "moving") AddPlates(companions, input);
  AddClicks(stage, input);
  if (options.quick) RequireClicksEverywhere(input);
  if (stage.Has("textures") && !options.quick)
    input.texture = ReadImage(FilmPictures(stage.Input("textures"))[0].path, 3);
  input.shot.mesh = &input.mesh;
  if (!input.texture.empty()) input.shot.texture = &input.texture;
  input.shot.solve_k1 = options.distortion;
  input.shot.still = options.camera == "still";
}

}  // namespace keypose::composite
