#include "composite/composite_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "composite/given_mattes.h"
#include "composite/layer/linear_light.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

/// The size of pictures of scene light is looked at when they are read.
void RequireSize(const fs::path& path, const Camera& camera, const char* what) {
  const ImageInfo info = ReadImageInfo(path);
  if (info.width == camera.width && info.height == camera.height) return;
  throw InputError(fmt::format(
      "composite: {} {} has {} x {} pixels, but the shot was located in pictures of {} x {}; all "
      "pictures of a shot must have one size: scale or crop none of them",
      what, PrintableName(path), info.width, info.height, camera.width, camera.height));
}

void ReadFrames(const fs::path& folder, double fps, CompositeInput* input, Progress* progress) {
  const std::vector<fs::path> paths = NumberedFrames(folder, "composite");
  for (const fs::path& path : paths) {
    ReportProgress(progress, 0.1 * SizeOf(input->frames) / SizeOf(paths), "reading frames");
    input->frames.push_back(ReadMesh(path));
    const Mesh& first = input->frames.front();
    if (!SameFaces(input->frames.back().faces, first.faces) ||
        input->frames.back().points.rows() != first.points.rows())
      throw InputError(
          fmt::format("composite: {} has other faces than the first frame; all frames "
                      "of an animation have one connectivity",
                      PrintableName(path)));
  }
  const FrameTimes times = ReadFrameTimes(folder, SizeOf(paths));
  input->times = {times.fps > 0 ? times.fps : fps, SizeOf(paths), times.key_frames, times.t};
}

/// Weights of the textures at a time between keys, whose textures are these.
std::vector<double> WeightsAt(double t, const std::vector<int>& of_key, int count) {
  std::vector<double> weights(static_cast<std::size_t>(count), 0.0);
  const int last = SizeOf(of_key) - 1, key = std::clamp(static_cast<int>(t), 0, last);
  const double share = std::clamp(t - key, 0.0, 1.0);
  weights[of_key[key]] += 1 - share;
  weights[of_key[std::min(key + 1, last)]] += share;
  return weights;
}

/// One colour all over: the mean of the vertices', or that of clay.
Looks PlainLooks(const Mesh& mesh) {
  Image8 colour(1, 1, 3);
  const Eigen::RowVector3d mean = mesh.colors.rows() > 0
                                      ? mesh.colors.cast<double>().colwise().mean().eval()
                                      : Eigen::RowVector3d(190, 182, 170);
  for (int c = 0; c < 3; ++c) colour.data[c] = static_cast<std::uint8_t>(std::lround(mean[c]));
  Looks looks;
  looks.plain = true;
  looks.faces = mesh.faces;
  looks.uvs = UvsX2::Constant(1, 2, 0.5);
  looks.uv_faces = FacesX3::Zero(mesh.faces.rows(), 3);
  looks.textures.push_back(LinearOf(colour));
  return looks;
}

void ReadLooks(StageContext& stage, CompositeInput* input) {
  const Mesh& first = input->frames.front();
  Looks& looks = input->looks;
  if (!stage.Has("textures")) {
    looks = PlainLooks(first);
    stage.Note("composite: without textures the character has one colour all over");
    return;
  }
  if (!first.has_uvs())
    throw InputError(
        "composite: the frames have no texture coordinates, so the textures cannot be laid on; "
        "make the frames from the unwrapped template, or leave the textures out for a character of "
        "one colour");
  looks.faces = first.faces;
  looks.uvs = first.uvs;
  looks.uv_faces = first.uv_faces;
  const std::vector<fs::path> paths = stage.Inputs("textures");
  std::vector<std::string> contents;
  std::vector<int> of_key;
  for (const fs::path& path : paths) {
    const std::string bytes = ReadFile(path);
    const auto same = std::find(contents.begin(), contents.end(), bytes);
    of_key.push_back(static_cast<int>(same - contents.begin()));
    if (same != contents.end()) continue;
    contents.push_back(bytes);
    looks.textures.push_back(LinearOfLevels(ReadLevels(path)));
    const ImageF &texture = looks.textures.back(), &one = looks.textures.front();
    if (texture.width != one.width || texture.height != one.height)
      throw InputError(
          fmt::format("composite: the texture {} has {} x {} pixels and the first one "
                      "{} x {}; they must be of one size to be mixed",
                      PrintableName(path), texture.width, texture.height, one.width, one.height));
  }
  if (looks.textures.size() < 2) return;
  if (input->times.t.empty() || input->times.key_frames.size() != paths.size()) {
    stage.Warn(
        fmt::format("composite: only the first texture shows: there are {} textures, but the "
                    "frames were made from {} keys; pass one for each key, in their order",
                    paths.size(), input->times.key_frames.size()));
    return;
  }
  for (const double t : input->times.t)
    looks.weights.push_back(WeightsAt(t, of_key, SizeOf(looks.textures)));
}

