#include "core/io/pictures/movie_header.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/io/text/files.h"
#include "core/numbers/picture_times.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kLargestIndex = std::uint64_t{1} << 28;  // bytes; an hour needs about 1 MB
constexpr int kMostFrames = 10'000'000;

/// Part of a file, with whole numbers that have their highest byte first.
class Bytes {
 public:
  explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

  std::size_t size() const { return bytes_.size(); }
  /// Nothing where the bytes end before.
  std::optional<std::uint64_t> Number(std::size_t at, std::size_t length) const {
    if (at > size() || length > size() - at) return {};
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < length; ++i)
      number = number << 8 | static_cast<unsigned char>(bytes_[at + i]);
    return number;
  }
  std::string_view Part(std::size_t at, std::size_t length) const {
    return at > size() ? std::string_view() : bytes_.substr(at, length);
  }

  /// The n-th box of a kind among those that these bytes consist of; nothing where there is none.
  std::optional<Bytes> Box(std::string_view kind, int n = 0) const {
    for (std::size_t at = 0; at < size();) {
      std::uint64_t length = Number(at, 4).value_or(0), head = 8;
      if (length == 1) {
        length = Number(at + 8, 8).value_or(0);
        head = 16;
      }
      if (length == 0) length = size() - at;
      if (length < head || length > size() - at) return {};
      if (Part(at + 4, 4) == kind && n-- == 0) return Bytes(Part(at + head, length - head));
      at += length;
    }
    return {};
  }

 private:
  std::string_view bytes_;
};

bool IsKind(std::string_view kind) {
  return std::all_of(kind.begin(), kind.end(),
                     [](unsigned char c) { return c == 0xa9 || (c >= ' ' && c <= '~'); });
}

class MovieFile {
 public:
  explicit MovieFile(const fs::path& path) : path_(path), file_(path, std::ios::binary) {
    std::error_code error;
    size_ = fs::file_size(path, error);
    if (error || !file_) throw DiskError("cannot read the video " + PrintableName(path));
  }

  [[noreturn]] void Fail(const std::string& what) const {
    throw InputError("the video " + PrintableName(path_) + " " + what);
  }

  /// The index of the film. All boxes are walked, so that a file that was cut off is noticed.
  std::string Index() {
    std::string index;
    bool media = false;
    std::uint64_t at = 0;
    while (at < size_) {
      const std::string start = Read(at, std::min<std::uint64_t>(16, size_ - at));
      const Bytes head(start);
      std::uint64_t length = head.Number(0, 4).value_or(0), skipped = 8;
      if (length == 1) {
        length = head.Number(8, 8).value_or(0);
        skipped = 16;
      }
      if (length == 0) length = size_ - at;
      const std::string kind(head.Part(4, 4));
      if (kind.size() < 4 || !IsKind(kind)) {
        if (!index.empty() && media) break;  // notes of the camera's own behind a whole film
        Fail("is damaged" + Again());
      }
      media = media || kind == "mdat";
      if (length < skipped || length > size_ - at)
        Fail(fmt::format("is cut off: it has {} of {} bytes or more", size_,
                         length > size_ ? length : at + std::max(length, skipped)) +
             Again());
      if (kind == "moov" && index.empty()) {
        if (length > kLargestIndex) Fail("has an index of more than 256 MB" + Convert());
        index = Read(at + skipped, length - skipped);
      }
      at += length;
    }
    if (index.empty())
      Fail("has no index (moov): the recording was not ended, or the file was cut off" + Again());
    return index;
  }

  static std::string Convert() { return "; convert it to an .mp4, or to numbered pictures"; }
  static std::string Again() { return "; copy or export it again"; }

 private:
  std::string Read(std::uint64_t at, std::uint64_t length) {
    std::string bytes(length, '\0');
    file_.seekg(static_cast<std::streamoff>(at));
    if (!file_.read(bytes.data(), static_cast<std::streamsize>(length)))
      throw DiskError("cannot read the video " + PrintableName(path_));
    return bytes;
  }

