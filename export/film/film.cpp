#include "export/film/film.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <future>
#include <iterator>
#include <map>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::exporting {
namespace {

Eigen::Vector3d Up(const FilmOptions& options) {
  return options.z_up ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitY();
}

/// The points of all frames, and points on the table where their shadow is still seen.
PointsX3 PointsToShow(const std::vector<Mesh>& frames, const FilmOptions& options) {
  constexpr int kRound = 32;
  constexpr double kShadowWidth = 1.25;
  Eigen::Index rows = options.shadow ? kRound : 0;
  for (const Mesh& frame : frames) rows += frame.points.rows();
  PointsX3 all(rows, 3);
  rows = 0;
  for (const Mesh& frame : frames) {
    all.middleRows(rows, frame.points.rows()) = frame.points;
    rows += frame.points.rows();
  }
  if (!options.shadow) return all;
  const Ground ground = GroundUnder(frames, Up(options));
  for (int i = 0; i < kRound; ++i) {
    const double angle = 2 * M_PI * i / kRound, radius = kShadowWidth * ground.reach;
    all.row(rows + i) =
        ground.origin + radius * (std::cos(angle) * ground.right + std::sin(angle) * ground.back);
  }
  return all;
}

/// How far a camera without position must move along its axes to see some points: the largest
/// offset of a point from a plane through the origin and parallel to a side of the field of view.
struct FieldOffsets {
  double left = -INFINITY, right = -INFINITY, above = -INFINITY, below = -INFINITY;
};

/// Slopes of the field of view that is to be filled.
Eigen::Vector2d FieldSlopes(const Camera& camera) {
  constexpr double kFilled = 0.9;
  return {kFilled * 0.5 * camera.width / camera.fx, kFilled * 0.5 * camera.height / camera.fy};
}

void Extend(FieldOffsets& offsets, const PointsX3& points, const View& view) {
  const Eigen::Matrix3d rotation = view.camera_from_world.rotation.toRotationMatrix();
  const Eigen::Vector2d slopes = FieldSlopes(view.camera);
  for (Eigen::Index i = 0; i < points.rows(); ++i) {
    const Eigen::Vector3d p = rotation * points.row(i).transpose();
    offsets.right = std::max(offsets.right, p.x() - slopes.x() * p.z());
    offsets.left = std::max(offsets.left, -p.x() - slopes.x() * p.z());
    offsets.below = std::max(offsets.below, p.y() - slopes.y() * p.z());
    offsets.above = std::max(offsets.above, -p.y() - slopes.y() * p.z());
  }
}

/// Moves the view, without turning it, to where its picture is filled best.
void Place(View& view, const FieldOffsets& offsets) {
  const Eigen::Vector2d slopes = FieldSlopes(view.camera);
  Eigen::Vector3d eye_in_camera_axes;
  eye_in_camera_axes << 0.5 * (offsets.right - offsets.left), 0.5 * (offsets.below - offsets.above),
      -0.5 * std::max((offsets.right + offsets.left) / slopes.x(),
                      (offsets.below + offsets.above) / slopes.y());
  view.camera_from_world.translation = -eye_in_camera_axes;
}

/// A camera that looks from this side; its position is not the final one.
View ViewFrom(const PointsX3& points, double azimuth_deg, const FilmOptions& options) {
  return FitView(points, azimuth_deg, options.elevation_deg, options.width, options.height,
                 Up(options), options.fov_deg);
}

/// Sum of the motion across the picture from frame to frame, over vertices that face the camera,
/// weighted by how much they face it.
double MotionSeen(const std::vector<Mesh>& frames, const std::vector<PointsX3>& normals,
                  const Eigen::Matrix3d& camera_from_world) {
  std::vector<double> seen(frames.size(), 0);
  ParallelFor(std::ssize(frames) - 1, [&](std::int64_t i) {
    for (Eigen::Index v = 0; v < frames[i].points.rows(); ++v) {
      const double facing = -(camera_from_world.row(2).dot(normals[i].row(v)));
      if (facing <= 0) continue;
      const Eigen::RowVector3d way = frames[i + 1].points.row(v) - frames[i].points.row(v);
      seen[i] += facing * (camera_from_world.topRows<2>() * way.transpose()).norm();
    }
  });
  double sum = 0;
  for (const double one : seen) sum += one;
  return sum;
}

/// Passes on pictures in their order while the next ones are rendered.
class Taking {
 public:
  explicit Taking(const TakePicture& take) : take_(take) {}
  /// @throws  whatever taking the picture before this one threw
  void Add(const Image8& picture) {
    Finish();
    before_ = std::async(std::launch::async, [this, picture] { take_(picture); });
  }
  /// @throws  whatever taking the last picture threw
  void Finish() {
    if (before_.valid()) before_.get();
  }

 private:
  const TakePicture& take_;
  std::future<void> before_;
};

}  // namespace

std::optional<Eigen::Matrix<std::uint8_t, 3, 1>> FilmColor(const std::string& text) {
  using Color = Eigen::Matrix<std::uint8_t, 3, 1>;
  static const std::map<std::string, Color> kNamed = {{"paper", kFilmBackground},
                                                      {"white", {255, 255, 255}},
                                                      {"grey", {128, 128, 128}},
                                                      {"black", {0, 0, 0}},
                                                      {"green", {0, 177, 64}}};
  if (const auto named = kNamed.find(text); named != kNamed.end()) return named->second;
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  std::uint32_t value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data() + 1, end, value, 16);
  if (parsed.ec != std::errc() || parsed.ptr != end) return std::nullopt;
  return Color(static_cast<std::uint8_t>(value >> 16), static_cast<std::uint8_t>(value >> 8),
               static_cast<std::uint8_t>(value));
}