/// Words where a frame has another number in its name than when it was located: pictures at the
/// film's beginning are missing, or came since.
void WarnOfOtherNumber(StageContext& stage, const ShotFrame& frame, const FilmPicture& picture) {
  const long located = FrameNumberIn(fs::path(frame.picture).stem().string());
  if (located < 0 || located == picture.number || frame.picture == picture.path.filename()) return;
  stage.Warn(fmt::format(
      "composite: frame {} of the shot was located in {}, but frame {} of this film is {}: frames "
      "count from the first picture. If the film was not just renamed, pictures at its beginning "
      "are missing or new, and all in-betweens are at wrong times; locate the shot in this film",
      frame.frame, frame.picture, frame.frame, PrintableName(picture.path.filename())));
}

/// The film's frames must be those in which the shot was located.
void RequireSameFilm(StageContext& stage, const CompositeInput& input, const fs::path& folder) {
  for (const ShotFrame& frame : input.shot.frames) {
    const auto found = std::find_if(input.film.begin(), input.film.end(),
                                    [&](const FilmPicture& p) { return p.frame == frame.frame; });
    if (found == input.film.end())
      throw InputError(
          fmt::format("composite: the shot was located in frame {} ({}), which {} does "
                      "not have; pass the film that it was located in",
                      frame.frame, frame.picture, PrintableName(folder)));
    if (!input.film_files->is_video() && &frame == &input.shot.frames.front())
      WarnOfOtherNumber(stage, frame, *found);
  }
}

/// The share of a picture that is not opaque.
double TransparentShare(const fs::path& path) {
  const Image8 alpha = ReadAlpha(path);
  const auto opaque = std::count(alpha.data.begin(), alpha.data.end(), 255);
  return alpha.empty() ? 0 : 1 - static_cast<double>(opaque) / SizeOf(alpha.data);
}

FilmKind KindOf(const fs::path& path) {
  const StoredLevels stored = StoredLevelsOf(path);
  FilmKind kind{stored.bits > 8 ? 16 : 8, stored.profile};
  if (const std::string ending = LowerExtension(path); ending == ".tif" || ending == ".tiff")
    kind.ending = ending;
  return kind;
}

/// How the film is stored, and words where its pictures do not go together.
void LookAtKind(StageContext& stage, CompositeInput* input) {
  FilmKind& kind = input->kind;
  int deep = 0, keyed = 0;
  double most = 0;
  std::string clearest;
  for (const FilmPicture& picture : input->film) {
    const StoredLevels stored = StoredLevelsOf(picture.path);
    deep += stored.bits > 8;
    const double share = stored.alpha ? TransparentShare(picture.path) : 0;
    keyed += share > 0;
    if (share > most) {
      most = share;
      clearest = PrintableName(picture.path.filename());
    }
  }
  kind = KindOf(input->film.front().path);
  kind.bits = deep > 0 ? 16 : 8;
  kind.keyed = keyed > 0;
  if (deep > 0 && deep < SizeOf(input->film))
    stage.Warn(fmt::format(
        "composite: {} of {} filmed frames have more than 8 bits, the others 8; what is rendered "
        "has 16, and filmed frames stay as they are",
        deep, input->film.size()));
  if (kind.keyed)
    stage.Warn(fmt::format(
        "composite: {} of {} filmed frames are transparent in part (at most {:.0f} %, {}), as "
        "after a key; colours are read as stored, not multiplied by alpha, and in-betweens are as "
        "transparent where the set is{}. If the set was filmed too, pass the frames before keying: "
        "in-betweens with alpha lie in layers/ in any case",
        keyed, input->film.size(), 100 * most, clearest,
        input->shot.still ? "" : " (not of a moving camera, whose in-betweens are opaque)"));
}

