#include "motion/films/video3d_input.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/frame_folder.h"
#include "core/io/mesh_io.h"
#include "core/io/rig_calibration.h"
#include "core/mesh_checks.h"
#include "core/parallel.h"
#include "core/size_of.h"
#include "motion/video3d/depth_view.h"
#include "views/shot/rig.h"

namespace keypose::motion {
namespace {

namespace fs = std::filesystem;

constexpr int kCheckedFrames = 5;
constexpr double kElsewhere = 0.25, kBadlyPlaced = 0.7;  // share of the mesh's pixels in masks

std::vector<std::string> Words(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, ',');) {
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    if (!word.empty()) words.push_back(word);
  }
  return words;
}

std::string Percent(double share) {
  return std::to_string(static_cast<int>(std::lround(100 * share))) + " %";
}

/// Pixels of the camera that the mesh covers.
int PixelsOf(const Mesh& mesh, const FacesX3& faces, const View& view) {
  const DepthView depth = MakeDepthView(mesh.points, faces, view);
  return static_cast<int>(std::count_if(depth.inverse.data.begin(), depth.inverse.data.end(),
                                        [](float z) { return z > 0; }));
}

View PlacedAtScale(View view, double factor) {
  view.camera_from_world.translation *= factor;
  return view;
}

/// Whether the camera, with its place scaled, sees the mesh from about as far as the others do.
bool FitsScaled(const Mesh& mesh, const std::vector<View>& views, std::size_t one, double factor) {
  const Eigen::Vector3d middle = mesh.points.colwise().mean();
  const View scaled = PlacedAtScale(views[one], factor);
  std::vector<double> others;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (v != one) others.push_back((views[v].Center() - middle).norm());
  if (others.empty()) return false;
  std::nth_element(others.begin(), others.begin() + SizeOf(others) / 2, others.end());
  const double ratio = (scaled.Center() - middle).norm() / others[others.size() / 2];
  return ratio > 1.0 / 3 && ratio < 3 && PixelsOf(mesh, mesh.faces, scaled) > 0;
}

/// What a camera shows of the mesh, over some frames.
struct CameraCheck {
  int pixels = 0;                  ///< that the mesh covers
  double covered = 0, masked = 0;  ///< of those in frames with masks: in the mask, and all
};

/// @throws InputError  a camera that never has the mesh in its picture
void RequireSeen(const Mesh& mesh, const std::vector<View>& views,
                 const std::vector<CameraCheck>& checks) {
  std::vector<std::string> blind;
  std::size_t one = 0;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (checks[v].pixels == 0) blind.push_back(views[v].name), one = v;
  if (blind.empty()) return;
  const bool many = blind.size() > 1;
  std::string text = "video3d: " + std::string(many ? "cameras " : "camera ") + Listed(blind) +
                     (many ? " do" : " does") + " not see the moving mesh at all. ";
  if (FitsScaled(mesh, views, one, 0.001))
    text += "Its place looks like millimetres among metres: divide its translation by 1000";
  else if (FitsScaled(mesh, views, one, 1000))
    text += "Its place looks like metres among millimetres: multiply its translation by 1000";
  else if (blind.size() == views.size())
    text +=
        "Frames and calibration must be in one space: let `transfer` write its frames with "
        "--space template, or give the calibration that `track` had";
  else
    text += "Calibrate it again, check its name, or leave it out with --cameras";
  throw InputError(text);
}

/// Takes the shot's cameras of these names, all where none are given.
std::vector<ShotCamera> Chosen(const Shot& shot, const std::string& names) {
  const std::vector<std::string> wanted = Words(names), known = shot.names();
  for (const std::string& name : wanted)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError("video3d: --cameras names " + name + ", but the shot has " + Listed(known));
  std::vector<ShotCamera> chosen;
  for (const ShotCamera& camera : shot.cameras)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), camera.name) != wanted.end())
      chosen.push_back(camera);
  return chosen;
}

}  // namespace

Video3dInput::~Video3dInput() = default;

