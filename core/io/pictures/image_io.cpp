#include "core/io/pictures/image_io.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <fstream>
#include <iterator>
#include <new>
#include <utility>

#include "core/io/pictures/color_profile.h"
#include "core/io/pictures/heif_io.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/picture_codec.h"
#include "core/io/pictures/picture_pages.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/image_turns.h"
#include "core/pictures/srgb16.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"
#include "core/values/file_names.h"
#include "core/values/memory.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

constexpr int kMostChannels = 4;
constexpr const char* kKinds = "JPEG, PNG, TIFF or HEIC";

void RequireReadable(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) throw DiskError("image " + path.string() + " does not exist");
  if (!fs::is_regular_file(path, error))
    throw DiskError("image " + path.string() + " is not a file");
  if (fs::file_size(path, error) == 0)
    throw InputError("image " + path.string() +
                     " is empty (0 bytes): copy it from the camera again");
}

/// @throws InputError  its bytes are not those of a known format
std::string RequireKnownKind(const fs::path& path) {
  std::string head(4096, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError("cannot open image " + path.string());
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  const std::string kind = ImageKindOf(head);
  if (!kind.empty()) return kind;
  const std::string other = OtherKindOf(head);
  throw InputError("cannot read image " + path.string() + ": it is " +
                   (other.empty() ? "no" : other + ", and no") + " " + kKinds +
                   " file, whatever its name says; save it as JPEG or PNG, or leave it out");
}

[[noreturn]] void ThrowDamaged(const fs::path& path, const std::string& reason) {
  throw InputError("image " + path.string() + " is truncated or damaged" +
                   (reason.empty() ? "" : " (" + reason + ")") +
                   ": copy it from the camera again, or leave it out");
}

[[noreturn]] void ThrowNoMemory(const fs::path& path) {
  throw DiskError("not enough memory to read image " + path.string() +
                  "; close other programs, or make the pictures smaller");
}

[[noreturn]] void ThrowTooLarge(const fs::path& path, const std::string& size) {
  throw InputError("image " + path.string() + " claims " + size + ", and pictures of at most " +
                   std::to_string(kMostPixels / 1000000) +
                   " million pixels are read; it is damaged, or make it smaller");
}

/// Checks the sizes that the header claims, before memory is allocated for them.
void RequireModestSize(const fs::path& path, const PictureHeader& header) {
  const std::string size =
      std::to_string(header.width) + " x " + std::to_string(header.height) + " pixels";
  if (header.width < 1 || header.height < 1)
    throw InputError("image " + path.string() + " has no pixels (" + size + "); leave it out");
  const auto pixels = [](int width, int height) {
    return static_cast<std::int64_t>(width) * height;
  };
  if (pixels(header.width, header.height) > kMostPixels ||
      pixels(header.tile_width, header.tile_height) > kMostPixels)
    ThrowTooLarge(path, size);
  if (header.depth > 1 || header.deep || header.channels < 1 || header.channels > kMostChannels)
    throw InputError("image " + path.string() +
                     " is not a flat picture of 1 to 4 channels (depth " +
                     std::to_string(header.depth) + ", " + std::to_string(header.channels) +
                     " channels); save it as JPEG or PNG");
}

/// Requires memory for twice the pixels: while they are rotated or converted, there are two copies.
/// Small pictures are not checked.
void RequireMemoryFor(const fs::path& path, const PictureHeader& header, std::int64_t bytes_each) {
  constexpr std::int64_t kSmall = 64 << 20;
  const std::int64_t bytes =
      2 * bytes_each * header.width * header.height * std::max(3, header.channels);
  if (bytes > kSmall)
    RequireMemory(bytes, "image " + path.string() + " (" + std::to_string(header.width) + " x " +
                             std::to_string(header.height) + " pixels)");
}

/// The HEIC decoder allocates memory for the pixels before it reports their number.
void RequireModestHeif(const fs::path& path) {
  const std::int64_t pixels = ClaimedHeifPixels(ReadFile(path));
  if (pixels > kMostPixels) ThrowTooLarge(path, "more");
  RequireMemory(6 * pixels, "image " + path.string());
}

[[noreturn]] void ThrowSeveral(const fs::path& path, const std::string& what, const char* words) {
  throw InputError("image " + path.string() + " is " + what +
                   ", of which only one could be read; save each as a picture of its own, as in\n" +
                   words);
}

/// Whether the page that the reader is at is a picture of its own: previews and masks beside a TIFF's
/// picture are none.
bool IsPage(const PictureHeader& first, const PictureReader& input) {
  constexpr int kReduced = 1, kMask = 4;  // bits of NewSubfileType
  const PictureHeader page = input.header();
  const bool aside = (input.Int("tiff:subfiletype", 0) & (kReduced | kMask)) != 0;
  return !aside && 2 * page.width > first.width && 2 * page.height > first.height;
}

/// @throws InputError  a TIFF has a second page, or begins with a preview
void RequireOnePage(const fs::path& path, PictureReader& input) {
  const PictureHeader first = input.header();
  int pages = 1;
  for (int i = 1; input.Seek(i); ++i) pages += IsPage(first, input);
  input.Reason();
  if (!input.Seek(0)) ThrowDamaged(path, input.Reason());
  if (pages > 1)
    ThrowSeveral(path, "a TIFF of " + std::to_string(pages) + " pages",
                 "  convert FILE.tif page_%02d.png");
}

void RequireOnePng(const fs::path& path) {
  const std::string bytes = ReadFile(path);
  if (!IsWholeImage(bytes, "png")) ThrowDamaged(path, "");
  if (const int frames = PngFrames(bytes); frames > 1)
    ThrowSeveral(path, "an animated PNG of " + std::to_string(frames) + " pictures",
                 "  ffmpeg -f apng -i FILE.png frame_%04d.png");
}

/// Opens the file only with the reader of the format that its bytes show. OpenImageIO would try all
/// of its readers, and not all of them withstand damaged files.
/// @param straight  colours as they are stored; else multiplied by alpha
std::unique_ptr<PictureReader> Open(const fs::path& path, bool straight = false) {
  RequireReadable(path);
  const std::string kind = RequireKnownKind(path);
  if (kind == "heif") RequireModestHeif(path);
  // What libpng takes memory for is looked at first.
  if (kind == "png") RequireOnePng(path);
  PictureTags wishes;
  if (straight) wishes.emplace_back("oiio:UnassociatedAlpha", 1);
  OpenedPicture opened = Pictures().Open(path.string(), kind, wishes);
  if (!opened.reader)
    throw InputError("cannot read image " + path.string() + ": " + opened.reason +
                     "; it is truncated or not a " + kKinds);
  RequireModestSize(path, opened.reader->header());
  if (kind == "tiff") RequireOnePage(path, *opened.reader);
  return std::move(opened.reader);
}

/// EXIF orientation; 1 (upright) when it is not one of the eight values.
int OrientationOf(const PictureReader& input) {
  const int orientation = input.Int("Orientation", 1);
  return orientation >= 1 && orientation <= 8 ? orientation : 1;
}

/// Bytes of the ICC profile; empty where there is none.
std::string ProfileIn(const PictureReader& input) { return input.Bytes("ICCProfile"); }

std::optional<double> PositiveAttribute(const PictureReader& input, const char* name) {
  const float value = input.Float(name, 0);
  if (value > 0 && std::isfinite(value)) return value;
  return std::nullopt;
}

/// Millimetres of EXIF's units of resolution; 0: none that is known.
double MillimetresOf(int unit) {
  switch (unit) {
    case 2:
      return 25.4;
    case 3:
      return 10;
    case 4:
      return 1;
    case 5:
      return 1e-3;
    default:
      return 0;
  }
}

/// The sensor's longer side. Pixels are square, and programs that turn a photograph may or may not
/// swap its two sides in EXIF, so the longer one stands for both.
std::optional<double> SensorSize(const PictureReader& input) {
  const auto resolution = PositiveAttribute(input, "Exif:FocalPlaneXResolution");
  if (!resolution) return std::nullopt;
  const double mm_per_unit = MillimetresOf(input.Int("Exif:FocalPlaneResolutionUnit", 2));
  const int x = input.Int("Exif:PixelXDimension", 0), y = input.Int("Exif:PixelYDimension", 0);
  const PictureHeader header = input.header();
  const int pixels = x > 0 ? std::max(x, y) : std::max(header.width, header.height);
  const double longer = pixels / *resolution * mm_per_unit;
  return longer > 1 && longer < 100 ? std::optional<double>(longer) : std::nullopt;
}

/// BT.601.
std::uint8_t LumaOf(const std::uint8_t* p) {
  return static_cast<std::uint8_t>((299 * p[0] + 587 * p[1] + 114 * p[2] + 500) / 1000);
}
std::uint16_t LumaOf(const std::uint16_t* p) {
  return static_cast<std::uint16_t>((299 * p[0] + 587 * p[1] + 114 * p[2] + 500) / 1000);
}
float LumaOf(const float* p) { return 0.299f * p[0] + 0.587f * p[1] + 0.114f * p[2]; }

template <class T>
ImageT<T> WithChannels(ImageT<T> in, int channels) {
  if (in.channels == channels) return in;
  ImageT<T> out(in.width, in.height, channels);
  const std::size_t pixels = static_cast<std::size_t>(in.width) * in.height;
  for (std::size_t i = 0; i < pixels; ++i) {
    const T* p = in.data.data() + i * in.channels;
    if (channels == 1)
      out.data[i] = in.channels < 3 ? p[0] : LumaOf(p);
    else
      for (int c = 0; c < channels; ++c) out.data[i * channels + c] = in.channels < 3 ? p[0] : p[c];
  }
  return out;
}

/// Writes the image as `header` and `tags` say. Leaves no file behind when writing fails.
void WriteAll(const fs::path& path, const PictureHeader& header, PictureTags tags, PixelType from,
              const void* data) {
  const std::string extension = LowerExtension(path);
  // Otherwise the library writes the time of day into these.
  if (extension == ".exr" || extension == ".tif" || extension == ".tiff")
    tags.emplace_back("DateTime", std::string());
  const WrittenPicture written = Pictures().Write(path.string(), header, tags, from, data);
  if (!written.known)
    throw DiskError("cannot write image " + path.string() +
                    ": its extension is not a known image format");
  if (written.done) return;
  std::error_code ignored;
  fs::remove(path, ignored);
  throw DiskError("cannot write image " + path.string() + ": " +
                  (written.reason.empty() ? "the disk may be full" : written.reason));
}

}  // namespace