/// A number that is missing where the others follow each other is a picture that was lost.
void WarnOfGaps(StageContext& stage, const std::vector<FilmPicture>& film) {
  std::vector<int> steps;
  for (int i = 1; i < SizeOf(film); ++i) steps.push_back(film[i].frame - film[i - 1].frame);
  if (steps.empty()) return;
  const int usual = *std::min_element(steps.begin(), steps.end());
  const auto even = std::count(steps.begin(), steps.end(), usual);
  if (even == std::ssize(steps) || 2 * even <= std::ssize(steps)) return;
  int lost = 0;
  std::string where;
  for (int i = 1; i < SizeOf(film); ++i) {
    if (steps[i - 1] == usual) continue;
    if (lost == 0) where = PrintableName(film[i - 1].path.filename());
    lost += (steps[i - 1] - 1) / usual;
  }
  stage.Warn(fmt::format(
      "composite: {} of the film's numbers have no picture (first after {}); what the animation "
      "reaches is rendered in their place, elsewhere the frame before stands: look whether they "
      "were lost",
      lost, where));
}

/// In-betweens have the plate's alpha only where each has a plate of its own.
void RequireOpaque(const CompositeInput& input) {
  for (const FilmPicture& picture : input.film) {
    const ImageF alpha = input.scene->Alpha(picture.path);
    if (std::any_of(alpha.data.begin(), alpha.data.end(), [](float a) { return a < 1; }))
      throw InputError(fmt::format(
          "composite: the filmed frame {} is transparent in part, as after a key; pass the frames "
          "before keying: in-betweens have the character alone in their layers",
          PrintableName(picture.path)));
  }
}

void ReadFilm(StageContext& stage, const fs::path& path, std::unique_ptr<FilmFiles> files,
              CompositeInput* input) {
  input->film_files = std::move(files);
  for (const std::string& note : input->film_files->notes()) stage.Note("composite: " + note);
  input->film_files->DecodeAll(stage.progress());
  input->film = input->film_files->pictures();
  for (const FilmPicture& picture : input->film)
    if (!input->scene) RequireSize(picture.path, input->shot.camera, "the filmed frame");
  RequireSameFilm(stage, *input, path);
  input->scene ? RequireOpaque(*input) : LookAtKind(stage, input);
  if (input->film_stays) WarnOfGaps(stage, input->film);
}

/// A plate of less depth than the film's is seen in every in-between.
void WarnOfShallowPlate(StageContext& stage, const CompositeInput& input, const fs::path& plate) {
  if (input.scene || input.film.empty() || input.kind.bits == 8 || StoredLevelsOf(plate).bits > 8)
    return;
  stage.Warn(fmt::format(
      "composite: the film has 16 bits, but the plate {} has 8, and its steps are in the "
      "in-betweens; pass a plate that was developed as the film was",
      PrintableName(plate.filename())));
}

/// Several pictures are the film itself, from which the plate is made, unless there is a film
/// beside them.
bool IsFilm(StageContext& stage, const FilmFiles& plate) {
  if (plate.pictures().size() < 2) return false;
  return !stage.Has("filmed") || fs::equivalent(stage.Input("filmed"), stage.Input("plate"));
}

/// The filmed frames of a shot whose camera moves; its plates are read when the plan is made.
void ReadMovingFilm(StageContext& stage, CompositeInput* input) {
  if (!stage.Has("filmed"))
    throw InputError(
        "composite: the camera of this shot moves; pass its filmed frames (--filmed), and as "
        "--plate a film of the empty set with the same move");
  const fs::path film = stage.Input("filmed");
  if (fs::equivalent(film, stage.Input("plate")))
    throw InputError(
        "composite: the camera of this shot moves, so its plate cannot be made from its own "
        "frames; pass as plate (`plate` of the project's shot) a film of the empty set with the "
        "same move: one numbered plate for each filmed frame, or one for each picture of the "
        "finished shot");
  input->film_stays = true;
  ReadFilm(stage, film, std::make_unique<FilmFiles>(film), input);
}

