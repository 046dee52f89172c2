// OpenEXR files for tests, by the library alone.
#pragma once

#include <OpenImageIO/imageio.h>

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

namespace keypose::composite {

/// Writes values as half.
/// @param change  of the header
template <class Change>
void WriteTestingExr(const std::filesystem::path& path, int width, int height,
                     const std::vector<std::string>& channels, const std::vector<float>& values,
                     const Change& change) {
  OIIO::ImageSpec spec(width, height, static_cast<int>(channels.size()), OIIO::TypeDesc::HALF);
  spec.channelnames = channels;
  change(spec);
  const auto output = OIIO::ImageOutput::create(path.string());
  if (!output || !output->open(path.string(), spec) ||
      !output->write_image(OIIO::TypeDesc::FLOAT, values.data()) || !output->close())
    throw std::runtime_error(output ? output->geterror() : OIIO::geterror());
}

/// A channel's values as floats; empty: there is no such channel.
inline std::vector<float> TestingChannel(const std::filesystem::path& path,
                                         const std::string& name) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) throw std::runtime_error(OIIO::geterror());
  const OIIO::ImageSpec spec = input->spec();
  for (int c = 0; c < spec.nchannels; ++c) {
    if (spec.channelnames[static_cast<std::size_t>(c)] != name) continue;
    std::vector<float> values(static_cast<std::size_t>(spec.width) * spec.height);
    input->read_image(0, 0, c, c + 1, OIIO::TypeDesc::FLOAT, values.data());
    return values;
  }
  return {};
}

}  // namespace keypose::composite
