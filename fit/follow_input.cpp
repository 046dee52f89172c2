#include "fit/follow_input.h"

#include <algorithm>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/frame_folder.h"
#include "core/io/pictures/image_io.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/seams.h"
#include "core/values/errors.h"
#include "core/values/same_faces.h"
#include "core/values/size_of.h"
#include "views/atlas/atlas.h"
#include "views/shot/shot_views.h"

namespace keypose::fit {
namespace {

namespace fs = std::filesystem;

constexpr int kLevels = 2, kCheckedFrames = 3;
// Overlap of mesh and masks below which the mesh is somewhere else.
constexpr double kElsewhere = 0.25;

Image8 AsRgb(const Image8& mask) {
  Image8 rgb(mask.width, mask.height, 3);
  for (std::size_t i = 0; i < mask.data.size(); ++i)
    std::fill_n(rgb.data.begin() + static_cast<std::ptrdiff_t>(3 * i), 3, mask.data[i]);
  return rgb;
}

/// How well the mesh lies in the masks.
struct Places {
  std::vector<double> overlap;  // sums, one a camera
  std::vector<int> frames;      // in which the camera shows the actor
};

}  // namespace

FollowInput::FollowInput(StageContext& stage, const FollowInputOptions& options)
    : max_size_(options.max_size) {
  paths_ = NumberedFrames(stage.Input("frames"), "follow");
  rate_ = FrameRateOf(stage.Input("frames"));
  ReadFirst(stage);
  films_.emplace(stage, FilmsRequest{"follow", "fitted", options.cameras, frames(), true});
  if (rate_ <= 0) rate_ = films_->frames_per_second();
  if (films_->views().size() < 2)
    throw InputError(
        "follow: one camera does not tell depth; at least two are needed, eight are good");
  CheckPlaces();
}

void FollowInput::ReadFirst(StageContext& stage) {
  given_ = ReadMesh(paths_.front());
  RequireUsable(given_, "follow: " + paths_.front().filename().string());
  if (stage.Has("layout")) {
    const Mesh layout = ReadMesh(stage.Input("layout"));
    const std::string name = stage.Input("layout").filename().string();
    if (!SameFaces(layout.faces, given_.faces))
      throw InputError("follow: " + name +
                       " has other faces than the frames; unwrap frame_0000.ply itself");
    given_.uvs = layout.uvs;
    given_.uv_faces = layout.uv_faces;
  }
  CloseSeams();
  if (!stage.Has("texture")) return;
  if (!given_.has_uvs())
    throw InputError(
        "follow: a texture needs texture coordinates, which the frames do not have; pass --layout, "
        "or leave --texture out");
  CheckUvs(given_);
  texture_ = ReadImage(stage.Input("texture"), 3);
}

void FollowInput::CloseSeams() {
  WeldedMesh whole = WeldWholeFaces(given_);
  of_given_ = std::move(whole.of_input);
  kept_.resize(static_cast<std::size_t>(whole.mesh.vertex_count()));
  for (int v = given_.vertex_count() - 1; v >= 0; --v) kept_[of_given_[v]] = v;
  mesh_ = std::move(whole.mesh);
  mesh_.uvs = given_.uvs;
  mesh_.uv_faces = given_.uv_faces;
}

PointsX3 FollowInput::Points(int frame) const {
  if (frame == 0) return mesh_.points;
  const fs::path& path = paths_[frame];
  Mesh mesh = ReadMesh(path);
  if (mesh.points.rows() != given_.points.rows() || !SameFaces(mesh.faces, given_.faces))
    throw InputError("follow: " + path.filename().string() +
                     " does not have the faces of the first frame; all frames must be of one mesh");
  RequireFinite(mesh.points, "follow: " + path.filename().string());
  return mesh.points(kept_, Eigen::all);
}

std::vector<std::vector<PreparedView>> FollowInput::Prepared(int first, int count, bool pictures) {
  const std::vector<View>& views = films_->views();
  const int cameras = SizeOf(views);
  std::vector<FilmedPictures> films;
  for (int i = 0; i < count; ++i)
    films.push_back(pictures ? films_->Read(first + i) : films_->ReadMasks(first + i));
  std::vector<PreparedView> all(static_cast<std::size_t>(count * cameras));
  ParallelFor(SizeOf(all), [&](std::int64_t i) {
    FilmedPictures& film = films[i / cameras];
    const int v = static_cast<int>(i % cameras);
    Image8& mask = film.masks[v];
    if (mask.empty()) return;
    if (!pictures) film.pictures[v] = AsRgb(mask);
    if (film.pictures[v].empty()) return;
    const double side = std::max(mask.width, mask.height);
    all[i] =
        PrepareView(views[v], v, film.pictures[v], mask, std::min(1.0, max_size_ / side), kLevels);
  });
  std::vector<std::vector<PreparedView>> frames(static_cast<std::size_t>(count));
  for (int i = 0; i < SizeOf(all); ++i)
    if (all[i].masked_pixels > 0) frames[i / cameras].push_back(std::move(all[i]));
  return frames;
}

std::vector<std::vector<PreparedView>> FollowInput::Views(int first, int count) {
  return Prepared(first, count, true);
}

std::vector<std::vector<PreparedView>> FollowInput::MaskViews(int first, int count) {
  return Prepared(first, count, false);
}

FollowSource FollowInput::Source() {
  return {frames(), [this](int frame) { return Points(frame); },
          [this](int first, int count) { return Views(first, count); }};
}

void FollowInput::CheckPlaces() {
  const int cameras = SizeOf(films_->views()), count = std::min(kCheckedFrames, frames());
  Places places{std::vector<double>(cameras, 0), std::vector<int>(cameras, 0)};
  for (int i = 0; i < count; ++i) {
    const int f = count == 1 ? 0 : i * (frames() - 1) / (count - 1);
    const PointsX3 points = Points(f);
    const std::vector<PreparedView> views = MaskViews(f, 1)[0];
    for (const PreparedView& view : views) {
      places.overlap[view.scene_index] += MeanOverlap(points, mesh_.faces, {view});
      ++places.frames[view.scene_index];
    }
  }
  std::vector<std::string> off;
  int seen = 0;
  for (int v = 0; v < cameras; ++v) {
    if (places.frames[v] == 0) continue;
    ++seen;
    if (places.overlap[v] < kElsewhere * places.frames[v]) off.push_back(films_->views()[v].name);
  }
  if (seen == 0) throw InputError("follow: the masks of all cameras are empty; look at them");
  if (off.empty()) return;
  if (SizeOf(off) == seen)
    throw InputError(
        "follow: the mesh is not where the films show the actor. Let `transfer` write its frames "
        "with --space template, give the calibration that `track` had, and check that films and "
        "frames begin at one moment");
  throw InputError("follow: camera " + Listed(off) +
                   " shows the actor where the mesh is not. Calibrate it again, check its name and "
                   "its masks, or leave it out with --cameras");
}

}  // namespace keypose::fit
