// keypose-complete: fills unseen parts of a pose's texture from the other poses' textures.
#include <string>
#include <utility>
#include <vector>

#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "texture/bake/complete.h"
#include "texture/complete_options.h"

namespace keypose::texture {
namespace {

StageSpec Spec() {
  StageSpec spec;
  spec.name = "complete";
  spec.version = "3";
  spec.summary =
      "Fills surface that a pose's photographs do not show from the other poses' textures, in "
      "the pose's own light.";
  spec.title = "Texture gaps";
  spec.measurements = {
      {"unseen_fraction", "texels unseen in all poses", "share", -kAnyNumber, 0.25}};
  spec.inputs = {{"mesh", "file", "the pose, with the texture coordinates of all textures", ""},
                 {"texture", "file", "the pose's own texture, from bake", ""},
                 {"confidence", "file", "how well photographs show its texels, from bake", ""},
                 {"textures", "file", "textures of the other poses; the pose's own one is ignored",
                  "", true, true},
                 {"confidences", "file", "of each of `textures`, in their order", "", true, true}};
  spec.outputs = {{"completed", "file", "the completed texture (.png)", "texture.png"}};
  spec.memory_gib = 2;
  return spec;
}

PoseTexture Read(const std::filesystem::path& texture, const std::filesystem::path& confidence) {
  StoredPicture stored = ReadAsStored(texture);
  return {std::move(stored.eight), ReadImage(confidence, 1), std::move(stored.sixteen)};
}

/// All poses share one UV layout, so a texture of another size only needs to be resampled.
void AtSize(int width, int height, PoseTexture* texture) {
  const auto fit = [&](auto& image) {
    if (!image.empty() && (image.width != width || image.height != height))
      image = Resized(image, width, height);
  };
  fit(texture->texture);
  fit(texture->deep);
  fit(texture->confidence);
}

/// With 16 bits where the pose's own texture has them.
void Write(const std::filesystem::path& path, const Completed& completed, bool deep) {
  if (deep && CanWriteLinear(path, 16))
    WriteLinearImage(path, completed.linear, 16);
  else
    WriteImage(path, completed.texture);
}

void Run(StageContext& stage, const CompleteOptions& options) {
  const auto textures = stage.Inputs("textures"), confidences = stage.Inputs("confidences");
  if (textures.size() != confidences.size())
    throw UsageError(
        "complete: " + std::to_string(textures.size()) + " textures and " +
        std::to_string(confidences.size()) +
        " confidences were given; pass one confidence for each texture, in the same order");
  const Mesh mesh = ReadMesh(stage.Input("mesh"));
  const PoseTexture own = Read(stage.Input("texture"), stage.Input("confidence"));
  std::vector<PoseTexture> others;
  for (std::size_t i = 0; i < textures.size(); ++i) {
    others.push_back(Read(textures[i], confidences[i]));
    AtSize(own.confidence.width, own.confidence.height, &others.back());
  }
  ReportProgress(stage.progress(), 0.2, "completing the texture");
  const Completed completed = CompleteTexture(mesh, own, others, options.gutter);
  const auto share = [&](std::int64_t texels) {
    return static_cast<double>(texels) / static_cast<double>(completed.texels);
  };
  stage.Report("texels", completed.texels);
  stage.Report("own_fraction", share(completed.own_texels));
  stage.Report("filled_fraction", share(completed.filled_texels));
  stage.Report("unseen_fraction", share(completed.unseen_texels()));
  Write(stage.Output("completed"), completed, !own.deep.empty());
}

}  // namespace
}  // namespace keypose::texture

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::texture::CompleteOptions>(argc, argv, keypose::texture::Spec(),
                                                              keypose::texture::Run);
}
