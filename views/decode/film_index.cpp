#include "views/decode/film_index.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "core/io/pictures/movie_header.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"
#include "views/decode/film_colors.h"
#include "views/decode/film_file.h"
#include "views/decode/film_pixels.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr double kInstant_s = 1e-6;
constexpr double kUsualRate = 25;  // of pictures without times

void StopIfAsked(const Progress* progress) {
  if (progress && progress->cancelled()) throw Cancelled();
}

/// Times of pictures in the stream's unit; not sorted.
struct Stamps {
  std::vector<std::int64_t> all;
  std::vector<std::int64_t> stored;  ///< when packets are decoded; may hold AV_NOPTS_VALUE
  bool sure = true;                  ///< each is that of one picture that is shown
  std::int64_t delay = 0;  ///< of the first picture, because its encoder stores others before it
};

bool IsMovieFormat(const FilmFile& film) {
  return std::string(film.format().iformat->name).find("mov") != std::string::npos;
}

/// Without an edit list, as fragmented MP4 often is, decoding begins at 0, and the first picture is
/// shown when those that are stored before it are decoded.
std::int64_t EncoderDelay(const FilmFile& film, std::int64_t first_decoded,
                          const std::vector<std::int64_t>& sorted) {
  if (!IsMovieFormat(film) || first_decoded != 0 || sorted.empty()) return 0;
  return std::max<std::int64_t>(0, sorted.front());
}

Stamps StampsOfPackets(FilmFile& film, const Progress* progress) {
  Stamps stamps;
  stamps.sure = film.stream().codecpar->codec_id != AV_CODEC_ID_VP8;  // has pictures for itself
  int packets = 0;
  std::int64_t first_decoded = AV_NOPTS_VALUE;
  while (const AVPacket* packet = film.NextPacket()) {
    StopIfAsked(progress);
    if (packets++ == 0) first_decoded = packet->dts;
    if ((packet->flags & AV_PKT_FLAG_DISCARD) != 0) continue;
    if (packet->pts == AV_NOPTS_VALUE) stamps.sure = false;
    stamps.all.push_back(packet->pts);
    stamps.stored.push_back(packet->dts);
  }
  const int entries = avformat_index_get_entries_count(&film.stream());
  if (IsMovieFormat(film) && packets < entries)
    film.Fail(fmt::format("is cut off: it has {} of {} pictures; copy or export it again", packets,
                          entries));
  std::sort(stamps.all.begin(), stamps.all.end());
  if (std::adjacent_find(stamps.all.begin(), stamps.all.end()) != stamps.all.end())
    stamps.sure = false;
  stamps.delay = EncoderDelay(film, first_decoded, stamps.all);
  return stamps;
}

/// By decoding all.
Stamps StampsOfFrames(const fs::path& path, const Progress* progress) {
  FilmFile film(path);
  Stamps stamps;
  while (const AVFrame* frame = film.NextFrame()) {
    StopIfAsked(progress);
    const std::int64_t stamp = frame->best_effort_timestamp;
    if (stamp == AV_NOPTS_VALUE || (!stamps.all.empty() && stamp <= stamps.all.back()))
      stamps.sure = false;
    stamps.all.push_back(stamp);
  }
  return stamps;
}

/// Streams that are cut from broadcasts count from anywhere.
std::int64_t ZeroOf(const FilmFile& film) {
  const bool anywhere = (film.format().iformat->flags & AVFMT_TS_DISCONT) != 0;
  if (!anywhere || film.format().start_time == AV_NOPTS_VALUE) return 0;
  return av_rescale_q(film.format().start_time, AV_TIME_BASE_Q, film.stream().time_base);
}

double HeaderRate(const AVStream& stream) {
  for (const AVRational rate : {stream.avg_frame_rate, stream.r_frame_rate})
    if (rate.num > 0 && rate.den > 0) return av_q2d(rate);
  return 0;
}

/// Of a container that says only when pictures are decoded, as AVI does: one is shown when the next
/// is decoded.
bool StoreTheirOrder(const Stamps& stamps) {
  const std::vector<std::int64_t>& stored = stamps.stored;
  return stored.size() == stamps.all.size() && stored.front() != AV_NOPTS_VALUE &&
         std::adjacent_find(stored.begin(), stored.end(), std::greater_equal<>()) == stored.end();
}

void Count(int pictures, double rate, FilmIndex* index) {
  for (int i = 0; i < pictures; ++i) index->times_s.push_back(i / rate);
  index->rate.per_second = rate;
  index->notes.push_back(fmt::format(
      "has no times; its pictures are taken for {:.4g} a second, as its header says", rate));
}