ImageInfo ReadImageInfo(const fs::path& path) {
  const auto input = Open(path);
  const PictureHeader header = input->header();
  ImageInfo info;
  info.orientation = OrientationOf(*input);
  info.width = info.orientation >= 5 ? header.height : header.width;
  info.height = info.orientation >= 5 ? header.width : header.height;
  info.channels = header.channels;
  info.focal_mm = PositiveAttribute(*input, "Exif:FocalLength");
  info.focal_35mm = PositiveAttribute(*input, "Exif:FocalLengthIn35mmFilm");
  info.sensor_width_mm = SensorSize(*input);
  const std::string make = input->Text("Make"), model = input->Text("Model");
  info.camera_model =
      WithoutOddBytes(model.empty() || make.empty() ? make + model : make + " " + model);
  info.date_time = WithoutOddBytes(input->Text("DateTime"));
  info.format = input->format();
  return info;
}

namespace {

/// All channels. Floats are in [0, 1].
template <class T = std::uint8_t>
ImageT<T> ReadRaw(const fs::path& path, PictureReader& input) {
  const PictureHeader header = input.header();
  RequireMemoryFor(path, header, sizeof(T));
  ImageT<T> raw(header.width, header.height, header.channels);
  const bool complete = input.Read(0, header.channels, PixelTypeOf<T>(), raw.data.data());
  // libjpeg fills missing parts with grey and only warns.
  const bool is_jpeg = input.format() == "jpeg";
  if (!complete || (is_jpeg && !IsWholeImage(ReadFile(path), "jpeg")))
    ThrowDamaged(path, input.Reason());
  return raw;
}

/// Upright and in sRGB.
template <class T>
ImageT<T> ReadSrgb(const fs::path& path, PictureReader& input, int channels) {
  ImageT<T> image = WithChannels(ReadRaw<T>(path, input), channels);
  return Oriented(InSrgb(std::move(image), ProfileIn(input)), OrientationOf(input));
}

}  // namespace

