#include "core/io/pictures/film_kind.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <utility>

#include "core/io/pictures/picture_pages.h"
#include "core/io/text/files.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;
using std::string_view_literals::operator""sv;

constexpr std::array kFilms{
    ".mp4"sv,  ".mov"sv,  ".avi"sv,   ".mkv"sv,  ".m4v"sv,  ".mpg"sv,  ".mpeg"sv, ".webm"sv,
    ".ts"sv,   ".mts"sv,  ".m2ts"sv,  ".mxf"sv,  ".wmv"sv,  ".asf"sv,  ".flv"sv,  ".f4v"sv,
    ".ogv"sv,  ".ogm"sv,  ".gif"sv,   ".apng"sv, ".y4m"sv,  ".h264"sv, ".264"sv,  ".avc"sv,
    ".h265"sv, ".265"sv,  ".hevc"sv,  ".dv"sv,   ".dif"sv,  ".3gp"sv,  ".3g2"sv,  ".vob"sv,
    ".mod"sv,  ".tod"sv,  ".m2v"sv,   ".m1v"sv,  ".mpv"sv,  ".m2p"sv,  ".m2t"sv,  ".trp"sv,
    ".qt"sv,   ".divx"sv, ".xvid"sv,  ".rm"sv,   ".rmvb"sv, ".nut"sv,  ".ivf"sv,  ".obu"sv,
    ".av1"sv,  ".mjpg"sv, ".mjpeg"sv, ".swf"sv,  ".insv"sv, ".360"sv,  ".braw"sv, ".r3d"sv,
    ".crm"sv,  ".ari"sv,  ".nev"sv,   ".cine"sv, ".mlv"sv,  ".dav"sv,  ".wtv"sv,  ".amv"sv,
    ".m3u8"sv, ".m3u"sv,  ".mpd"sv,   ".yuv"sv,  ".i420"sv, ".nv12"sv, ".rgb"sv,  ".bgr"sv};
constexpr std::array kBarePixels{".yuv"sv, ".i420"sv, ".nv12"sv, ".rgb"sv, ".bgr"sv};
constexpr std::array kPlaylists{".m3u8"sv, ".m3u"sv, ".mpd"sv};
/// Of which the content may look like a film's.
constexpr std::array kNoFilms{
    ".lrv"sv,        ".lrf"sv,  ".glv"sv,  ".thm"sv,  ".m4a"sv,  ".m4b"sv,  ".m4p"sv,
    ".wma"sv,        ".mka"sv,  ".oga"sv,  ".ogg"sv,  ".opus"sv, ".wav"sv,  ".bak"sv,
    ".old"sv,        ".orig"sv, ".tmp"sv,  ".part"sv, ".jpg"sv,  ".jpeg"sv, ".png"sv,
    ".crdownload"sv, ".tif"sv,  ".tiff"sv, ".heic"sv, ".heif"sv, ".hif"sv,  ".avif"sv,
    ".cr3"sv,        ".jp2"sv,  ".jxl"sv,  ".aif"sv,  ".aiff"sv, ".3ga"sv,  ".blend"sv};

template <std::size_t N>
bool IsAmong(const fs::path& file, const std::array<std::string_view, N>& endings) {
  return std::find(endings.begin(), endings.end(), LowerExtension(file)) != endings.end();
}