/// A person's colours, and the window of the pictures; nothing where they are no scene light.
void LookAtScene(StageContext& stage, const std::string& colorspace, CompositeInput* input) {
  const std::vector<FilmPicture> plate = LightPictures(stage.Input("plate")),
                                 film = stage.Has("filmed") ? LightPictures(stage.Input("filmed"))
                                                            : plate;
  if (film.empty() != plate.empty())
    throw InputError(
        "composite: one of plate and film is OpenEXR or DPX, and the other is not; pass both as "
        "the camera's light (OpenEXR, DPX), or both as they should look (PNG, TIFF, video)");
  if (plate.empty()) {
    if (colorspace.empty() && !stage.Has("ocio_config")) return;
    throw UsageError(
        "composite: plate_colorspace and ocio_config are for OpenEXR and DPX plates; pictures of "
        "other kinds are sRGB");
  }
  const StatedColors stated{colorspace,
                            stage.Has("ocio_config") ? stage.Input("ocio_config") : fs::path()};
  const fs::path& first = plate.front().path;
  input->scene = std::make_unique<ScenePlates>(stated, first);
  input->shot.camera = input->scene->OfWindow(input->shot.camera);
  input->kind.bits = input->scene->single() ? 32 : 16;
  input->kind.ending = ".exr";
  stage.Note(fmt::format("composite: {} is read as {}", PrintableName(first.filename()),
                         input->scene->colors().meaning()));
  if (const std::string& doubt = input->scene->colors().doubt(); !doubt.empty())
    stage.Warn("composite: " + doubt);
  if (input->scene->others() > 0)
    stage.Note(fmt::format("composite: {} channels of {} are no colours, and are left out",
                           input->scene->others(), PrintableName(first.filename())));
  // Textures are sRGB; all light of the shot is of the plate's primaries.
  if (stage.Has("filmed")) input->scene->ExposeFor(film.front().path);
  for (ImageF& texture : input->looks.textures) {
    input->scene->colors().TakeFromRec709(&texture);
    for (float& value : texture.data) value *= input->scene->exposure();
  }
}

/// One plate for each picture of the finished shot, where nothing was filmed.
bool IsSequence(StageContext& stage, const CompositeInput& input) {
  return input.scene && !stage.Has("filmed") && fs::is_directory(stage.Input("plate")) &&
         LightPictures(stage.Input("plate")).size() > 1;
}

ImageF ReadPicture(const CompositeInput& input, const fs::path& path) {
  return input.scene ? input.scene->Light(path) : ReadLevels(path);
}

void ReadPlate(StageContext& stage, CompositeInput* input) {
  const fs::path plate = stage.Input("plate");
  auto plate_files = std::make_unique<FilmFiles>(plate);
  const bool is_film = IsFilm(stage, *plate_files);
  input->film_stays = stage.Has("filmed");
  const fs::path folder = input->film_stays ? stage.Input("filmed") : plate;
  if (input->film_stays || is_film) {
    ReadFilm(stage, folder,
             folder == plate ? std::move(plate_files) : std::make_unique<FilmFiles>(folder), input);
  }
  if (!is_film) {
    plate_files->Decode({0}, stage.progress());
    const fs::path path = plate_files->pictures().front().path;
    if (plate_files->pictures().size() > 1)
      stage.Note(
          fmt::format("composite: of {} plates the first one, {}, is taken: the camera stands",
                      plate_files->pictures().size(), PrintableName(path)));
    if (!input->scene) RequireSize(path, input->shot.camera, "the plate");
    input->given_plate = ReadPicture(*input, path);
    input->given_plate_file = path;
    WarnOfShallowPlate(stage, *input, path);
    if (input->film.empty() && !input->scene) {
      input->kind = KindOf(path);
      input->kind.ending = ".png";
    }
  }
}

void ReadSet(const fs::path& path, CompositeInput* input) {
  const Mesh set = ReadMesh(path);
  if (set.face_count() == 0)
    throw InputError(fmt::format("composite: the set {} has no faces", PrintableName(path)));
  if (!set.points.allFinite())
    throw InputError(
        fmt::format("composite: the set {} has a vertex that is not finite", PrintableName(path)));
  input->set = std::make_shared<SetGeometry>(set);
}

/// 0 to 1; 1 all over where there is none.
ImageF AlphaOf(const fs::path& path) {
  const Image8 stored = ReadAlpha(path);
  if (stored.empty()) {
    const ImageInfo info = ReadImageInfo(path);
    return ImageF(info.width, info.height, 1, 1.0f);
  }
  ImageF alpha(stored.width, stored.height, 1);
  std::transform(stored.data.begin(), stored.data.end(), alpha.data.begin(),
                 [](std::uint8_t level) { return static_cast<float>(level) / 255; });
  return alpha;
}