  fs::path path_;
  std::ifstream file_;
  std::uint64_t size_ = 0;
};

/// Pictures, and the sum of their times in the track's unit.
struct Times {
  std::uint64_t frames = 0, duration = 0;
};

std::optional<Times> TimesOf(const Bytes& table) {
  const auto entries = table.Number(4, 4);
  if (!entries || *entries > table.size() / 8) return {};
  Times times;
  for (std::uint64_t i = 0; i < *entries; ++i) {
    const auto count = table.Number(8 + 8 * i, 4), each = table.Number(12 + 8 * i, 4);
    if (!count || !each) return {};
    times.frames += *count;
    times.duration += *count * *each;
  }
  return times;
}

/// The values of a table whose entries are a count and a value, one for each picture.
class RunLengths {
 public:
  explicit RunLengths(std::optional<Bytes> table) : table_(table) {}
  /// 0 without a table, and after its end.
  std::uint32_t Next() {
    while (left_ == 0) {
      const auto count = table_ ? table_->Number(8 + 8 * entry_, 4) : std::nullopt,
                 value = table_ ? table_->Number(12 + 8 * entry_, 4) : std::nullopt;
      if (!count || !value) return 0;
      left_ = *count;
      value_ = static_cast<std::uint32_t>(*value);
      ++entry_;
    }
    --left_;
    return value_;
  }

 private:
  std::optional<Bytes> table_;
  std::size_t entry_ = 0;
  std::uint64_t left_ = 0;
  std::uint32_t value_ = 0;
};

/// A part of a track that is shown [the track's unit of time].
struct Edit {
  double start = 0, end = 0;
};

/// The parts that an edit list lets through, without pauses; empty: all is shown.
/// @param unit  of the film's own time, which durations have, in the track's
std::vector<Edit> EditsOf(const Bytes& track, double unit) {
  constexpr std::uint64_t kMostEdits = 100;
  std::vector<Edit> edits;
  const auto box = track.Box("edts");
  const auto list = box ? box->Box("elst") : box;
  const std::uint64_t count = list ? list->Number(4, 4).value_or(0) : 0;
  if (count > kMostEdits) return edits;
  const std::size_t wide = list && list->Number(0, 1) == 1 ? 8 : 4;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = 8 + i * (2 * wide + 4);
    const auto duration = list->Number(at, wide), start = list->Number(at + wide, wide);
    if (!duration || !start) return {};
    const auto pause = wide == 8 ? std::int64_t{-1} : std::int64_t{0xffffffff};
    if (static_cast<std::int64_t>(*start) == pause) continue;
    const double begin = static_cast<double>(*start);
    // Without a duration it goes on to the end.
    const double length = *duration ? static_cast<double>(*duration) * unit : 1e18;
    edits.push_back({begin, begin + length});
  }
  return edits;
}

/// When pictures are shown [the track's unit of time], ascending.
std::vector<double> AllTimes(const Bytes& tables, std::uint64_t frames) {
  RunLengths durations(tables.Box("stts")), offsets(tables.Box("ctts"));
  std::vector<double> times;
  double decoded = 0;
  for (std::uint64_t i = 0; i < frames; ++i) {
    times.push_back(decoded + static_cast<std::int32_t>(offsets.Next()));
    decoded += durations.Next();
  }
  std::sort(times.begin(), times.end());
  return times;
}

/// Programs that trim a film without compressing it anew leave all pictures in the file, and say
/// which are shown. Decoders give only those.
std::vector<double> ShownTimes(const std::vector<Edit>& edits, const std::vector<double>& all) {
  if (edits.empty()) return all;
  std::vector<double> shown;
  for (const double at : all)
    if (std::any_of(edits.begin(), edits.end(),
                    [&](const Edit& edit) { return at >= edit.start && at < edit.end; }))
      shown.push_back(at);
  return shown.empty() ? all : shown;
}

