#include "motion/films/video3d_input.h"

#include <algorithm>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"
#include "core/values/percent.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"
#include "motion/video3d/depth_view.h"
#include "views/shot/shot_views.h"

namespace keypose::motion {
namespace {

namespace fs = std::filesystem;

constexpr int kCheckedFrames = 5;
constexpr double kElsewhere = 0.25, kBadlyPlaced = 0.7;  // share of the mesh's pixels in masks

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
  const double ratio = (scaled.Center() - middle).norm() / UpperMedian(std::move(others));
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
    if (checks[v].pixels == 0) {
      blind.push_back(views[v].name);
      one = v;
    }
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

}  // namespace

Video3dInput::Video3dInput(StageContext& stage, const Video3dInputOptions& options) {
  ReadMeshes(stage);
  films_.emplace(stage,
                 FilmsRequest{"video3d", "painted", options.cameras, SizeOf(meshes_), false});
  if (rate_ <= 0) rate_ = films_->frames_per_second();
  up_ = UpOf(options.up, views()).normalized();
  CheckPlaces(stage);
}

void Video3dInput::ReadMeshes(StageContext& stage) {
  const fs::path folder = stage.Input("frames");
  rate_ = FrameRateOf(folder);
  for (const fs::path& path : NumberedFrames(folder, "video3d")) {
    Mesh mesh = ReadMesh(path);
    if (meshes_.empty())
      RequireUsable(mesh, "video3d: " + path.filename().string());
    else if (mesh.points.rows() != meshes_[0].points.rows() ||
             !SameFaces(mesh.faces, meshes_[0].faces))
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
    if (!SameFaces(layout.faces, first.faces) || !layout.has_uvs())
      throw InputError("video3d: " + stage.Input("layout").filename().string() +
                       (layout.has_uvs()
                            ? " has other faces than the frames; unwrap frame_0000.ply "
                              "itself"
                            : " has no texture coordinates; pass the output of "
                              "`keypose unwrap`"));
    first.uvs = layout.uvs;
    first.uv_faces = layout.uv_faces;
  }
  if (!first.has_uvs())
    throw InputError(
        "video3d: the frames have no texture coordinates; make them with `keypose unwrap --clean "
        "frame_0000.ply --unwrapped layout.obj` and pass --layout layout.obj");
  CheckUvs(first);
  for (Mesh& mesh : meshes_) mesh.faces = first.faces;
}

/// Whether each camera has the mesh in its picture, and in its mask.
void Video3dInput::CheckPlaces(StageContext& stage) {
  const int frames = SizeOf(meshes_), count = std::min(kCheckedFrames, frames);
  std::vector<CameraCheck> checks(views().size());
  for (int i = 0; i < count; ++i) {
    const int f = count == 1 ? 0 : i * (frames - 1) / (count - 1);
    const FilmedFrame frame = Read(f);
    ParallelFor(SizeOf(views()), [&](std::int64_t v) {
      checks[v].pixels += PixelsOf(meshes_[f], mesh().faces, views()[v]);
      if (frame.pictures[v].empty() || frame.masks[v].empty()) return;
      const FilmedView view(views()[v], frame.pictures[v], frame.masks[v], frame.points,
                            mesh().faces, {});
      checks[v].covered += view.pixels() * view.covered_by_mask();
      checks[v].masked += view.pixels();
    });
  }
  RequireSeen(mesh(), views(), checks);
  double covered = 0, masked = 0;
  for (std::size_t v = 0; v < views().size(); ++v) {
    const CameraCheck& check = checks[v];
    covered += check.covered;
    masked += check.masked;
    if (check.masked > 0 && check.covered < kBadlyPlaced * check.masked)
      stage.Warn("in camera " + views()[v].name + " only " +
                 PercentHalfUp(check.covered / check.masked) +
                 " of the mesh lie in the masks: look at its masks and calibration");
  }
  if (masked > 0 && covered < kElsewhere * masked)
    throw InputError("video3d: the mesh is not where the films show the actor: only " +
                     PercentHalfUp(covered / masked) +
                     " of its pixels lie in the masks. Let `transfer` write its frames with "
                     "--space template, and check that films and frames begin at one moment");
}

FilmedFrame Video3dInput::Read(int frame) {
  FilmedPictures read = films_->Read(frame);
  return {meshes_[frame].points, std::move(read.pictures), std::move(read.masks)};
}

}  // namespace keypose::motion