/// White is what is in front of the character.
/// @param camera  of the pictures that were filmed
Image8 ReadHoldout(StageContext& stage, const CompositeInput& input, const Camera& camera) {
  GivenMattes holdout("composite", "holdout");
  MattePlace place{camera.width, camera.height, 1, "the shot"};
  if (!input.scene && !input.film.empty() && fs::exists(input.film.front().path))
    place.orientation = ReadImageInfo(input.film.front().path).orientation;
  Image8 matte = holdout.Read(stage.Input("holdout"), place);
  holdout.Tell(stage);
  if (holdout.AreEmpty())
    stage.Warn(
        "composite: the holdout is black all over, so it hides nothing of the character; "
        "paint white what is in front of it");
  if (holdout.AreInverted())
    stage.Warn(
        "composite: the holdout is white along the whole border of the picture: it hides the "
        "character there; if it is meant the other way round, invert it: white is what is "
        "in front of the character");
  return matte;
}

std::string Digits(int frames) { return fmt::format("{} frame{}", frames, frames == 1 ? "" : "s"); }

}  // namespace

CompositeInput ReadCompositeInput(StageContext& stage, double fps,
                                  const std::string& plate_colorspace) {
  CompositeInput input;
  input.shot = ReadShot(stage.Input("shot"));
  const Camera located = input.shot.camera;
  ReadFrames(stage.Input("frames"), fps, &input, stage.progress());
  ReadLooks(stage, &input);
  LookAtScene(stage, plate_colorspace, &input);
  const bool sequence = IsSequence(stage, input);
  if (!sequence) input.shot.still ? ReadPlate(stage, &input) : ReadMovingFilm(stage, &input);
  if (stage.Has("holdout")) {
    input.holdout = ReadHoldout(stage, input, located);
    if (input.scene) input.holdout = InWindow(input.holdout, input.scene->window());
    if (!input.shot.still)
      stage.Warn(
          "composite: the camera of this shot moves, but the holdout is one picture, which stays "
          "where it is while the props pass; give them as a mesh instead (--set)");
  }
  if (stage.Has("set")) ReadSet(stage.Input("set"), &input);
  std::vector<int> numbers;
  if (input.film_stays)
    for (const FilmPicture& picture : input.film) numbers.push_back(picture.frame);
  input.plan = PlanFilm(input.shot, numbers, input.times);
  if (sequence) {
    input.sequence = std::make_unique<SceneSequence>(stage.Input("plate"), *input.scene, input.shot,
                                                     input.plan, SizeOf(input.frames));
    input.first_number = input.sequence->first_number();
  } else if (input.scene && !input.film.empty()) {
    input.first_number = input.film.front().number;
  }
  if (!input.shot.still && !sequence)
    input.moving_plates =
        std::make_unique<MovingPlates>(stage.Input("plate"), input.plan, numbers, input.shot.camera,
                                       input.scene.get(), stage.progress());
  if (input.moving_plates) WarnOfShallowPlate(stage, input, input.moving_plates->first());
  stage.Note(fmt::format("composite: {} filmed, {} rendered, {} held", Digits(input.plan.filmed),
                         input.plan.between, input.plan.held));
  return input;
}

Film FilmOf(const CompositeInput& input, const ShotGeometry& geometry) {
  Film film;
  film.given_plate = input.given_plate;
  film.holdout = input.holdout;
  film.set = input.set;
  if (input.moving_plates)
    film.plate_at = [plates = input.moving_plates.get()](int animation) {
      return plates->At(animation);
    };
  if (input.sequence)
    film.plate_at = [plates = input.sequence.get()](int animation) {
      return MovingPlate{plates->At(animation)};
    };
  if (input.scene)
    film.shown = [scene = input.scene.get()](const ImageF& light) { return scene->Shown(light); };
  film.read = [&input](int i) { return ReadPicture(input, input.film[i].path); };
  if (input.kind.keyed) film.alpha = [&input](int i) { return AlphaOf(input.film[i].path); };
  for (int i = 0; i < SizeOf(input.film); ++i) {
    FilmedPicture picture{i, 0, -1};
    const int shown = (input.film[i].frame - input.plan.first_frame) * input.plan.per_frame;
    picture.shows = shown >= 0 && shown < SizeOf(input.frames);
    picture.animation = std::clamp(shown, 0, SizeOf(input.frames) - 1);
    for (int a = 0; a < SizeOf(geometry.anchors()); ++a) {
      const ShotFrame& located = input.shot.frames[geometry.anchors()[a].shot_frame];
      if (located.frame != input.film[i].frame) continue;
      picture.anchor = a;
      picture.keyed = !located.pose.empty();
    }
    film.pictures.push_back(picture);
  }
  return film;
}

}  // namespace keypose::composite