Image8 ReadAlpha(const fs::path& path) {
  RequireReadable(path);
  if (RequireKnownKind(path) == "heif") return {};
  const auto input = Open(path);
  const int channel = input->header().alpha;
  if (channel < 0) return {};
  const Image8 raw = ReadRaw(path, *input);
  Image8 alpha(raw.width, raw.height, 1);
  for (int y = 0; y < raw.height; ++y)
    for (int x = 0; x < raw.width; ++x) *alpha.at(x, y) = raw.at(x, y)[channel];
  return Oriented(std::move(alpha), OrientationOf(*input));
}

Image8 ReadImage(const fs::path& path, int channels) try {
  RequireReadable(path);
  if (RequireKnownKind(path) == "heif") {
    RequireModestHeif(path);
    return WithChannels(ReadHeif(path), channels > 0 ? channels : 3);
  }
  // Colours are those of the file; marks painted on glass are what shows of them.
  const auto input = Open(path, channels != 1);
  const int wanted = channels > 0 ? channels : (input->header().channels >= 3 ? 3 : 1);
  return ReadSrgb<std::uint8_t>(path, *input, wanted);
} catch (const std::bad_alloc&) {
  ThrowNoMemory(path);
}

Image8 ReadTexture(const fs::path& path) try {
  RequireReadable(path);
  if (RequireKnownKind(path) == "heif") return ReadImage(path, 3);
  const auto input = Open(path, true);
  return InSrgb(WithChannels(ReadRaw(path, *input), 3), ProfileIn(*input));
} catch (const std::bad_alloc&) {
  ThrowNoMemory(path);
}

