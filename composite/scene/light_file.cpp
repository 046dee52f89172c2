#include "composite/scene/light_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>

#include "core/io/pictures/picture_codec.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

constexpr double kSquare = 1e-4;
constexpr double kMostPixelsOfPlates = 500e6;

[[noreturn]] void Refuse(const fs::path& path, const std::string& why) {
  throw InputError(PrintableName(path) + " " + why);
}

std::unique_ptr<PictureReader> OpenLight(const fs::path& path) {
  OpenedPicture opened = Pictures().Open(path.string(), "", {});
  if (opened.reader) return std::move(opened.reader);
  const std::string& reason = opened.reason;
  if (reason.find("ubsampled") != std::string::npos)
    Refuse(path, "stores brightness and halved colours (Y, RY, BY); write it as R, G and B");
  Refuse(path, "cannot be read as a picture: " + WithoutOddBytes(reason) +
                   "; it is damaged or cut off: copy or render it again");
}

std::array<int, 4> ColourChannels(const PictureHeader& header) {
  const auto find = [&](const char* letter, const char* word) {
    for (int i = 0; i < header.channels; ++i)
      if (const std::string& name = header.names[i]; name == letter || name == word) return i;
    return -1;
  };
  return {find("R", "red"), find("G", "green"), find("B", "blue"), find("A", "alpha")};
}

std::string Listed(const PictureHeader& header) {
  std::string names;
  for (int i = 0; i < std::min(header.channels, 8); ++i)
    names += (i ? ", " : "") + WithoutOddBytes(header.names[i]);
  return names + (header.channels > 8 ? ", ..." : "");
}

void RefuseOtherKinds(const fs::path& path, PictureReader& input) {
  const PictureHeader header = input.header();
  if (header.deep)
    Refuse(path, "has deep pixels, several depths each; flatten it first (Nuke: DeepToImage)");
  if (input.Seek(1))
    Refuse(path,
           "has several parts (or views); write the one that is the plate into a file of its own, "
           "such as by: oiiotool IN.exr --subimage 0 -o OUT.exr");
  if (!input.Seek(0)) Refuse(path, "cannot be read again from its beginning");
  if (header.depth > 1) Refuse(path, "is a volume, not a picture");
  const float aspect = input.Float("PixelAspectRatio", 1);
  // A DPX that does not say has 0 or a number that is none.
  if (std::isfinite(aspect) && aspect > 0 && std::abs(aspect - 1) > kSquare)
    Refuse(path, fmt::format("has pixels that are not square (pixel aspect ratio {:.4g}, an "
                             "anamorphic lens); write it with square pixels first (Nuke: Reformat)",
                             aspect));
  if (1.0 * header.width * header.height > kMostPixelsOfPlates)
    Refuse(path,
           fmt::format("has {} x {} pixels, more than are read", header.width, header.height));
}

void TakeWindow(const PictureHeader& header, LightFile* file) {
  const PixelWindow& window = header.window;
  file->window = {window.x,      window.y,      header.width,      header.height,
                  window.full_x, window.full_y, window.full_width, window.full_height};
}

void TakeChannels(const fs::path& path, const PictureHeader& header, LightFile* file) {
  file->channels = ColourChannels(header);
  for (int c = 0; c < 3; ++c)
    if (file->channels[static_cast<std::size_t>(c)] < 0)
      Refuse(path, fmt::format("has no channels R, G and B (but {}); name the colours of the "
                               "plate so",
                               Listed(header)));
  file->alpha = file->channels[3] >= 0;
  file->others = header.channels - 3 - file->alpha;
  for (int c = 0; c < 3 + file->alpha; ++c) {
    const PixelType type =
        header.types[static_cast<std::size_t>(file->channels[static_cast<std::size_t>(c)])];
    if (file->exr && type != PixelType::kHalf && type != PixelType::kFloat)
      Refuse(path,
             "stores its colours as whole numbers, which are identifiers and not light; "
             "write them as half or float");
    file->single |= file->exr && type == PixelType::kFloat;
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
  const PictureHeader header = input->header();
  LightFile file;
  file.exr = input->format() == "openexr";
  TakeWindow(header, &file);
  TakeChannels(path, header, &file);
  file.bits = input->Int("oiio:BitsPerSample", 16);
  file.transfer = WithoutOddBytes(input->Text("dpx:Transfer"));
  file.writer = WithoutOddBytes(input->Text("Software"));
  std::array<float, 8> values{};
  if (input->Floats("chromaticities", 8, values.data())) file.chromaticities = values;
  return file;
}

ImageF ReadLightValues(const fs::path& path, const LightFile& header, bool alpha) {
  const auto input = OpenLight(path);
  const PictureHeader stored_as = input->header();
  const int count = alpha && header.alpha ? 4 : 3;
  ImageF values(stored_as.width, stored_as.height, count);
  const int first = *std::min_element(header.channels.begin(), header.channels.begin() + count),
            last = *std::max_element(header.channels.begin(), header.channels.begin() + count);
  ImageF stored(stored_as.width, stored_as.height, last - first + 1);
  if (!input->Read(first, last + 1, PixelType::kFloat, stored.data.data()))
    Refuse(path, "is damaged or cut off (" + WithoutOddBytes(input->Reason()) +
                     "); copy or render it again");
  const std::size_t pixels = static_cast<std::size_t>(stored_as.width) * stored_as.height;
  for (std::size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < count; ++c)
      values.data[count * i + c] =
          stored.data[stored.channels * i + header.channels[static_cast<std::size_t>(c)] - first];
  return values;
}

}  // namespace keypose::composite
