// Files of pictures as OpenImageIO reads and writes them, by plain values: only
// picture_codec_module.cpp includes the library, which is loaded with the first picture.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace keypose {

/// How a value of a pixel is stored.
enum class PixelType { kOther, kByte, kShort, kHalf, kFloat };

template <class T>
constexpr PixelType PixelTypeOf() {
  if (std::is_same_v<T, std::uint8_t>) return PixelType::kByte;
  if (std::is_same_v<T, std::uint16_t>) return PixelType::kShort;
  static_assert(std::is_same_v<T, std::uint8_t> || std::is_same_v<T, std::uint16_t> ||
                std::is_same_v<T, float>);
  return PixelType::kFloat;
}

/// Where the pixels lie in the whole picture, which may be larger or smaller. Pixels.
struct PixelWindow {
  int x = 0, y = 0, full_x = 0, full_y = 0, full_width = 0, full_height = 0;
};

/// What a header says about the pixels.
struct PictureHeader {
  int width = 0, height = 0, channels = 0;
  PixelType type = PixelType::kByte;  ///< the widest of the channels
  int bytes = 1;                      ///< of a value of `type`
  PixelWindow window = {};            ///< to write: full_width 0 is all
  int depth = 1;                      ///< more: a volume
  int tile_width = 0, tile_height = 0;
  bool deep = false;                    ///< several depths a pixel
  int alpha = -1;                       ///< the channel; -1: none
  std::vector<std::string> names = {};  ///< of the channels; to write: empty is Y, RGB or RGBA
  std::vector<PixelType> types = {};    ///< of the channels, as many as names
};

using PictureTag =
    std::variant<int, float, std::string, std::vector<std::uint8_t>, std::vector<float>>;
/// Names as OpenImageIO has them: "Orientation", "Exif:FocalLength", "raw:ColorSpace".
using PictureTags = std::vector<std::pair<std::string, PictureTag>>;

/// A file that is open.
class PictureReader {
 public:
  virtual ~PictureReader() = default;
  virtual PictureHeader header() const = 0;
  virtual std::string format() const = 0;  ///< "jpeg", "png", "tiff", "openexr"
  /// A tag of the header, converted where its type is another.
  virtual int Int(const char* tag, int otherwise) const = 0;
  virtual float Float(const char* tag, float otherwise) const = 0;
  virtual std::string Text(const char* tag) const = 0;   ///< empty: there is none
  virtual std::string Bytes(const char* tag) const = 0;  ///< as stored; empty: there is none
  /// @return whether it is there, with so many values
  virtual bool Floats(const char* tag, int count, float* values) const = 0;
  /// Goes to one of the pictures in the file.
  virtual bool Seek(int part) = 0;
  /// Channels from `first` to before `end`, row by row, interleaved.
  virtual bool Read(int first, int end, PixelType as, void* values) = 0;
  /// Why the last call failed; says it once.
  virtual std::string Reason() = 0;
};

struct OpenedPicture {
  std::unique_ptr<PictureReader> reader;  ///< none: `reason` says why
  bool known = false;                     ///< there is a reader of its format
  std::string reason;
};

struct WrittenPicture {
  bool done = false;   ///< else `reason` says why, or is empty
  bool known = false;  ///< there is a writer of its format
  std::string reason;
};

class PictureCodec {
 public:
  virtual ~PictureCodec() = default;
  /// @param format  whose reader opens it; empty: any that can
  /// @param wishes  how to read it
  virtual OpenedPicture Open(const std::string& path, const std::string& format,
                             const PictureTags& wishes) const = 0;
  /// Writes the format of the path's extension.
  /// @param values  all pixels, row by row, interleaved, of type `from`
  virtual WrittenPicture Write(const std::string& path, const PictureHeader& header,
                               const PictureTags& tags, PixelType from,
                               const void* values) const = 0;
  /// The same into memory, from values of the header's type.
  /// @param name  as of a file
  virtual WrittenPicture Encode(const std::string& name, const PictureHeader& header,
                                const PictureTags& tags, const void* values,
                                std::string* bytes) const = 0;
};

/// @throws ToolError  OpenImageIO cannot be loaded
const PictureCodec& Pictures();

}  // namespace keypose