StoredPicture ReadAsStored(const fs::path& path) try {
  RequireReadable(path);
  if (RequireKnownKind(path) == "heif") return {ReadImage(path, 3), {}};
  const auto input = Open(path, true);
  if (input->header().bytes == 1) return {ReadSrgb<std::uint8_t>(path, *input, 3), {}};
  return {{}, ReadSrgb<std::uint16_t>(path, *input, 3)};
} catch (const std::bad_alloc&) {
  ThrowNoMemory(path);
}

StoredLevels StoredLevelsOf(const fs::path& path) {
  RequireReadable(path);
  if (RequireKnownKind(path) == "heif") return {};
  const auto input = Open(path);
  const PictureHeader header = input->header();
  StoredLevels stored;
  stored.bits = input->Int("oiio:BitsPerSample", 0);
  if (stored.bits <= 0) stored.bits = 8 * header.bytes;
  stored.alpha = header.alpha >= 0;
  stored.profile = ProfileIn(*input);
  return stored;
}

ImageF ReadLevels(const fs::path& path, int channels) try {
  RequireReadable(path);
  const bool heif = RequireKnownKind(path) == "heif";
  const auto input = heif ? nullptr : Open(path, true);
  if (heif || input->header().type == PixelType::kByte) {
    // Whole levels stay whole.
    const Image8 stored = heif ? ReadImage(path, channels) : ReadRaw(path, *input);
    ImageF levels(stored.width, stored.height, stored.channels);
    std::copy(stored.data.begin(), stored.data.end(), levels.data.begin());
    return Oriented(WithChannels(std::move(levels), channels), heif ? 1 : OrientationOf(*input));
  }
  ImageF levels = ReadRaw<float>(path, *input);
  for (float& level : levels.data) level = 255 * std::clamp(level, 0.0f, 1.0f);
  return Oriented(WithChannels(std::move(levels), channels), OrientationOf(*input));
} catch (const std::bad_alloc&) {
  ThrowNoMemory(path);
}

void WriteLevels(const fs::path& path, const ImageF& levels, int bits, const std::string& profile) {
  const PixelType type = bits == 16 ? PixelType::kShort : PixelType::kByte;
  const PictureHeader header{levels.width, levels.height, levels.channels, type};
  PictureTags tags{{"Compression", std::string("zip")},
                   {"png:compressionLevel", 4},
                   {"oiio:UnassociatedAlpha", 1}};
  if (profile.empty())
    tags.emplace_back("oiio:ColorSpace", std::string("sRGB"));
  else
    tags.emplace_back("ICCProfile", std::vector<std::uint8_t>(profile.begin(), profile.end()));
  const double steps = bits == 16 ? 257 : 1, most = 255 * steps;
  std::vector<std::uint16_t> stored(levels.data.size());
  std::transform(levels.data.begin(), levels.data.end(), stored.begin(), [&](float level) {
    return static_cast<std::uint16_t>(std::lround(std::clamp(steps * level, 0.0, most)));
  });
  if (bits == 16) return WriteAll(path, header, tags, type, stored.data());
  const std::vector<std::uint8_t> eight(stored.begin(), stored.end());
  WriteAll(path, header, tags, type, eight.data());
}

