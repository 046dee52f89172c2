#include "composite/scene/layered_exr.h"

#include <string>
#include <vector>

#include "core/io/pictures/picture_codec.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::composite {
namespace {

/// Channels one after the other, of which each is one of an image's.
class Channels {
 public:
  explicit Channels(const ImageF& first) : pixels_(first.data.size() / 3) {}

  /// @param factor  on the values, a power of two
  void Add(const std::string& name, const ImageF& image, int channel, PixelType type,
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

  void Describe(PictureHeader* header) const {
    header->channels = static_cast<int>(names_.size());
    header->names = names_;
    header->types = types_;
    header->type = PixelType::kFloat;
    header->alpha = 3;
  }

 private:
  struct Source {
    const float* values;
    std::size_t step;
    float factor;
  };
  std::size_t pixels_;
  std::vector<std::string> names_;
  std::vector<Source> sources_;
  std::vector<PixelType> types_;
};

PictureHeader HeaderOf(const ScenePlates& plates) {
  const PictureWindow& window = plates.window();
  PictureHeader header;
  header.width = window.width, header.height = window.height;
  header.window = {window.x,      window.y,          window.full_x,
                   window.full_y, window.full_width, window.full_height};
  return header;
}

PictureTags TagsOf(const ScenePlates& plates) {
  const std::array<float, 8> chromaticities = ChromaticitiesOf(plates.colors().primaries());
  return {{"compression", std::string("zip")},
          {"chromaticities", std::vector<float>(chromaticities.begin(), chromaticities.end())},
          // The time of day would make other bytes of the same picture.
          {"DateTime", std::string()},
          {"Software", std::string("Keypose")}};
}

}  // namespace

void WriteLayers(const std::filesystem::path& path, const SceneLayers& layers,
                 const ScenePlates& plates) {
  const PixelType colour = plates.single() ? PixelType::kFloat : PixelType::kHalf;
  Channels channels(layers.light);
  const float as_read = 1 / plates.exposure();
  const char* letters[] = {"R", "G", "B", "A"};
  for (int c = 0; c < 3; ++c) channels.Add(letters[c], layers.light, c, colour, as_read);
  channels.Add("A", layers.alpha, 0, colour);
  for (int c = 0; c < 4 && !layers.character.empty(); ++c)
    channels.Add(std::string("character.") + letters[c], layers.character, c, colour,
                 c < 3 ? as_read : 1);
  if (!layers.depth.empty()) channels.Add("depth.Z", layers.depth, 0, PixelType::kFloat);
  if (!layers.character.empty()) channels.Add("mask.A", layers.character, 3, colour);
  if (!layers.shadow.empty()) channels.Add("shadow.A", layers.shadow, 0, colour);
  PictureHeader header = HeaderOf(plates);
  channels.Describe(&header);
  const std::vector<float> all = channels.Interleaved();
  const WrittenPicture written =
      Pictures().Write(path.string(), header, TagsOf(plates), PixelType::kFloat, all.data());
  if (!written.done)
    throw DiskError("cannot write " + PrintableName(path) + ": " + WithoutOddBytes(written.reason));
}

}  // namespace keypose::composite
