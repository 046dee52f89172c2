#include "views/decode/film_file.h"

extern "C" {
#include <libavutil/display.h>
#include <libavutil/dovi_meta.h>
#include <libavutil/pixdesc.h>
#include <libavutil/stereo3d.h>
}

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/io/pictures/film_kind.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "views/decode/film_colors.h"
#include "views/decode/film_turn.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr const char* kConvert = "; convert it to H.264 in an .mp4, or to numbered pictures";

/// That a decoder may report after the last packet.
constexpr int kMostFaults = 100;

/// Formats that are lists of other files, also on other machines.
const std::set<std::string> kLists{"hls", "dash", "concat", "concatf", "imf", "sdp", "rtsp"};

/// Formats in which libavformat shows a picture or a text as a film.
bool IsNoFilm(const std::string& format) {
  static const std::set<std::string> texts{"tty", "bin", "xbin", "adf", "idf", "image2"};
  return texts.contains(format) || format.ends_with("_pipe");
}

std::string CodecOf(const AVStream& stream) {
  char tag[AV_FOURCC_MAX_STRING_SIZE];
  return av_fourcc_make_string(tag, stream.codecpar->codec_tag);
}

/// libav's own decoders of VP8 and VP9 leave alpha out.
const AVCodec* DecoderOf(const AVStream& stream) {
  const AVCodecID id = stream.codecpar->codec_id;
  const AVDictionaryEntry* alpha = av_dict_get(stream.metadata, "alpha_mode", nullptr, 0);
  const bool has_alpha = alpha && std::string(alpha->value) == "1";
  if (has_alpha && id == AV_CODEC_ID_VP8) return avcodec_find_decoder_by_name("libvpx");
  if (has_alpha && id == AV_CODEC_ID_VP9) return avcodec_find_decoder_by_name("libvpx-vp9");
  return avcodec_find_decoder(id);
}

bool IsInterlaced(const AVStream& stream, const AVFrame& frame) {
  switch (stream.codecpar->field_order) {
    case AV_FIELD_TT:
    case AV_FIELD_BB:
    case AV_FIELD_TB:
    case AV_FIELD_BT:
      return true;
    default:
      return frame.interlaced_frame != 0;
  }
}

bool IsGrey(const AVFrame& frame) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  return format && format->nb_components < 3 && (format->flags & AV_PIX_FMT_FLAG_PAL) == 0;
}

/// Codecs of television, whose grey has its range where none is said.
bool IsTelevision(AVCodecID codec) {
  return codec == AV_CODEC_ID_H264 || codec == AV_CODEC_ID_HEVC || codec == AV_CODEC_ID_AV1 ||
         codec == AV_CODEC_ID_VP9;
}

const DisplayMatrix* MatrixIn(const std::uint8_t* data) {
  return reinterpret_cast<const DisplayMatrix*>(data);
}

}  // namespace

void FilmFile::Fail(const std::string& what) const {
  throw InputError("the video " + PrintableName(path_) + " " + what);
}

FilmFile::FilmFile(const fs::path& path)
    : path_(path), packet_(av_packet_alloc()), frame_(av_frame_alloc()) {
  std::error_code error;
  if (!fs::is_regular_file(path, error))
    throw DiskError("cannot read the video " + PrintableName(path));
  if (const std::string fault = FilmFault(path); !fault.empty()) Fail(fault);
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* opened = nullptr;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const int code =
      avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  format_.reset(opened);
  if (code == AVERROR(EACCES) || code == AVERROR(EIO))
    throw DiskError("cannot read the video " + PrintableName(path));
  if (code < 0 || kLists.contains(format_->iformat->name) || IsNoFilm(format_->iformat->name))
    Fail(std::string("cannot be decoded: it is no film that libavformat knows") + kConvert);
  if (avformat_find_stream_info(format_.get(), nullptr) < 0)
    Fail(std::string("cannot be decoded: its header is damaged") + kConvert);
  FindVideo();
  RequireFlat();
}

void FilmFile::FindVideo() {
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    AVStream* stream = format_->streams[i];
    const bool video = stream->codecpar->codec_type == AVMEDIA_TYPE_VIDEO &&
                       (stream->disposition & AV_DISPOSITION_ATTACHED_PIC) == 0;
    if (video && !stream_) stream_ = stream;
    if (stream != stream_) stream->discard = AVDISCARD_ALL;
  }
  if (!stream_) Fail(std::string("has no video track") + kConvert);
}

