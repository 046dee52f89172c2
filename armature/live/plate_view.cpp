#include "armature/live/plate_view.h"

#include <cmath>

#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

namespace {

constexpr double kGlass = 0.35, kBehindGlass = 0.55, kGhost = 0.35;

/// A mesh drawn alone: its colours with alpha, and how far away it is.
struct Layer {
  Image8 cutout;
  Raster raster;
};

Layer LayerOf(const Mesh& mesh, const View& view, const RenderOptions& options, bool with_depth) {
  const RayScene scene(mesh.points, mesh.faces);
  Layer layer;
  layer.cutout = RenderCutout(mesh, scene, view, options);
  if (with_depth) layer.raster = Rasterize(mesh, scene, view);
  return layer;
}

void Blend(const std::uint8_t* rgba, double share, std::uint8_t* rgb) {
  const double alpha = share * rgba[3] / 255.0;
  for (int c = 0; c < 3; ++c)
    rgb[c] = static_cast<std::uint8_t>(std::lround((1 - alpha) * rgb[c] + alpha * rgba[c]));
}

void BlendAll(const Image8& cutout, double share, Image8& picture) {
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) Blend(cutout.at(x, y), share, picture.at(x, y));
}

/// A backdrop that darkens downwards.
Image8 Backdrop(int width, int height) {
  Image8 picture(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = static_cast<std::uint8_t>(236 - 46 * y / height);
  return picture;
}

Mesh Placed(const Mesh& mesh, const PointsX3& points, const Similarity3& world_from_character) {
  Mesh placed = mesh;
  placed.points = Transformed(world_from_character, points);
  placed.normals.resize(0, 3);
  return placed;
}

/// The set as glass, and the puppet before or behind it.
void DrawWithSet(const PuppetLook& look, const View& view, const Layer& puppet, Image8& picture) {
  RenderOptions options;
  options.samples = 2;
  const Layer set = LayerOf(look.set, view, options, true);
  BlendAll(set.cutout, kGlass, picture);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const bool behind = *set.raster.depth.at(x, y) < *puppet.raster.depth.at(x, y);
      Blend(puppet.cutout.at(x, y), behind ? kBehindGlass : 1, picture.at(x, y));
    }
}

}  // namespace

Image8 DrawPuppet(const PuppetLook& look, const PlateView& where, const PointsX3& points,
                  const std::vector<const PointsX3*>& ghosts) {
  const Camera& camera = where.view.camera;
  const Image8& plate = where.plate;
  if (!plate.empty() &&
      (plate.width != camera.width || plate.height != camera.height || plate.channels != 3))
    throw InputError("armature: the plate has " + std::to_string(plate.width) + " x " +
                     std::to_string(plate.height) + " pixels, but the shot's camera " +
                     std::to_string(camera.width) + " x " + std::to_string(camera.height));
  Image8 picture = plate.empty() ? Backdrop(camera.width, camera.height) : plate;
  RenderOptions options;
  options.samples = 2;
  if (!look.texture.empty()) options.texture = &look.texture;
  RenderOptions plain = options;
  plain.plain = true;
  plain.texture = nullptr;
  for (int g = 0; g < SizeOf(ghosts); ++g) {
    const Mesh ghost = Placed(look.mesh, *ghosts[g], where.world_from_character);
    BlendAll(LayerOf(ghost, where.view, plain, false).cutout, kGhost * (g + 1) / SizeOf(ghosts),
             picture);
  }
  const bool has_set = look.set.face_count() > 0;
  const Layer puppet =
      LayerOf(Placed(look.mesh, points, where.world_from_character), where.view, options, has_set);
  if (has_set)
    DrawWithSet(look, where.view, puppet, picture);
  else
    BlendAll(puppet.cutout, 1, picture);
  return picture;
}

}  // namespace keypose::armature