/// Bare streams have no times; libavformat invents them at a rate that nobody said.
void NoteInventedRate(const FilmFile& film, FilmIndex* index) {
  const AVInputFormat& format = *film.format().iformat;
  const bool is_av1 = std::string(format.name) == "obu";  // lacks the flag
  if (!is_av1 && (format.flags & AVFMT_NOTIMESTAMPS) == 0) return;
  index->notes.push_back(
      fmt::format("has no times and no rate; its pictures are taken for {:.4g} a second: if it has "
                  "another, put it into a file that says so, as in\n  ffmpeg -framerate RATE -i "
                  "FILM -c copy film.mkv",
                  index->rate.per_second));
}

void TakeTimes(const FilmFile& film, Stamps stamps, FilmIndex* index) {
  const double header = HeaderRate(film.stream());
  const double unit = av_q2d(film.stream().time_base);
  std::int64_t zero = ZeroOf(film) + stamps.delay;
  index->zero_s = static_cast<double>(zero) * unit;
  if (!stamps.sure && StoreTheirOrder(stamps)) {
    zero = stamps.stored.front();
    index->zero_s = static_cast<double>(zero) * unit;
    for (const std::int64_t stamp : stamps.stored)
      index->times_s.push_back(static_cast<double>(stamp - zero) * unit);
    index->rate = RateOf(index->times_s, header);
    return;
  }
  if (!stamps.sure) return Count(SizeOf(stamps.all), header > 0 ? header : kUsualRate, index);
  for (const std::int64_t stamp : stamps.all)
    index->times_s.push_back(static_cast<double>(stamp - zero) * unit);
  index->stamps = std::move(stamps.all);
  index->rate = RateOf(index->times_s, header);
  NoteInventedRate(film, index);
}

/// What of the film the first frame tells. Pictures before it lack what they are made from: the
/// film was cut there.
void TakeFirstFrame(const fs::path& path, Stamps* stamps, FilmIndex* index) {
  FilmFile film(path);
  const AVFrame* frame = film.NextFrame();
  if (!frame)
    film.Fail(fmt::format(
        "cannot be decoded (its codec is '{}'); convert it to H.264 in an .mp4, or to numbered "
        "pictures",
        avcodec_get_name(film.stream().codecpar->codec_id)));
  const bool turned = film.Orientation(*frame) > 4;
  index->width = turned ? frame->height : frame->width;
  index->height = turned ? frame->width : frame->height;
  index->has_alpha = HasAlpha(*frame);
  if (const std::string note = ColorNote(*frame); !note.empty()) index->notes.push_back(note);
  if (!stamps->sure) return;
  const auto first =
      std::lower_bound(stamps->all.begin(), stamps->all.end(), frame->best_effort_timestamp);
  stamps->all.erase(stamps->all.begin(), first);
}

}  // namespace

int FilmIndex::PictureAt(double time_s) const {
  const auto after = std::upper_bound(times_s.begin(), times_s.end(), time_s + kInstant_s);
  return std::max(0, static_cast<int>(after - times_s.begin()) - 1);
}

int FilmIndex::PictureNearest(double time_s) const {
  const int shown = PictureAt(time_s);
  if (shown + 1 >= frames()) return shown;
  const double before = std::abs(time_s - times_s[static_cast<std::size_t>(shown)]),
               after = times_s[static_cast<std::size_t>(shown) + 1] - time_s;
  return after < before - kInstant_s ? shown + 1 : shown;
}

bool IsFilmFile(const fs::path& path) {
  static const std::vector<std::string> pictures{
      ".png", ".jpg", ".jpeg", ".jfif", ".tif",  ".tiff", ".heic", ".heif", ".hif",
      ".exr", ".dpx", ".cin",  ".tga",  ".webp", ".bmp",  ".avif", ".jp2",  ".psd",
      ".cr2", ".cr3", ".nef",  ".arw",  ".dng",  ".raf",  ".orf",  ".rw2"};
  std::error_code error;
  return fs::is_regular_file(path, error) &&
         std::find(pictures.begin(), pictures.end(), LowerExtension(path)) == pictures.end();
}

FilmIndex ReadFilmIndex(const fs::path& path, const Progress* progress) {
  if (IsMovie(path)) RequireWholeMovie(path);
  FilmIndex index;
  FilmFile film(path);
  index.codec = avcodec_get_name(film.stream().codecpar->codec_id);
  Stamps stamps = StampsOfPackets(film, progress);
  TakeFirstFrame(path, &stamps, &index);
  if (!stamps.sure) {
    const std::vector<std::int64_t> stored = std::move(stamps.stored);
    stamps = StampsOfFrames(path, progress);
    stamps.stored = stored;
  }
  if (stamps.all.empty()) film.Fail("has no pictures; copy or export it again");
  TakeTimes(film, std::move(stamps), &index);
  return index;
}

}  // namespace keypose