Video3dInput::Video3dInput(StageContext& stage, const Video3dInputOptions& options) {
  ReadMeshes(stage);
  OpenFilms(stage, options);
  ReadClocks(stage);
  CheckLengths(stage);
  CheckSizes();
  up_ = UpOf(options.up, views_).normalized();
  CheckPlaces(stage);
}

void Video3dInput::ReadMeshes(StageContext& stage) {
  const fs::path folder = stage.Input("frames");
  rate_ = FrameRateOf(folder);
  for (const fs::path& path : NumberedFrames(folder, "video3d")) {
    Mesh mesh = ReadMesh(path);
    if (meshes_.empty())
      RequireUsable(mesh, "video3d: " + path.filename().string());
    else if (mesh.points.rows() != meshes_[0].points.rows() || mesh.faces != meshes_[0].faces)
      throw InputError("video3d: " + path.filename().string() +
                       " does not have the faces of the first frame; all frames must be of one "
                       "mesh");
    RequireFinite(mesh.points, "video3d: " + path.filename().string());
    if (!meshes_.empty()) mesh = Mesh{std::move(mesh.points), {}, {}, {}, {}, {}};
    meshes_.push_back(std::move(mesh));
  }
  Mesh& first = meshes_.front();
  if (stage.Has("layout")) {
    const Mesh layout = ReadMesh(stage.Input("layout"));
    if (layout.faces != first.faces || !layout.has_uvs())
      throw InputError("video3d: " + stage.Input("layout").filename().string() +
                       (layout.has_uvs()
                            ? " has other faces than the frames; unwrap frame_0000.ply "
                              "itself"
                            : " has no texture coordinates; pass the output of "
                              "`keypose unwrap`"));
    first.uvs = layout.uvs, first.uv_faces = layout.uv_faces;
  }
  if (!first.has_uvs())
    throw InputError(
        "video3d: the frames have no texture coordinates; make them with `keypose unwrap --clean "
        "frame_0000.ply --unwrapped layout.obj` and pass --layout layout.obj");
  CheckUvs(first);
  for (Mesh& mesh : meshes_) mesh.faces = first.faces;
}

void Video3dInput::OpenFilms(StageContext& stage, const Video3dInputOptions& options) {
  const Shot shot = OpenShot(stage.Input("video"));
  if (rate_ <= 0) rate_ = shot.frames_per_second;
  std::vector<std::string> names;
  for (const ShotCamera& camera : Chosen(shot, options.cameras)) {
    if (camera.pictures.empty())
      throw InputError("video3d: camera " + camera.name +
                       " has masks but no film; pass the folder with the films as --video and the "
                       "masks as --masks");
    films_.emplace_back();
    films_.back().files = camera;
    names.push_back(camera.name);
  }
  if (stage.Has("masks")) {
    const Shot masks = OpenShot(stage.Input("masks"));
    for (CameraFilm& film : films_)
      for (const ShotCamera& camera : masks.cameras)
        if (camera.name == film.files.name && !camera.masks.empty())
          film.files.masks = camera.masks;
  }
  const RigCalibration rig = ReadRigCalibration(stage.Input("calibration"));
  for (const std::string& note : rig.notes) stage.Note(note);
  views_ = MatchedViews(rig, names, "video3d");
  for (CameraFilm& film : films_) {
    film.pictures = std::make_unique<FrameReader>(film.files.pictures);
    if (!film.files.masks.empty()) film.masks = std::make_unique<FrameReader>(film.files.masks);
  }
}

void Video3dInput::ReadClocks(StageContext& stage) {
  if (!stage.Has("clocks")) return;
  const std::string name = stage.Input("clocks").filename().string();
  const nlohmann::json root =
      nlohmann::json::parse(ReadFile(stage.Input("clocks")), nullptr, false);
  if (!root.is_object() || !root.contains("offsets") || !root["offsets"].is_object())
    throw InputError("video3d: " + name + " is not JSON with an object `offsets`");
  for (CameraFilm& film : films_) {
    if (!root["offsets"].contains(film.files.name)) continue;
    const nlohmann::json& offset = root["offsets"][film.files.name];
    if (!offset.is_number_integer())
      throw InputError("video3d: " + name + ": the offset of " + film.files.name +
                       " is not a whole number of frames");
    film.offset = offset;
  }
}