std::string HeadOf(const fs::path& file) {
  std::string head(4096, '\0');
  std::ifstream in(file, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  return head;
}

/// Boxes of ISO/IEC 14496-12, in which pictures and sound are stored too.
bool IsFilmOfBoxes(std::string_view head) {
  if (head.size() < 12) return false;
  const std::string_view box = head.substr(4, 4), brand = head.substr(8, 4);
  if (box == "moov" || box == "mdat" || box == "wide" || box == "pnot") return true;
  if (box != "ftyp") return false;
  constexpr std::array kOthers{"heic"sv, "heix"sv, "heim"sv, "heis"sv, "hevc"sv, "hevx"sv,
                               "mif1"sv, "msf1"sv, "avif"sv, "avis"sv, "avci"sv, "jpeg"sv,
                               "crx "sv, "M4A "sv, "M4B "sv, "M4P "sv};
  return std::find(kOthers.begin(), kOthers.end(), brand) == kOthers.end();
}

/// Packets of 188 bytes that begin with 0x47, of a camera's with a time of four bytes before each.
bool IsTransportStream(std::string_view head) {
  const auto runs = [&](std::size_t first, std::size_t step) {
    constexpr std::size_t kPackets = 4;
    for (std::size_t i = 0; i < kPackets; ++i)
      if (first + i * step >= head.size() || head[first + i * step] != 0x47) return false;
    return true;
  };
  return runs(0, 188) || runs(4, 192);
}

bool IsOggVideo(std::string_view head) {
  return head.starts_with("OggS") && (head.find("\x80theora"sv) != std::string_view::npos ||
                                      head.find("BBCD\0"sv) != std::string_view::npos);
}

bool IsRiffVideo(std::string_view head) {
  return head.size() > 12 && head.starts_with("RIFF") && head.substr(8, 4) == "AVI ";
}

}  // namespace

std::string FilmKindOf(std::string_view head) {
  constexpr std::array<std::pair<std::string_view, const char*>, 14> kStarts{
      {{"\x1a\x45\xdf\xa3"sv, "Matroska or WebM"},
       {"FLV\1"sv, "Flash video"},
       {"GIF8"sv, "GIF"},
       {"YUV4MPEG2"sv, "YUV4MPEG"},
       {"\x30\x26\xb2\x75\x8e\x66\xcf\x11"sv, "Windows Media"},
       {"\0\0\1\xba"sv, "MPEG"},
       {"\0\0\1\xb3"sv, "MPEG"},
       {"\0\0\0\1\x67"sv, "a stream of H.264"},
       {"\0\0\0\1\x40\1"sv, "a stream of HEVC"},
       {"\x06\x0e\x2b\x34\x02\x05\x01\x01\x0d\x01\x02"sv, "MXF"},
       {".RMF"sv, "RealMedia"},
       {"DKIF"sv, "IVF"},
       {"\x1f\x07\0"sv, "DV"},
       {"nut/multimedia container"sv, "NUT"}}};
  for (const auto& [start, kind] : kStarts)
    if (head.starts_with(start)) return kind;
  if (IsFilmOfBoxes(head)) return "MP4 or QuickTime";
  if (IsRiffVideo(head)) return "AVI";
  if (IsOggVideo(head)) return "Ogg";
  return IsTransportStream(head) ? "MPEG-TS" : "";
}

bool IsFilmName(const fs::path& file) { return IsAmong(file, kFilms); }

bool IsFilm(const fs::path& file) {
  std::error_code error;
  if (!fs::is_regular_file(file, error) || error) return false;
  if (IsFilmName(file)) return true;
  if (IsAmong(file, kNoFilms) || file.filename().string().ends_with('~')) return false;
  const std::string head = HeadOf(file);
  return !FilmKindOf(head).empty() || IsAnimatedWebp(head);
}

std::string FilmFault(const fs::path& file) {
  const std::string name = PrintableName(file.filename());
  if (IsAmong(file, kPlaylists))
    return "is a playlist, not a film; join what it lists, as in\n  ffmpeg -i " + name +
           " -c copy joined.mp4\nand put the parts elsewhere";
  const std::string head = HeadOf(file);
  if (IsAnimatedWebp(head))
    return "is an animated WebP, which is not read; save it as GIF, APNG or MP4";
  if (IsAmong(file, kBarePixels) && FilmKindOf(head).empty())
    return "holds bare pictures without their size, format and rate; say these to ffmpeg, as in\n"
           "  ffmpeg -f rawvideo -pixel_format yuv420p -video_size 1920x1080 -framerate 25 -i " +
           name + " -c:v ffv1 film.mkv";
  return "";
}

}  // namespace keypose
