#include "composite/composing/lessons.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "composite/layer/linear_light.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kNowhere = std::numeric_limits<double>::infinity();

}  // namespace

Character Looks::At(int frame) const {
  Character character{faces, uvs, uv_faces, textures.front()};
  if (weights.empty()) return character;
  const std::vector<double>& shares = weights[frame];
  ParallelBlocks(std::ssize(character.texture.data), 1 << 16,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) {
                     double sum = 0;
                     for (std::size_t k = 0; k < textures.size(); ++k)
                       sum += shares[k] * textures[k].data[i];
                     character.texture.data[i] = static_cast<float>(sum);
                   }
                 });
  return character;
}

ImageF LightIn(const Film& film, ImageF picture) {
  return film.shown ? std::move(picture) : LinearOfLevels(picture);
}

ImageF LevelsIn(const Film& film, ImageF picture) {
  return film.shown ? film.shown(picture) : std::move(picture);
}

CleanPlate PlateOf(const Film& film, const MovingPlate& moving_plate) {
  const ImageF& picture = moving_plate.picture;
  return {LightIn(film, picture),
          ImageF(picture.width, picture.height, 1, moving_plate.grain_lacking), 0, 0, 0};
}

ImageF ShadowPicture(const RayScene& figure, const Ground& table, const ShadowStrength& strength,
                     const SetGeometry* set, const View& view, const PixelRays& rays) {
  const TableShadow shadow(figure, table, strength);
  std::optional<SetShadow> on_set;
  if (set) on_set.emplace(figure, *set, table, strength);
  ImageF kept(view.camera.width, view.camera.height, 1, 1.0f);
  const Rigid3 world_from_camera = view.camera_from_world.Inverse();
  const Eigen::Matrix3d turn = world_from_camera.rotation.toRotationMatrix();
  const Eigen::Vector3d& eye = world_from_camera.translation;
  const double height = (eye - table.origin).dot(table.up);
  ParallelFor(kept.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < kept.width; ++x) {
      const Eigen::Vector3d ray = turn * rays.At(x, y, 0.5, 0.5);
      const double down = -ray.dot(table.up);
      const double to_table = down * height > 0 ? height / down : kNowhere;
      const RayScene::Hit hit = set ? set->scene.Cast(eye, ray, 0, to_table) : RayScene::Hit();
      if (hit.face >= 0)
        *kept.at(x, y) = static_cast<float>(on_set->Kept(eye + hit.distance * ray, hit.face, eye));
      else if (to_table < kNowhere)  // below the horizon
        *kept.at(x, y) = static_cast<float>(shadow.Kept(eye + to_table * ray));
    }
  });
  return kept;
}

PointsX3 GainsAt(const ShotGeometry& geometry, const FilmLessons& lessons, double time,
                 const PointsX3& normals) {
  const std::vector<int>& frames = lessons.light_frames;
  if (frames.empty()) return GainsBetween(lessons.light, -1, -1, 0, normals);
  const auto at = std::lower_bound(frames.begin(), frames.end(), time);
  const int after = std::min(static_cast<int>(at - frames.begin()), SizeOf(frames) - 1);
  const int before = at == frames.begin() || at == frames.end() ? after : after - 1;
  const double share =
      before == after ? 0 : geometry.ShareOfWay(frames[before], frames[after], time);
  return GainsBetween(lessons.light, before, after, share, normals);
}

}  // namespace keypose::composite