void FilmFile::RequireFlat() const {
  if (av_stream_get_side_data(stream_, AV_PKT_DATA_SPHERICAL, nullptr))
    Fail("shows a whole sphere (360 degrees), which no lens of ours does; export flat views of it");
  const auto* stereo = reinterpret_cast<const AVStereo3D*>(
      av_stream_get_side_data(stream_, AV_PKT_DATA_STEREO3D, nullptr));
  if (stereo && stereo->type != AV_STEREO3D_2D)
    Fail("holds the pictures of two eyes; export a film for each eye");
  const auto* dolby = reinterpret_cast<const AVDOVIDecoderConfigurationRecord*>(
      av_stream_get_side_data(stream_, AV_PKT_DATA_DOVI_CONF, nullptr));
  if (dolby && dolby->dv_profile == 5)
    Fail("is HDR (Dolby Vision, profile 5), which is not read; film with HDR off");
}

void FilmFile::OpenDecoder() {
  const AVCodec* codec = DecoderOf(*stream_);
  if (!codec)
    Fail(fmt::format("cannot be decoded (its codec is '{}'): there is no decoder for it{}",
                     CodecOf(*stream_), kConvert));
  decoder_.reset(avcodec_alloc_context3(codec));
  avcodec_parameters_to_context(decoder_.get(), stream_->codecpar);
  decoder_->pkt_timebase = stream_->time_base;
  decoder_->thread_count = 0;  // as many as there are cores
  if (avcodec_open2(decoder_.get(), codec, nullptr) < 0)
    Fail(fmt::format("cannot be decoded (its codec is '{}'){}", CodecOf(*stream_), kConvert));
}

const AVPacket* FilmFile::NextPacket() {
  for (;;) {
    av_packet_unref(packet_.get());
    if (av_read_frame(format_.get(), packet_.get()) < 0) return nullptr;
    if (packet_->stream_index == stream_->index) return packet_.get();
  }
}

void FilmFile::SendPacket() {
  // What a packet's data lack shows in the frames that come, or do not.
  const AVPacket* packet = NextPacket();
  ended_ = !packet;
  avcodec_send_packet(decoder_.get(), packet);
}

const AVFrame* FilmFile::NextFrame() {
  if (!decoder_) OpenDecoder();
  for (;;) {
    const int code = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (code >= 0) {
      Check(*frame_);
      return frame_.get();
    }
    if (code == AVERROR_EOF || (ended_ && code != AVERROR(EAGAIN) && ++faults_ > kMostFaults))
      return nullptr;
    SendPacket();
  }
}

void FilmFile::Check(AVFrame& frame) {
  if (IsInterlaced(*stream_, frame))
    Fail(
        "is interlaced: every other row was filmed at another moment; make it progressive, as in\n"
        "  ffmpeg -i FILM -vf bwdif=mode=send_frame OTHER\n"
        "or, if the camera filmed whole pictures and only says otherwise, with -vf setfield=prog "
        "and a codec of whole pictures");
  const AVRational aspect = av_guess_sample_aspect_ratio(format_.get(), stream_, &frame);
  if (aspect.num > 0 && aspect.den > 0 && std::abs(frame.width * av_q2d(aspect) - frame.width) >= 1)
    Fail(fmt::format(
        "has pixels that are not square ({}:{}); convert it, as in\n  ffmpeg -i FILM -vf "
        "scale=iw*sar:ih,setsar=1 OTHER",
        aspect.num, aspect.den));
  if (const std::string fault = ColorFault(frame); !fault.empty()) Fail(fault);
  if (count_++ == 0) {
    width_ = frame.width;
    height_ = frame.height;
  }
  if (frame.width != width_ || frame.height != height_)
    Fail(fmt::format("changes its size from {} x {} to {} x {} pixels at picture {}; cut it there",
                     width_, height_, frame.width, frame.height, count_ - 1));
  if (IsGrey(frame) && IsTelevision(stream_->codecpar->codec_id) &&
      frame.color_range == AVCOL_RANGE_UNSPECIFIED)
    frame.color_range = AVCOL_RANGE_MPEG;
}

int FilmFile::Orientation(const AVFrame& frame) const {
  const DisplayMatrix* matrix =
      MatrixIn(av_stream_get_side_data(stream_, AV_PKT_DATA_DISPLAYMATRIX, nullptr));
  if (const AVFrameSideData* own = av_frame_get_side_data(&frame, AV_FRAME_DATA_DISPLAYMATRIX);
      own && !matrix)
    matrix = MatrixIn(own->data);
  if (!matrix) return 1;
  if (const auto orientation = OrientationOf(*matrix)) return *orientation;
  Fail(
      fmt::format("is to be shown turned by {:.1f} degrees; only quarter turns are read: export it "
                  "upright",
                  TurnOf(*matrix)));
}

}  // namespace keypose
