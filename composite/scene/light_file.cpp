#include "composite/scene/light_file.h"

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;
using OIIO::ImageInput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

constexpr double kSquare = 1e-4;
constexpr double kMostPixelsOfPlates = 500e6;

[[noreturn]] void Refuse(const fs::path& path, const std::string& why) {
  throw InputError(PrintableName(path) + " " + why);
}

std::unique_ptr<ImageInput> OpenLight(const fs::path& path) {
  auto input = ImageInput::open(path.string());
  if (input) return input;
  const std::string reason = OIIO::geterror();
  if (reason.find("ubsampled") != std::string::npos)
    Refuse(path, "stores brightness and halved colours (Y, RY, BY); write it as R, G and B");
  Refuse(path, "cannot be read as a picture: " + WithoutOddBytes(reason) +
                   "; it is damaged or cut off: copy or render it again");
}

std::array<int, 4> ColourChannels(const ImageSpec& spec) {
  const auto find = [&](const char* letter, const char* word) {
    for (int i = 0; i < spec.nchannels; ++i)
      if (const std::string& name = spec.channelnames[i]; name == letter || name == word) return i;
    return -1;
  };
  return {find("R", "red"), find("G", "green"), find("B", "blue"), find("A", "alpha")};
}

std::string Listed(const ImageSpec& spec) {
  std::string names;
  for (int i = 0; i < std::min(spec.nchannels, 8); ++i)
    names += (i ? ", " : "") + WithoutOddBytes(spec.channelnames[i]);
  return names + (spec.nchannels > 8 ? ", ..." : "");
}

void RefuseOtherKinds(const fs::path& path, ImageInput& input) {
  const ImageSpec spec = input.spec();
  if (spec.deep)
    Refuse(path, "has deep pixels, several depths each; flatten it first (Nuke: DeepToImage)");
  if (input.seek_subimage(1, 0))
    Refuse(path,
           "has several parts (or views); write the one that is the plate into a file of its own, "
           "such as by: oiiotool IN.exr --subimage 0 -o OUT.exr");
  if (!input.seek_subimage(0, 0)) Refuse(path, "cannot be read again from its beginning");
  if (spec.depth > 1) Refuse(path, "is a volume, not a picture");
  const float aspect = spec.get_float_attribute("PixelAspectRatio", 1);
  // A DPX that does not say has 0 or a number that is none.
  if (std::isfinite(aspect) && aspect > 0 && std::abs(aspect - 1) > kSquare)
    Refuse(path, fmt::format("has pixels that are not square (pixel aspect ratio {:.4g}, an "
                             "anamorphic lens); write it with square pixels first (Nuke: Reformat)",
                             aspect));
  if (1.0 * spec.width * spec.height > kMostPixelsOfPlates)
    Refuse(path, fmt::format("has {} x {} pixels, more than are read", spec.width, spec.height));
}

void TakeWindow(const ImageSpec& spec, LightFile* file) {
  file->window = {spec.x,      spec.y,      spec.width,      spec.height,
                  spec.full_x, spec.full_y, spec.full_width, spec.full_height};
}

void TakeChannels(const fs::path& path, const ImageSpec& spec, LightFile* file) {
  file->channels = ColourChannels(spec);
  for (int c = 0; c < 3; ++c)
    if (file->channels[static_cast<std::size_t>(c)] < 0)
      Refuse(path, fmt::format("has no channels R, G and B (but {}); name the colours of the "
                               "plate so",
                               Listed(spec)));
  file->alpha = file->channels[3] >= 0;
  file->others = spec.nchannels - 3 - file->alpha;
  for (int c = 0; c < 3 + file->alpha; ++c) {
    const TypeDesc type = spec.channelformat(file->channels[static_cast<std::size_t>(c)]);
    if (file->exr && type != TypeDesc::HALF && type != TypeDesc::FLOAT)
      Refuse(path,
             "stores its colours as whole numbers, which are identifiers and not light; "
             "write them as half or float");
    file->single |= file->exr && type == TypeDesc::FLOAT;
  }
}

}  // namespace

bool IsLightFile(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  char magic[4] = {};
  if (!file) throw DiskError("cannot read " + PrintableName(path));
  file.read(magic, 4);
  const std::string_view begin(magic, 4);
  return begin == "\x76\x2f\x31\x01" || begin == "SDPX" || begin == "XPDS";
}

LightFile ReadLightHeader(const fs::path& path) {
  if (!IsLightFile(path))
    Refuse(path,
           "is neither an OpenEXR nor a DPX picture; all pictures of a plate or film are of "
           "one kind");
  const auto input = OpenLight(path);
  RefuseOtherKinds(path, *input);
  const ImageSpec spec = input->spec();
  LightFile file;
  file.exr = std::string_view(input->format_name()) == "openexr";
  TakeWindow(spec, &file);
  TakeChannels(path, spec, &file);
  file.bits = spec.get_int_attribute("oiio:BitsPerSample", 16);
  file.transfer = WithoutOddBytes(std::string(spec.get_string_attribute("dpx:Transfer")));
  file.writer = WithoutOddBytes(std::string(spec.get_string_attribute("Software")));
  std::array<float, 8> values{};
  if (spec.getattribute("chromaticities", TypeDesc(TypeDesc::FLOAT, 8), values.data()))
    file.chromaticities = values;
  return file;
}

ImageF ReadLightValues(const fs::path& path, const LightFile& header, bool alpha) {
  const auto input = OpenLight(path);
  const ImageSpec spec = input->spec();
  const int count = alpha && header.alpha ? 4 : 3;
  ImageF values(spec.width, spec.height, count);
  const int first = *std::min_element(header.channels.begin(), header.channels.begin() + count),
            last = *std::max_element(header.channels.begin(), header.channels.begin() + count);
  ImageF stored(spec.width, spec.height, last - first + 1);
  if (!input->read_image(0, 0, first, last + 1, TypeDesc::FLOAT, stored.data.data()))
    Refuse(path, "is damaged or cut off (" + WithoutOddBytes(input->geterror()) +
                     "); copy or render it again");
  const std::size_t pixels = static_cast<std::size_t>(spec.width) * spec.height;
  for (std::size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < count; ++c)
      values.data[count * i + c] =
          stored.data[stored.channels * i + header.channels[static_cast<std::size_t>(c)] - first];
  return values;
}

}  // namespace keypose::composite
