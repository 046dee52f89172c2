#include "composite/scene/layered_exr.h"

#include <OpenImageIO/imageio.h>

#include <string>
#include <vector>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

/// Channels one after the other, of which each is one of an image's.
class Channels {
 public:
  Channels(const ImageF& first, ImageSpec* spec) : pixels_(first.data.size() / 3), spec_(spec) {}

  /// @param factor  on the values, a power of two
  void Add(const std::string& name, const ImageF& image, int channel, TypeDesc type,
           float factor = 1) {
    names_.push_back(name);
    sources_.push_back({image.data.empty() ? nullptr : image.data.data() + channel,
                        static_cast<std::size_t>(image.channels), factor});
    types_.push_back(type);
  }

  std::vector<float> Interleaved() const {
    std::vector<float> all(pixels_ * names_.size());
    for (std::size_t c = 0; c < names_.size(); ++c)
      for (std::size_t i = 0; i < pixels_; ++i)
        all[i * names_.size() + c] =
            sources_[c].values ? sources_[c].factor * sources_[c].values[i * sources_[c].step]
                               : 1.0f;
    return all;
  }

  void Describe() const {
    spec_->nchannels = static_cast<int>(names_.size());
    spec_->channelnames = names_;
    spec_->channelformats = types_;
    spec_->format = TypeDesc::FLOAT;
    spec_->alpha_channel = 3;
  }

 private:
  struct Source {
    const float* values;
    std::size_t step;
    float factor;
  };
  std::size_t pixels_;
  ImageSpec* spec_;
  std::vector<std::string> names_;
  std::vector<Source> sources_;
  std::vector<TypeDesc> types_;
};

ImageSpec SpecOf(const ScenePlates& plates) {
  const PictureWindow& window = plates.window();
  ImageSpec spec(window.width, window.height, 3, TypeDesc::FLOAT);
  spec.x = window.x, spec.y = window.y;
  spec.full_x = window.full_x, spec.full_y = window.full_y;
  spec.full_width = window.full_width, spec.full_height = window.full_height;
  spec.attribute("compression", "zip");
  const std::array<float, 8> chromaticities = ChromaticitiesOf(plates.colors().primaries());
  spec.attribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), chromaticities.data());
  spec.attribute("DateTime", "");  // the time of day would make other bytes of the same picture
  spec.attribute("Software", "Keypose");
  return spec;
}

}  // namespace

void WriteLayers(const std::filesystem::path& path, const SceneLayers& layers,
                 const ScenePlates& plates) {
  const TypeDesc colour = plates.single() ? TypeDesc::FLOAT : TypeDesc::HALF;
  ImageSpec spec = SpecOf(plates);
  Channels channels(layers.light, &spec);
  const float as_read = 1 / plates.exposure();
  const char* letters[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 3; ++c) channels.Add(letters[c], layers.light, c, colour, as_read);
  channels.Add("A", layers.alpha, 0, colour);
  for (int c = 0; c < 4 && !layers.character.empty(); ++c)
    channels.Add(std::string("character.") + letters[c], layers.character, c, colour,
                 c < 3 ? as_read : 1);
  if (!layers.depth.empty()) channels.Add("depth.Z", layers.depth, 0, TypeDesc::FLOAT);
  if (!layers.character.empty()) channels.Add("mask.A", layers.character, 3, colour);
  if (!layers.shadow.empty()) channels.Add("shadow.A", layers.shadow, 0, colour);
  channels.Describe();
  const auto output = ImageOutput::create(path.string());
  const std::vector<float> all = channels.Interleaved();
  if (!output || !output->open(path.string(), spec) ||
      !output->write_image(TypeDesc::FLOAT, all.data()) || !output->close())
    throw DiskError("cannot write " + PrintableName(path) + ": " +
                    WithoutOddBytes(output ? output->geterror() : OIIO::geterror()));
}

}  // namespace keypose::composite
