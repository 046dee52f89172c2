// The module keypose_pictures: OpenImageIO behind picture_codec.h. Throws none of our errors.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <utility>

#include "core/io/pictures/picture_codec.h"

namespace keypose {
namespace {

using OIIO::ImageInput;
using OIIO::ImageOutput;
using OIIO::ImageSpec;
using OIIO::TypeDesc;

TypeDesc DescOf(PixelType type) {
  switch (type) {
    case PixelType::kByte:
      return TypeDesc::UINT8;
    case PixelType::kShort:
      return TypeDesc::UINT16;
    case PixelType::kHalf:
      return TypeDesc::HALF;
    case PixelType::kFloat:
      return TypeDesc::FLOAT;
    case PixelType::kOther:
      break;
  }
  return TypeDesc::UNKNOWN;
}

PixelType TypeOf(TypeDesc desc) {
  for (const PixelType type :
       {PixelType::kByte, PixelType::kShort, PixelType::kHalf, PixelType::kFloat})
    if (desc == DescOf(type)) return type;
  return PixelType::kOther;
}

void AddTags(const PictureTags& tags, ImageSpec* spec) {
  for (const auto& [name, tag] : tags) {
    if (const int* whole = std::get_if<int>(&tag)) spec->attribute(name, *whole);
    if (const float* real = std::get_if<float>(&tag)) spec->attribute(name, *real);
    if (const auto* text = std::get_if<std::string>(&tag)) spec->attribute(name, *text);
    if (const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&tag))
      spec->attribute(name, TypeDesc(TypeDesc::UINT8, static_cast<int>(bytes->size())),
                      bytes->data());
    if (const auto* reals = std::get_if<std::vector<float>>(&tag))
      spec->attribute(name, TypeDesc(TypeDesc::FLOAT, static_cast<int>(reals->size())),
                      reals->data());
  }
}

PictureHeader HeaderOf(const ImageSpec& spec) {
  PictureHeader header;
  header.width = spec.width;
  header.height = spec.height;
  header.channels = spec.nchannels;
  header.type = TypeOf(spec.format);
  header.bytes = static_cast<int>(spec.format.size());
  header.window = {spec.x, spec.y, spec.full_x, spec.full_y, spec.full_width, spec.full_height};
  header.depth = spec.depth;
  header.tile_width = spec.tile_width;
  header.tile_height = spec.tile_height;
  header.deep = spec.deep;
  header.alpha = spec.alpha_channel;
  header.names = spec.channelnames;
  for (int channel = 0; channel < static_cast<int>(header.names.size()); ++channel)
    header.types.push_back(TypeOf(spec.channelformat(channel)));
  return header;
}

ImageSpec SpecOf(const PictureHeader& header, const PictureTags& tags) {
  ImageSpec spec(header.width, header.height, header.channels, DescOf(header.type));
  if (const PixelWindow& window = header.window; window.full_width > 0) {
    spec.x = window.x;
    spec.y = window.y;
    spec.full_x = window.full_x;
    spec.full_y = window.full_y;
    spec.full_width = window.full_width;
    spec.full_height = window.full_height;
  }
  if (!header.names.empty()) {
    spec.channelnames = header.names;
    spec.channelformats.clear();
    for (const PixelType type : header.types) spec.channelformats.push_back(DescOf(type));
    spec.alpha_channel = header.alpha;
  }
  AddTags(tags, &spec);
  return spec;
}

class OpenPicture : public PictureReader {
 public:
  explicit OpenPicture(std::unique_ptr<ImageInput> input) : input_(std::move(input)) {}

  PictureHeader header() const override { return HeaderOf(input_->spec()); }
  std::string format() const override { return input_->format_name(); }
  int Int(const char* tag, int otherwise) const override {
    return input_->spec().get_int_attribute(tag, otherwise);
  }
  float Float(const char* tag, float otherwise) const override {
    return input_->spec().get_float_attribute(tag, otherwise);
  }
  std::string Text(const char* tag) const override {
    return std::string(input_->spec().get_string_attribute(tag));
  }
  std::string Bytes(const char* tag) const override {
    const OIIO::ParamValue* value = input_->spec().find_attribute(tag);
    if (!value) return {};
    return {static_cast<const char*>(value->data()), static_cast<std::size_t>(value->datasize())};
  }
  bool Floats(const char* tag, int count, float* values) const override {
    return input_->spec().getattribute(tag, TypeDesc(TypeDesc::FLOAT, count), values);
  }
  bool Seek(int part) override { return input_->seek_subimage(part, 0); }
  bool Read(int first, int end, PixelType as, void* values) override {
    return input_->read_image(0, 0, first, end, DescOf(as), values);
  }
  std::string Reason() override { return input_->geterror(); }

 private:
  std::unique_ptr<ImageInput> input_;
};

WrittenPicture WriteBy(ImageOutput* output, const std::string& name, const ImageSpec& spec,
                       TypeDesc from, const void* values) {
  if (!output) return {false, false, OIIO::geterror()};
  if (output->open(name, spec) && output->write_image(from, values) && output->close())
    return {true, true, ""};
  return {false, true, output->geterror()};
}

class OpenImageIo : public PictureCodec {
 public:
  OpenedPicture Open(const std::string& path, const std::string& format,
                     const PictureTags& wishes) const override {
    ImageSpec spec, wish;
    AddTags(wishes, &wish);
    auto input = format.empty() ? ImageInput::open(path, wishes.empty() ? nullptr : &wish)
                                : ImageInput::create(format);
    if (!input) return {nullptr, false, OIIO::geterror()};
    if (!format.empty() && !input->open(path, spec, wish))
      return {nullptr, true, input->geterror()};
    return {std::make_unique<OpenPicture>(std::move(input)), true, ""};
  }

  WrittenPicture Write(const std::string& path, const PictureHeader& header,
                       const PictureTags& tags, PixelType from, const void* values) const override {
    const auto output = ImageOutput::create(path);
    return WriteBy(output.get(), path, SpecOf(header, tags), DescOf(from), values);
  }

  WrittenPicture Encode(const std::string& name, const PictureHeader& header,
                        const PictureTags& tags, const void* values,
                        std::string* bytes) const override {
    OIIO::Filesystem::IOVecOutput file;
    const auto output = ImageOutput::create(name, &file);
    const WrittenPicture written =
        WriteBy(output.get(), name, SpecOf(header, tags), DescOf(header.type), values);
    bytes->assign(file.buffer().begin(), file.buffer().end());
    return written;
  }
};

}  // namespace
}  // namespace keypose

extern "C" __attribute__((visibility("default"))) const keypose::PictureCodec* KeyposePictures() {
  static const keypose::OpenImageIo codec;
  return &codec;
}
