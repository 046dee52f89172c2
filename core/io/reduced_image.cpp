#include "core/io/reduced_image.h"

// jpeglib.h needs size_t and FILE from here.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/image_turns.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/image_kind.h"

namespace keypose {
namespace {

int PartOf(int size, int eighths) { return (size * eighths + 7) / 8; }

/// The pixels that one pixel of the reduced picture covers along one axis, with their weights.
struct Footprint {
  int first = 0;
  std::vector<float> weights;
};

std::vector<Footprint> Footprints(int size, int eighths) {
  std::vector<Footprint> footprints(static_cast<std::size_t>(PartOf(size, eighths)));
  const double step = 8.0 / eighths;
  for (std::size_t k = 0; k < footprints.size(); ++k) {
    const double begin = static_cast<double>(k) * step, end = begin + step;
    footprints[k].first = static_cast<int>(begin);
    for (int i = footprints[k].first; i < end; ++i)
      footprints[k].weights.push_back(
          static_cast<float>((std::min<double>(i + 1, end) - std::max<double>(i, begin)) / step));
  }
  return footprints;
}

/// One row of the reduced picture before its columns are joined.
void AddRows(const Image8& image, const Footprint& rows, std::vector<float>* sums) {
  const std::size_t stride = static_cast<std::size_t>(image.width) * image.channels;
  sums->assign(stride, 0);
  for (std::size_t j = 0; j < rows.weights.size(); ++j) {
    const int y = std::min(rows.first + static_cast<int>(j), image.height - 1);
    const std::uint8_t* row = image.at(0, y);
    const float weight = rows.weights[j];
    for (std::size_t i = 0; i < stride; ++i) (*sums)[i] += weight * row[i];
  }
}

/// @param sums  of a row of the picture, whose last pixel is repeated
void JoinColumns(const std::vector<float>& sums, const std::vector<Footprint>& columns,
                 int channels, std::uint8_t* out) {
  const int last = static_cast<int>(sums.size()) / channels - 1;
  for (const Footprint& footprint : columns)
    for (int c = 0; c < channels; ++c) {
      float sum = 0;
      for (std::size_t i = 0; i < footprint.weights.size(); ++i) {
        const int from = std::min(footprint.first + static_cast<int>(i), last);
        sum += footprint.weights[i] * sums[static_cast<std::size_t>(from * channels + c)];
      }
      *out++ = static_cast<std::uint8_t>(std::lround(sum));
    }
}

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
  info.scale_num = static_cast<unsigned>(eighths), info.scale_denom = 8;
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

/// A picture that is stored turned has its last column or row, which may cover only a part of a
/// pixel, on another side.
bool MayBeDecodedInPart(const ImageInfo& info, int eighths) {
  return info.format == "jpeg" && (info.orientation == 1 || (info.width * eighths % 8 == 0 &&
                                                             info.height * eighths % 8 == 0));
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
  const std::vector<Footprint> columns = Footprints(image.width, eighths),
                               rows = Footprints(image.height, eighths);
  Image8 out(static_cast<int>(columns.size()), static_cast<int>(rows.size()), image.channels);
  std::vector<float> sums;
  for (int y = 0; y < out.height; ++y) {
    AddRows(image, rows[static_cast<std::size_t>(y)], &sums);
    JoinColumns(sums, columns, out.channels, out.at(0, y));
  }
  return out;
}

Image8 ReadReduced(const std::filesystem::path& path, int channels, int eighths) {
  if (eighths >= 8) return ReadImage(path, channels);
  const ImageInfo info = ReadImageInfo(path);
  if (MayBeDecodedInPart(info, eighths)) {
    const std::string bytes = ReadFile(path);
    if (IsWholeImage(bytes, "jpeg"))
      if (Image8 part = PartOfJpeg(bytes, channels, eighths); !part.empty())
        return Oriented(std::move(part), info.orientation);
  }
  return Reduced(ReadImage(path, channels), eighths);
}

}  // namespace keypose
