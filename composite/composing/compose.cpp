#include "composite/composing/compose.h"

#include <algorithm>
#include <cmath>

#include "composite/layer/depth_layer.h"
#include "composite/layer/linear_light.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr int kShutterMoments = 8;    // shapes that a blurred picture is the mean of
constexpr float kLeastAlpha = 1e-4f;  // below it a keyed pixel has no colour

/// The character over the time that the shutter is open.
ImageF LayerOver(const ShotGeometry& geometry, const Looks& looks, const FilmLessons& lessons,
                 double time, const ComposeOptions& options, const PixelRays& rays,
                 const RayScene* props) {
  const Camera camera = geometry.ViewAt(time).camera;
  const Character character = looks.At(static_cast<int>(std::lround(time)));
  const int moments = options.shutter_deg > 0 ? kShutterMoments : 1;
  // So many rays altogether as without blur, but four a pixel at least in each moment.
  const int along = moments > 1 ? std::max(2, options.along / 2) : options.along;
  const Ground table = geometry.Table();
  ImageF mean(camera.width, camera.height, 4);
  for (int i = 0; i < moments; ++i) {
    const double open = options.shutter_deg / 360 * ((i + 0.5) / moments - 0.5);
    const PointsX3 points = geometry.Points(time + open);
    const RayScene scene(points, looks.faces);
    const PointsX3 gains =
        GainsAt(geometry, lessons, time + open, VertexNormals(points, looks.faces));
    const ImageF layer = RenderLayer(character, points, scene, gains, geometry.ViewAt(time + open),
                                     rays, along, &table, props);
    for (std::size_t k = 0; k < mean.data.size(); ++k)
      mean.data[k] += layer.data[k] / static_cast<float>(moments);
  }
  return Blurred(mean, lessons.blur_px);
}

}  // namespace

ComposedPicture Compose(const ShotGeometry& geometry, const Looks& looks, const Film& film,
                        const FilmLessons& lessons, double time, const Eigen::Vector3d& exposure,
                        const ComposeOptions& options, std::uint64_t grain_seed) {
  const View view = geometry.ViewAt(time);
  const PixelRays rays(view.camera);
  ComposedPicture composed;
  if (film.plate_at) composed.moving_plate = film.plate_at(static_cast<int>(std::lround(time)));
  const CleanPlate moving_plate =
      film.plate_at ? PlateOf(film, composed.moving_plate) : CleanPlate();
  const CleanPlate& plate = film.plate_at ? moving_plate : lessons.plate;
  composed.layer = LayerOver(geometry, looks, lessons, time, options, rays, film.props());
  ImageF kept;
  const ShadowStrength& strength = lessons.shadow.strength;
  if (options.shadow && (strength.sky > 0 || strength.lamp > 0)) {
    const Ground table = geometry.Table();
    const RayScene scene(geometry.Points(time), looks.faces);
    kept = ShadowPicture(scene, table, strength, film.set.get(), view, rays);
  }
  const int width = view.camera.width, height = view.camera.height;
  composed.light = ImageF(width, height, 3);
  composed.coverage = ImageF(width, height, 1);
  if (film.shown) {
    composed.shadow = ImageF(width, height, 1);
    composed.depth = DepthLayer(geometry.Points(time), looks.faces, view, rays, options.along,
                                geometry.Table(), film.props());
  }
  const bool keyed = !lessons.plate_alpha.empty();
  if (keyed) composed.alpha = ImageF(width, height, 1);
  ImageF lacking(width, height, 1);
  const auto pixel = [&](int x, int y) {
    const float shown =
        film.holdout.empty() ? 1.0f : 1 - static_cast<float>(*film.holdout.at(x, y)) / 255;
    float* over = composed.layer.at(x, y);
    for (int c = 0; c < 4; ++c) over[c] *= shown;
    const float alpha = over[3], left = kept.empty() ? 1.0f : 1 - shown * (1 - *kept.at(x, y));
    *composed.coverage.at(x, y) = alpha;
    if (film.shown) *composed.shadow.at(x, y) = 1 - left;
    *lacking.at(x, y) = alpha + (1 - alpha) * *plate.grain_lacking.at(x, y);
    // A shadow darkens the set, and is gone where the set was keyed out.
    const float set = keyed ? *lessons.plate_alpha.at(x, y) : 1.0f,
                all = keyed ? alpha + (1 - alpha) * set : 1.0f;
    if (keyed) *composed.alpha.at(x, y) = all;
    for (int c = 0; c < 3; ++c) {
      const float behind = plate.light.at(x, y)[c] * left * set;
      const float factor = static_cast<float>(exposure[c]) / std::max(all, kLeastAlpha);
      // A plate's highlight may be infinite.
      const float through = alpha < 1 && left > 0 ? (1 - alpha) * behind : 0;
      composed.light.at(x, y)[c] = factor * (over[c] + through);
      over[c] *= static_cast<float>(exposure[c]);
    }
    over[3] = 1 - (1 - alpha) * left;  // the shadow is black, and lies behind the character
  };
  ParallelFor(height, [&](std::int64_t y) {
    for (int x = 0; x < width; ++x) pixel(x, static_cast<int>(y));
  });
  const Grain grain = options.grain && lessons.grain ? *lessons.grain : Grain();
  if (film.shown) {
    composed.light = LightWithGrain(composed.light, grain, lacking, grain_seed);
    composed.picture = film.shown(composed.light);
    return composed;
  }
  const ImageF levels = LevelsOf(composed.light);
  composed.picture = WithGrain(levels, grain, lacking, grain_seed);
  return composed;
}

}  // namespace keypose::composite