/// Whether a player shows the track turned by a quarter, as telephones film upright.
bool IsQuarterTurned(const Bytes& track) {
  const auto box = track.Box("tkhd");
  const std::size_t matrix = box && box->Number(0, 1) == 1 ? 52 : 40;
  const auto entry = [&](std::size_t i) {
    return box ? box->Number(matrix + 4 * i, 4).value_or(0) : 0;
  };
  return entry(0) == 0 && entry(4) == 0 && entry(1) != 0 && entry(3) != 0;
}

/// The header of a track; nothing where it is no video.
/// @param movie_unit  the film's units of time in a second
std::optional<MovieHeader> HeaderOf(const MovieFile& file, const Bytes& track, double movie_unit) {
  const auto media = track.Box("mdia");
  const auto handler = media ? media->Box("hdlr") : media;
  if (!handler || handler->Part(8, 4) != "vide") return {};
  const auto times_header = media->Box("mdhd"), info = media->Box("minf");
  const auto tables = info ? info->Box("stbl") : info;
  const auto kinds = tables ? tables->Box("stsd") : tables;
  const auto table = tables ? tables->Box("stts") : tables;
  if (!times_header || !kinds || !table) file.Fail("is damaged" + MovieFile::Again());
  const bool wide = times_header->Number(0, 1) == 1;
  const auto unit = times_header->Number(wide ? 20 : 12, 4);
  const auto width = kinds->Number(40, 2), height = kinds->Number(42, 2);
  const auto times = TimesOf(*table);
  if (!unit || !width || !height || !times) file.Fail("is damaged" + MovieFile::Again());
  if (times->frames == 0) file.Fail("has no pictures in its index" + MovieFile::Convert());
  if (times->frames > kMostFrames || times->duration == 0 || *unit == 0)
    file.Fail("is damaged" + MovieFile::Again());
  MovieHeader header;
  const auto edits = EditsOf(track, movie_unit > 0 ? static_cast<double>(*unit) / movie_unit : 0);
  std::vector<double> shown = ShownTimes(edits, AllTimes(*tables, times->frames));
  for (double& time : shown) time /= static_cast<double>(*unit);
  const double mean = static_cast<double>(*unit) * static_cast<double>(times->frames) /
                      static_cast<double>(times->duration);
  const PictureRate rate = RateOf(shown, mean);
  header.frames = static_cast<int>(shown.size());
  header.fps = rate.per_second;
  header.last_frame = FrameNumbers(shown, rate).back();
  header.width = static_cast<int>(*width);
  header.height = static_cast<int>(*height);
  if (IsQuarterTurned(track)) std::swap(header.width, header.height);
  header.codec = WithoutOddBytes(std::string(kinds->Part(12, 4)));
  return header;
}

}  // namespace

void RequireWholeMovie(const fs::path& path) { MovieFile(path).Index(); }

bool IsMovie(const fs::path& path) {
  std::error_code error;
  if (!fs::is_regular_file(path, error) || error) return false;
  std::ifstream file(path, std::ios::binary);
  char head[8] = {};
  if (!file.read(head, sizeof head)) return false;
  const std::string_view kind(head + 4, 4);
  return kind == "ftyp" || kind == "moov" || kind == "mdat" || kind == "wide" || kind == "free" ||
         kind == "skip" || kind == "pnot";
}

MovieHeader ReadMovieHeader(const fs::path& path) {
  MovieFile file(path);
  const std::string index = file.Index();
  const Bytes boxes(index);
  const auto movie = boxes.Box("mvhd");
  const bool wide = movie && movie->Number(0, 1) == 1;
  const auto unit = movie ? movie->Number(wide ? 20 : 12, 4) : std::nullopt;
  for (int n = 0;; ++n) {
    const auto track = boxes.Box("trak", n);
    if (!track) break;
    if (const auto header = HeaderOf(file, *track, static_cast<double>(unit.value_or(0))))
      return *header;
  }
  file.Fail("has no video track" + MovieFile::Convert());
}

}  // namespace keypose
