#include "core/io/pictures/reduced_image.h"

// jpeglib.h needs size_t and FILE from here.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/io/pictures/color_profile.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/text/files.h"
#include "core/pictures/image_turns.h"

namespace keypose {
namespace {

int PartOf(int size, int eighths) { return (size * eighths + 7) / 8; }

/// The pixels that one pixel of the reduced picture covers along one axis, with their weights.
struct Footprint {
  int first = 0;
  std::vector<float> weights;
};

/// @param step  pixels that each covers, 1 or more
std::vector<Footprint> Footprints(int count, double step) {
  std::vector<Footprint> footprints(static_cast<std::size_t>(count));
  for (std::size_t k = 0; k < footprints.size(); ++k) {
    const double begin = static_cast<double>(k) * step, end = begin + step;
    footprints[k].first = static_cast<int>(begin);
    for (int i = footprints[k].first; i < end; ++i)
      footprints[k].weights.push_back(
          static_cast<float>((std::min<double>(i + 1, end) - std::max<double>(i, begin)) / step));
  }
  return footprints;
}

/// The pixels of a reduced picture.
struct Grid {
  std::vector<Footprint> columns, rows;
};

Grid GridOfEighths(int width, int height, int eighths) {
  return {Footprints(PartOf(width, eighths), 8.0 / eighths),
          Footprints(PartOf(height, eighths), 8.0 / eighths)};
}

/// Means around each pixel's centre, which weigh less with the distance and end at the
/// neighbours' centres: the last step to a size that is no eighth would blur by stripes otherwise.
/// @param size  of the picture, of which `extent` pixels are to be covered
std::vector<Footprint> Tents(int size, double extent, int count) {
  std::vector<Footprint> tents(static_cast<std::size_t>(count));
  const double step = extent / count;
  for (std::size_t k = 0; k < tents.size(); ++k) {
    const double center = (static_cast<double>(k) + 0.5) * step;
    const int begin = std::max(0, static_cast<int>(std::floor(center - step + 0.5))),
              end = std::min(size, static_cast<int>(std::ceil(center + step - 0.5)));
    tents[k].first = begin;
    double total = 0;
    for (int i = begin; i < end; ++i) total += 1 - std::abs(i + 0.5 - center) / step;
    for (int i = begin; i < end; ++i)
      tents[k].weights.push_back(
          static_cast<float>((1 - std::abs(i + 0.5 - center) / step) / total));
  }
  return tents;
}

/// Reduces a picture whose rows come one after the other.
class RowReducer {
 public:
  RowReducer(int width, int height, int channels, Grid grid)
      : height_(height),
        columns_(std::move(grid.columns)),
        rows_(std::move(grid.rows)),
        reduced_(static_cast<int>(columns_.size()), static_cast<int>(rows_.size()), channels) {
    for (std::vector<float>& sums : sums_)
      sums.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(channels), 0);
  }

  /// @param row  the next one
  void Add(const std::uint8_t* row) {
    for (std::size_t k = open_; k < rows_.size() && rows_[k].first <= next_; ++k) {
      const std::vector<float>& weights = rows_[k].weights;
      const auto j = static_cast<std::size_t>(next_ - rows_[k].first);
      float weight = weights[j];
      const bool last_row = next_ + 1 == height_;
      for (std::size_t beyond = j + 1; last_row && beyond < weights.size(); ++beyond)
        weight += weights[beyond];
      AddTo(sums_[k % kOpen], row, weight);
      if (last_row || j + 1 == weights.size()) Close(k, sums_[k % kOpen]);
    }
    ++next_;
  }
  Image8 Take() { return std::move(reduced_); }

 private:
  static void AddTo(std::vector<float>& sums, const std::uint8_t* row, float weight) {
    float* to = sums.data();
    for (std::size_t i = 0; i < sums.size(); ++i) to[i] += weight * row[i];
  }

  /// Joins the columns of row k of the reduced picture, whose sums are complete.
  void Close(std::size_t k, std::vector<float>& sums) {
    const int channels = reduced_.channels,
              last =
                  static_cast<int>(sums.size()) / channels - 1;  // is repeated beyond the picture
    std::uint8_t* out = reduced_.at(0, static_cast<int>(k));
    for (const Footprint& footprint : columns_)
      for (int c = 0; c < channels; ++c) {
        float sum = 0;
        for (std::size_t i = 0; i < footprint.weights.size(); ++i) {
          const int from = std::min(footprint.first + static_cast<int>(i), last);
          sum += footprint.weights[i] * sums[static_cast<std::size_t>(from * channels + c)];
        }
        *out++ = static_cast<std::uint8_t>(sum + 0.5F);
      }
    std::fill(sums.begin(), sums.end(), 0.0F);
    open_ = k + 1;
  }