FilmScene SceneOfFilm(const Scene& scene, const FilmOptions& options) {
  return {scene.frames, scene.texture_pixels, scene.texture_weights, scene.texture_of_frame,
          options.light};
}

double AzimuthOfMotion(const std::vector<Mesh>& frames, const FilmOptions& options) {
  std::vector<PointsX3> normals(frames.size());
  ParallelFor(std::ssize(frames), [&](std::int64_t i) {
    normals[i] = VertexNormals(frames[i].points, frames[0].faces);
  });
  // The first photograph usually shows the character's face, which sfm turns to -y. The film is
  // taken from that half.
  constexpr int kStep = 15, kWidest = 75;
  double best = 20, most = 0;
  for (int turn = -kWidest; turn <= kWidest; turn += kStep) {
    const int azimuth = (turn + 360) % 360;
    const View view = ViewFrom(frames[0].points, azimuth, options);
    const double seen =
        MotionSeen(frames, normals, view.camera_from_world.rotation.toRotationMatrix());
    if (seen > most * (1 + 1e-9)) {
      most = seen;
      best = azimuth;
    }
  }
  return best;
}

View FilmView(const std::vector<Mesh>& frames, const FilmOptions& options) {
  const double azimuth =
      options.azimuth_deg >= 0 ? options.azimuth_deg : AzimuthOfMotion(frames, options);
  const PointsX3 points = PointsToShow(frames, options);
  View view = ViewFrom(points, azimuth, options);
  FieldOffsets offsets;
  Extend(offsets, points, view);
  Place(view, offsets);
  return view;
}

void RenderFilm(const FilmScene& scene, const std::vector<int>& order, const FilmOptions& options,
                const TakePicture& take, Progress* progress) {
  const View view = FilmView(scene.frames, options);
  const Ground ground = GroundUnder(scene.frames, Up(options));
  Image8 picture;
  Taking taking(take);
  for (std::size_t i = 0; i < order.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(order.size()),
                   "rendering the film");
    if (i == 0 || order[i] != order[i - 1])
      picture = RenderPicture(scene, order[i], view, options.shadow ? &ground : nullptr);
    taking.Add(picture);
  }
  taking.Finish();
}

std::vector<View> TurntableViews(const Mesh& frame, const FilmOptions& options, int count) {
  PointsX3 points = PointsToShow({frame}, options);
  // About the axis of the turn, which all cameras then have in the middle of their pictures.
  const Eigen::Vector3d center =
      0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose();
  points.rowwise() -= center.transpose();
  const double start =
      options.azimuth_deg >= 0 ? options.azimuth_deg : AzimuthOfMotion({frame}, options);
  std::vector<View> views;
  FieldOffsets offsets;
  for (int i = 0; i < count; ++i) {
    // The camera goes round clockwise, so the figure seems to turn the other way.
    views.push_back(ViewFrom(points, start - 360.0 * i / count, options));
    Extend(offsets, points, views.back());
  }
  offsets.left = offsets.right = std::max(offsets.left, offsets.right);
  for (View& view : views) {
    Place(view, offsets);
    view.camera_from_world.translation -= view.camera_from_world.rotation * center;
  }
  return views;
}

int TurntablePictures(double fps) {
  return std::max(1, static_cast<int>(std::lround(kTurnSeconds * fps)));
}

void RenderTurntable(const FilmScene& scene, int frame, double fps, const FilmOptions& options,
                     const TakePicture& take, Progress* progress) {
  const Mesh& mesh = scene.frames[frame];
  const Ground ground = GroundUnder({mesh}, Up(options));
  const FramePainter painter(scene, frame, options.shadow ? &ground : nullptr);
  FilmOptions first = options;
  if (first.azimuth_deg < 0) first.azimuth_deg = AzimuthOfMotion(scene.frames, options);
  const std::vector<View> views = TurntableViews(mesh, first, TurntablePictures(fps));
  Taking taking(take);
  for (std::size_t i = 0; i < views.size(); ++i) {
    ReportProgress(progress, static_cast<double>(i) / static_cast<double>(views.size()),
                   "rendering the turntable");
    taking.Add(painter.Picture(views[i]));
  }
  taking.Finish();
}

int FindFrame(const Scene& scene, const std::string& wanted) {
  if (wanted.empty()) return scene.keys.empty() ? 0 : scene.keys[0].frame;
  // A name goes before a number: a pose may be called "2".
  for (const KeyMark& key : scene.keys)
    if (key.pose == wanted) return key.frame;
  const auto& names = scene.frame_names;
  const auto named = std::find(names.begin(), names.end(), wanted);
  if (named != names.end()) return static_cast<int>(named - names.begin());
  int number = -1;
  const char* end = wanted.data() + wanted.size();
  const auto parsed = std::from_chars(wanted.data(), end, number);
  const int count = SizeOf(scene.frames);
  if (parsed.ec == std::errc() && parsed.ptr == end && number >= 0 && number < count) return number;
  std::string keys;
  for (const KeyMark& key : scene.keys) keys += (keys.empty() ? "" : ", ") + key.pose;
  throw UsageError("export: the turntable's frame '" + wanted + "' is neither a number from 0 to " +
                   std::to_string(count - 1) + " nor a key" +
                   (keys.empty() ? "" : " (" + keys + ")") + "; give one of these");
}

}  // namespace keypose::exporting