namespace {

/// The equivalent of 35 mm film is a whole number in EXIF. Where it is none, the size of a pixel on
/// the sensor tells the focal length exactly, as cameras do.
void AddPixelPitch(const ExifToWrite& exif, const PictureHeader& header, PictureTags* tags) {
  const bool whole = exif.focal_35mm == std::round(exif.focal_35mm);
  if (exif.focal_mm <= 0 || exif.focal_35mm <= 0 || whole) return;
  const double focal_px =
      exif.focal_35mm / kFilmDiagonal_mm * std::hypot(header.width, header.height);
  const auto pixels_per_cm = static_cast<float>(10 * focal_px / exif.focal_mm);
  tags->emplace_back("Exif:FocalPlaneXResolution", pixels_per_cm);
  tags->emplace_back("Exif:FocalPlaneYResolution", pixels_per_cm);
  tags->emplace_back("Exif:FocalPlaneResolutionUnit", 3);
}

template <class T>
void WritePicture(const fs::path& path, const ImageT<T>& image, int quality,
                  const ExifToWrite* exif) {
  const PixelType type = PixelTypeOf<T>();
  const PictureHeader header{image.width, image.height, image.channels, type};
  // A TIFF of 8 bits may be a JPEG within.
  const std::string extension = LowerExtension(path);
  const bool deep = type != PixelType::kByte && extension != ".jpg" && extension != ".jpeg";
  PictureTags tags{{"CompressionQuality", quality},
                   {"Compression",
                    path.extension() == ".png" || deep ? "zip" : "jpeg:" + std::to_string(quality)},
                   {"png:compressionLevel", 4}};
  if (image.channels == 3) tags.emplace_back("oiio:ColorSpace", std::string("sRGB"));
  if (exif) {
    tags.emplace_back("Make", exif->make);
    tags.emplace_back("Model", exif->model);
    tags.emplace_back("Orientation", exif->orientation);
    if (exif->focal_mm > 0)
      tags.emplace_back("Exif:FocalLength", static_cast<float>(exif->focal_mm));
    if (exif->focal_35mm > 0)
      tags.emplace_back("Exif:FocalLengthIn35mmFilm",
                        static_cast<int>(std::lround(exif->focal_35mm)));
    AddPixelPitch(*exif, header, &tags);
  }
  WriteAll(path, header, tags, type, image.data.data());
}

}  // namespace

void WriteImage(const fs::path& path, const Image8& image, int quality, const ExifToWrite* exif) {
  WritePicture(path, image, quality, exif);
}

void WriteImage(const fs::path& path, const Image16& image, int quality, const ExifToWrite* exif) {
  WritePicture(path, image, quality, exif);
}

bool CanWriteLinear(const fs::path& path, int bits) {
  const std::string extension = LowerExtension(path);
  if (extension == ".exr") return bits == 0 || bits == 16 || bits == 32;
  return (extension == ".png" || extension == ".tif" || extension == ".tiff") &&
         (bits == 0 || bits == 8 || bits == 16);
}

void WriteLinearImage(const fs::path& path, const ImageF& linear, int bits) {
  if (!CanWriteLinear(path, bits))
    throw UsageError("cannot write " + path.string() + " with " + std::to_string(bits) +
                     " bits per channel: .png and .tif hold 8 or 16, .exr holds 16 or 32");
  const std::string extension = LowerExtension(path);
  PictureHeader header{linear.width, linear.height, linear.channels, PixelType::kHalf};
  PictureTags tags{{"Compression", std::string("zip")}};
  if (extension == ".exr") {
    if (bits == 32) header.type = PixelType::kFloat;
    tags.emplace_back("oiio:ColorSpace", std::string("Linear"));
    return WriteAll(path, header, tags, PixelType::kFloat, linear.data.data());
  }
  const bool eight = bits == 8 || (bits == 0 && extension == ".png");
  header.type = eight ? PixelType::kByte : PixelType::kShort;
  tags.emplace_back("oiio:ColorSpace", std::string("sRGB"));
  tags.emplace_back("png:compressionLevel", 4);
  ImageF srgb(linear.width, linear.height, linear.channels);
  ParallelBlocks(std::ssize(srgb.data), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t at = begin; at < end; ++at) srgb.data[at] = SrgbFraction(linear.data[at]);
  });
  WriteAll(path, header, tags, PixelType::kFloat, srgb.data.data());
}

}  // namespace keypose