  static constexpr std::size_t kOpen = 4;  // rows that may share one of the picture

  int height_, next_ = 0;  // row of the picture
  std::size_t open_ = 0;   // first row of the reduced picture that is not complete
  std::vector<Footprint> columns_, rows_;
  std::vector<float> sums_[kOpen];  // row k's are sums_[k % kOpen]
  Image8 reduced_;
};

struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

[[noreturn]] void GoBack(j_common_ptr info) {
  std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->back, 1);
}
void SayNothing(j_common_ptr) {}

/// Grey pictures have only luma to give, and the decoder has no way from CMYK to RGB.
bool Decodes(const jpeg_decompress_struct& info, int channels) {
  if (info.jpeg_color_space == JCS_GRAYSCALE) return channels == 1;
  return info.jpeg_color_space == JCS_YCbCr;
}

/// libjpeg leaves a function that fails with a jump, which no object with a destructor may cross:
/// the pixels belong to the caller.
/// @param pixels  of `image`, allocated between header and pixels by `allocate`
template <class Allocate>
bool DecodePart(jpeg_decompress_struct& info, JpegErrors& errors, const std::string& bytes,
                int channels, int eighths, const Allocate& allocate) {
  if (setjmp(errors.back)) return false;
  jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  if (jpeg_read_header(&info, TRUE) != JPEG_HEADER_OK || !Decodes(info, channels)) return false;
  info.scale_num = static_cast<unsigned>(eighths);
  info.scale_denom = 8;
  info.out_color_space = channels == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&info);
  std::uint8_t* row = allocate(info.output_width, info.output_height);
  while (info.output_scanline < info.output_height) {
    JSAMPROW rows[] = {row + static_cast<std::size_t>(info.output_scanline) * info.output_width *
                                 static_cast<unsigned>(channels)};
    jpeg_read_scanlines(&info, rows, 1);
  }
  jpeg_finish_decompress(&info);
  return true;
}

/// The JPEG's pixels as they are stored; empty where this decoder does not know its colours.
Image8 PartOfJpeg(const std::string& bytes, int channels, int eighths) {
  jpeg_decompress_struct info;
  JpegErrors errors;
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = GoBack;
  errors.manager.output_message = SayNothing;
  jpeg_create_decompress(&info);
  Image8 image;
  const bool decoded =
      DecodePart(info, errors, bytes, channels, eighths, [&](unsigned width, unsigned height) {
        image = Image8(static_cast<int>(width), static_cast<int>(height), channels);
        return image.data.data();
      });
  jpeg_destroy_decompress(&info);
  return decoded ? std::move(image) : Image8{};
}

struct PngSource {
  const std::string& bytes;
  std::size_t at = 0;
};

void TakeBytes(png_structp png, png_bytep to, png_size_t count) {
  auto* source = static_cast<PngSource*>(png_get_io_ptr(png));
  if (count > source->bytes.size() - source->at) png_error(png, "truncated");
  std::copy_n(source->bytes.data() + source->at, count, to);
  source->at += count;
}

[[noreturn]] void GoBackFromPng(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void SayNothingOfPng(png_structp, png_const_charp) {}

/// As with DecodePart, what has a destructor belongs to the caller.
/// @param row  of the picture's width
bool ReduceRows(png_structp png, png_infop info, int height, std::uint8_t* row,
                RowReducer* reducer) {
  if (setjmp(png_jmpbuf(png))) return false;
  for (int y = 0; y < height; ++y) {
    png_read_row(png, row, nullptr);
    reducer->Add(row);
  }
  png_read_end(png, info);
  return true;
}

/// Whether the rows are bytes of grey in their order.
bool ReadGreyHeader(png_structp png, png_infop info, PngSource* source) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_read_fn(png, source, TakeBytes);
  png_read_info(png, info);
  return png_get_color_type(png, info) == PNG_COLOR_TYPE_GRAY &&
         png_get_bit_depth(png, info) == 8 && png_get_valid(png, info, PNG_INFO_tRNS) == 0 &&
         png_get_interlace_type(png, info) == PNG_INTERLACE_NONE;
}