void Video3dInput::CheckLengths(StageContext& stage) {
  const int frames = SizeOf(meshes_);
  std::vector<std::string> some;
  int longest = 0;
  for (const CameraFilm& film : films_) {
    const int count = std::clamp(film.files.frames() - film.offset, 0, frames);
    longest = std::max(longest, count);
    if (count < frames)
      some.push_back(film.files.name + " (" + std::to_string(count) + " of " +
                     std::to_string(frames) + ")");
  }
  if (longest == 0)
    throw InputError(
        "video3d: no film has a frame of this motion; the offsets of the clocks are "
        "beyond the films' ends");
  if (some.empty()) return;
  stage.Warn("films end before the motion does: " + Listed(some) +
             "; later frames are painted from the other cameras" +
             (longest < frames ? ", and those after all films' ends from the frames before" : "") +
             "; copy the films again");
}

void Video3dInput::CheckSizes() {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const int first = std::clamp(films_[v].offset, 0, films_[v].files.frames() - 1);
    const Image8 picture = films_[v].pictures->Read(first, 3);
    views_[v].camera = CameraForPictures(views_[v].camera, picture.width, picture.height,
                                         views_[v].name, "video3d");
    if (!films_[v].masks) continue;
    const Image8 mask = films_[v].masks->Read(first, 1);
    if (mask.width != picture.width || mask.height != picture.height)
      throw InputError("video3d: the masks of camera " + views_[v].name + " have " +
                       std::to_string(mask.width) + " x " + std::to_string(mask.height) +
                       " pixels, but its pictures " + std::to_string(picture.width) + " x " +
                       std::to_string(picture.height));
  }
}

/// Whether each camera has the mesh in its picture, and in its mask.
void Video3dInput::CheckPlaces(StageContext& stage) {
  const int frames = SizeOf(meshes_), count = std::min(kCheckedFrames, frames);
  std::vector<CameraCheck> checks(views_.size());
  for (int i = 0; i < count; ++i) {
    const int f = count == 1 ? 0 : i * (frames - 1) / (count - 1);
    const FilmedFrame frame = Read(f);
    ParallelFor(SizeOf(views_), [&](std::int64_t v) {
      checks[v].pixels += PixelsOf(meshes_[f], mesh().faces, views_[v]);
      if (frame.pictures[v].empty() || frame.masks[v].empty()) return;
      const FilmedView view(views_[v], frame.pictures[v], frame.masks[v], frame.points,
                            mesh().faces, {});
      checks[v].covered += view.pixels() * view.covered_by_mask();
      checks[v].masked += view.pixels();
    });
  }
  RequireSeen(mesh(), views_, checks);
  double covered = 0, masked = 0;
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const CameraCheck& check = checks[v];
    covered += check.covered, masked += check.masked;
    if (check.masked > 0 && check.covered < kBadlyPlaced * check.masked)
      stage.Warn("in camera " + views_[v].name + " only " + Percent(check.covered / check.masked) +
                 " of the mesh lie in the masks: look at its masks and calibration");
  }
  if (masked > 0 && covered < kElsewhere * masked)
    throw InputError("video3d: the mesh is not where the films show the actor: only " +
                     Percent(covered / masked) +
                     " of its pixels lie in the masks. Let `transfer` write its frames with "
                     "--space template, and check that films and frames begin at one moment");
}

FilmedFrame Video3dInput::Read(int frame) {
  FilmedFrame read;
  read.points = meshes_[frame].points;
  read.pictures.resize(films_.size()), read.masks.resize(films_.size());
  ParallelFor(SizeOf(films_), [&](std::int64_t v) {
    CameraFilm& film = films_[v];
    const int at = frame + film.offset;
    if (at < 0 || at >= film.files.pictures.frames) return;
    read.pictures[v] = film.pictures->Read(at, 3);
    if (film.masks && at < film.files.masks.frames) read.masks[v] = film.masks->Read(at, 1);
  });
  return read;
}

}  // namespace keypose::motion
