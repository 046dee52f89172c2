#include "core/testing/dng.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/io/text/files.h"

namespace keypose {
namespace {

void Put(std::string& bytes, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

/// The entries of a TIFF directory, little-endian.
class Directory {
 public:
  void Short(int tag, const std::vector<int>& values) {
    std::string data;
    for (const int value : values) Put(data, static_cast<std::uint32_t>(value), 2);
    Add(tag, 3, values.size(), data);
  }
  void Long(int tag, std::uint32_t value) {
    std::string data;
    Put(data, value, 4);
    Add(tag, 4, 1, data);
  }
  void Bytes(int tag, const std::string& data) { Add(tag, 1, data.size(), data); }
  void Text(int tag, const std::string& text) { Add(tag, 2, text.size() + 1, text + '\0'); }
  /// @param type  5 unsigned, 10 signed
  void Fractions(int tag, int type, const std::vector<double>& values) {
    std::string data;
    for (const double value : values) {
      Put(data, static_cast<std::uint32_t>(std::lround(value * 10000)), 4);
      Put(data, 10000, 4);
    }
    Add(tag, type, values.size(), data);
  }
  /// Header, directory, long values; the pixels follow.
  std::string Done() const {
    const std::size_t directory = 8, count = entries_.size();
    std::size_t place = directory + 2 + 12 * count + 4;
    std::string bytes = "II", after;
    Put(bytes, 42, 2), Put(bytes, directory, 4), Put(bytes, static_cast<std::uint32_t>(count), 2);
    for (const Entry& entry : entries_) {
      Put(bytes, static_cast<std::uint32_t>(entry.tag), 2);
      Put(bytes, static_cast<std::uint32_t>(entry.type), 2);
      Put(bytes, static_cast<std::uint32_t>(entry.count), 4);
      std::string data = entry.data;
      if (data.size() <= 4) {
        data.resize(4, '\0');
        bytes += data;
        continue;
      }
      if (data.size() % 2) data += '\0';
      Put(bytes, static_cast<std::uint32_t>(place + after.size()), 4);
      after += data;
    }
    Put(bytes, 0, 4);
    return bytes + after;
  }

 private:
  struct Entry {
    int tag, type;
    std::size_t count;
    std::string data;
  };
  void Add(int tag, int type, std::size_t count, const std::string& data) {
    entries_.push_back({tag, type, count, data});
  }
  std::vector<Entry> entries_;
};

std::string Mosaic(const ImageF& linear, const DngOptions& options) {
  std::string pixels;
  for (int y = 0; y < linear.height; ++y)
    for (int x = 0; x < linear.width; ++x) {
      const int channel = (x & 1) + (y & 1);  // R G / G B
      const double value =
          std::clamp(linear.at(x, y)[channel] * options.neutral[channel], 0.0, 1.0);
      Put(pixels, static_cast<std::uint32_t>(std::lround(65535 * value)), 2);
    }
  return pixels;
}

Directory Tags(const ImageF& linear, const DngOptions& options, std::uint32_t pixels_at) {
  Directory tags;
  tags.Long(254, 0);
  tags.Long(256, static_cast<std::uint32_t>(linear.width));
  tags.Long(257, static_cast<std::uint32_t>(linear.height));
  tags.Short(258, {16});
  tags.Short(259, {1});
  tags.Short(262, {32803});  // a colour filter array
  tags.Text(271, "Keypose");
  tags.Text(272, "Test");
  tags.Long(273, pixels_at);
  tags.Short(274, {options.orientation});
  tags.Short(277, {1});
  tags.Long(278, static_cast<std::uint32_t>(linear.height));
  tags.Long(279, static_cast<std::uint32_t>(2 * linear.width * linear.height));
  tags.Short(284, {1});
  tags.Short(33421, {2, 2});
  tags.Bytes(33422, std::string("\0\1\1\2", 4));
  tags.Bytes(50706, std::string("\1\4\0\0", 4));
  tags.Text(50708, "Keypose Test");
  tags.Short(50714, {0});
  tags.Long(50717, 65535);
  // XYZ to linear sRGB (IEC 61966-2-1): this camera sees as a screen shows.
  tags.Fractions(50721, 10,
                 {3.2406, -1.5372, -0.4986, -0.9689, 1.8758, 0.0415, 0.0557, -0.2040, 1.0570});
  tags.Fractions(50728, 5, {options.neutral.begin(), options.neutral.end()});
  tags.Short(50778, {21});  // D65
  return tags;
}

}  // namespace

void WriteDng(const std::filesystem::path& file, const ImageF& linear, const DngOptions& options) {
  const std::size_t header = Tags(linear, options, 0).Done().size();
  const Directory tags = Tags(linear, options, static_cast<std::uint32_t>(header));
  WriteFile(file, tags.Done() + Mosaic(linear, options));
}

}  // namespace keypose