/// Masks row by row; empty for other PNG files.
Image8 PartOfGreyPng(const std::string& bytes, const ImageInfo& size, Grid grid) {
  png_structp png =
      png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, GoBackFromPng, SayNothingOfPng);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  PngSource source{bytes};
  Image8 part;
  if (info && ReadGreyHeader(png, info, &source)) {
    RowReducer reducer(size.width, size.height, 1, std::move(grid));
    std::vector<std::uint8_t> row(static_cast<std::size_t>(size.width));
    if (ReduceRows(png, info, size.height, row.data(), &reducer)) part = reducer.Take();
  }
  png_destroy_read_struct(&png, &info, nullptr);
  return part;
}

/// A picture that is stored turned has its last column or row, which may cover only a part of a
/// pixel, on another side.
bool MayBeDecodedInPart(const ImageInfo& info, int eighths) {
  return info.format == "jpeg" && (info.orientation == 1 || (info.width * eighths % 8 == 0 &&
                                                             info.height * eighths % 8 == 0));
}

bool IsGreyPng(const ImageInfo& info) {
  return info.format == "png" && info.channels == 1 && info.orientation == 1;
}

Image8 Averaged(const Image8& image, Grid grid) {
  RowReducer reducer(image.width, image.height, image.channels, std::move(grid));
  for (int y = 0; y < image.height; ++y) reducer.Add(image.at(0, y));
  return reducer.Take();
}

/// Empty where the file must be read whole.
Image8 ReadMask(const std::filesystem::path& path, const ImageInfo& info, Grid grid) {
  const std::string bytes = ReadFile(path);
  return IsWholeImage(bytes, "png") ? PartOfGreyPng(bytes, info, std::move(grid)) : Image8{};
}

/// Empty where the file must be read whole.
Image8 ReadJpeg(const std::filesystem::path& path, const ImageInfo& info, int channels,
                int eighths) {
  const std::string bytes = ReadFile(path);
  if (!IsWholeImage(bytes, "jpeg")) return {};
  Image8 part = PartOfJpeg(bytes, channels, eighths);
  if (part.empty()) return part;
  if (channels == 3) part = InSrgb(std::move(part), StoredLevelsOf(path).profile);
  return Oriented(std::move(part), info.orientation);
}

}  // namespace

int EighthsFor(int width, int height, int least_px) {
  const int longer = std::max(width, height);
  int eighths = 1;
  while (eighths < 8 && longer * eighths < 8 * least_px) ++eighths;
  return eighths;
}

Image8 Reduced(Image8 image, int eighths) {
  if (eighths >= 8 || image.empty()) return image;
  return Averaged(image, GridOfEighths(image.width, image.height, eighths));
}

Image8 ReadReduced(const std::filesystem::path& path, int channels, int eighths) {
  if (eighths >= 8) return ReadImage(path, channels);
  const ImageInfo info = ReadImageInfo(path);
  Image8 part;
  if (channels == 1 && IsGreyPng(info))
    part = ReadMask(path, info, GridOfEighths(info.width, info.height, eighths));
  else if (MayBeDecodedInPart(info, eighths))
    part = ReadJpeg(path, info, channels, eighths);
  return part.empty() ? Reduced(ReadImage(path, channels), eighths) : std::move(part);
}

Image8 ReadReducedTo(const std::filesystem::path& path, int channels, int longer_px) {
  const ImageInfo info = ReadImageInfo(path);
  const double scale = longer_px / static_cast<double>(std::max(info.width, info.height));
  if (scale >= 1) return ReadImage(path, channels);
  const int width = std::max(1, static_cast<int>(std::lround(scale * info.width))),
            height = std::max(1, static_cast<int>(std::lround(scale * info.height)));
  const auto grid = [&](int from_width, int from_height, int eighths) {
    return Grid{Tents(from_width, info.width * eighths / 8.0, width),
                Tents(from_height, info.height * eighths / 8.0, height)};
  };
  if (channels == 1 && IsGreyPng(info))
    if (Image8 mask = ReadMask(path, info, grid(info.width, info.height, 8)); !mask.empty())
      return mask;
  // Cosine terms alone show a fifth fewer features than means of pixels do.
  const int eighths = EighthsFor(info.width, info.height, longer_px + longer_px / 2);
  const Image8 part = ReadReduced(path, channels, eighths);
  return Averaged(part, grid(part.width, part.height, eighths));
}

}  // namespace keypose
