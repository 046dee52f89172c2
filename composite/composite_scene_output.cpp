#include "composite/composite_scene_output.h"

#include "composite/scene/layered_exr.h"

namespace keypose::composite {
namespace {

/// Of the plate that lies behind a picture; empty: opaque.
ImageF PlateAlpha(const CompositeInput& input, int animation) {
  if (input.sequence) return input.scene->Alpha(input.sequence->FileAt(animation));
  // A film is opaque, and so is what it shows of the set.
  const bool given = input.film.empty() && !input.given_plate_file.empty();
  return given ? input.scene->Alpha(input.given_plate_file) : ImageF();
}

/// The character over the plate; a shadow darkens the plate and does not cover what it left out.
ImageF AlphaOver(ImageF plate, const ImageF& coverage) {
  for (std::size_t i = 0; i < plate.data.size(); ++i) {
    const float alpha = coverage.data[i];
    plate.data[i] = alpha + (1 - alpha) * plate.data[i];
  }
  return plate;
}

}  // namespace

void WriteScenePicture(const std::filesystem::path& path, const CompositeInput& input,
                       const ComposedPicture& composed, int animation) {
  SceneLayers layers;
  layers.light = composed.light;
  layers.alpha = AlphaOver(PlateAlpha(input, animation), composed.coverage);
  layers.character = composed.layer;
  for (std::size_t i = 0; i < composed.coverage.data.size(); ++i)
    layers.character.data[4 * i + 3] = composed.coverage.data[i];
  layers.shadow = composed.shadow;
  layers.depth = composed.depth;
  WriteLayers(path, layers, *input.scene);
}

void WriteScenePlate(const std::filesystem::path& path, const CompositeInput& input,
                     const ImageF& light) {
  SceneLayers layers;
  layers.light = light;
  WriteLayers(path, layers, *input.scene);
}

ImageF TextureInRec709(const CompositeInput& input, const ImageF& texture) {
  ImageF light = texture;
  if (!input.scene) return light;
  for (float& value : light.data) value /= input.scene->exposure();
  input.scene->colors().GiveRec709(&light);
  return light;
}

}  // namespace keypose::composite
