// Small films for tests, written by libav: each picture holds its number as bits, or what a test
// paints.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/values/image.h"
#include "views/decode/film_turn.h"
#include "views/film/libav.h"

namespace keypose {

struct TestFilmKind {
  std::string codec = "ffv1";
  AVPixelFormat pixels = AV_PIX_FMT_YUV420P;
  int width = 128, height = 32;
  int rate = 30;       ///< that the header says
  int unit = 90000;    ///< of the times that Add takes, in a second
  std::string format;  ///< libav's name; empty: by the file's ending
  std::vector<std::pair<std::string, std::string>> codec_options, format_options;
  AVColorSpace matrix = AVCOL_SPC_UNSPECIFIED;
  AVColorTransferCharacteristic transfer = AVCOL_TRC_UNSPECIFIED;
  AVRational aspect{0, 1};
  AVFieldOrder fields = AV_FIELD_UNKNOWN;
  DisplayMatrix turn{};  ///< all 0: none is written
  int sound_rate = 0;    ///< samples a second of one channel, 16 bits (PCM); 0: no sound
};

class TestFilm {
 public:
  TestFilm(const std::filesystem::path& path, TestFilmKind kind)
      : kind_(std::move(kind)), packet_(av_packet_alloc()), frame_(av_frame_alloc()) {
    av_log_set_level(AV_LOG_QUIET);
    const char* format = kind_.format.empty() ? nullptr : kind_.format.c_str();
    Need(avformat_alloc_output_context2(&file_, nullptr, format, path.c_str()));
    Need(avio_open(&file_->pb, path.c_str(), AVIO_FLAG_WRITE));
    OpenEncoder();
    Begin();
  }
  ~TestFilm() {
    avio_closep(&file_->pb);
    avformat_free_context(file_);
  }
  TestFilm(const TestFilm&) = delete;
  TestFilm& operator=(const TestFilm&) = delete;

  static bool CanWrite(const std::string& codec) {
    return avcodec_find_encoder_by_name(codec.c_str()) != nullptr;
  }

  /// A picture that is painted by the test.
  /// @param time  in the kind's units
  void Add(std::int64_t time, const std::function<void(AVFrame&)>& paint) {
    Need(av_frame_make_writable(frame_.get()));
    paint(*frame_);
    frame_->pts = time;
    Send(frame_.get());
  }
  /// A picture that holds a number: eight bits as bright and dark columns of 16 pixels.
  void AddNumber(std::int64_t time, int number) {
    Add(time, [&](AVFrame& frame) {
      for (int y = 0; y < frame.height; ++y)
        for (int x = 0; x < frame.width; ++x)
          frame.data[0][y * frame.linesize[0] + x] = number >> (x / 16) & 1 ? 220 : 30;
      for (int plane = 1; plane < 3; ++plane)
        for (int i = 0; i < frame.linesize[plane] * frame.height / 2; ++i)
          frame.data[plane][i] = 128;
    });
  }
  /// Sound before any picture; samples in [-1, 1].
  /// @param first  number of the first sample: its time
  void AddSound(const std::vector<double>& samples, std::int64_t first = 0) {
    for (std::size_t begin = 0; begin < samples.size(); begin += 1024) {
      const int count = static_cast<int>(std::min<std::size_t>(1024, samples.size() - begin));
      Need(av_new_packet(packet_.get(), 2 * count));
      for (int i = 0; i < count; ++i) {
        const int level = static_cast<int>(std::lround(32767 * samples[begin + i]));
        packet_->data[2 * i] = static_cast<std::uint8_t>(level & 255);
        packet_->data[2 * i + 1] = static_cast<std::uint8_t>(level >> 8 & 255);
      }
      packet_->stream_index = 1;
      packet_->pts = packet_->dts = first + static_cast<std::int64_t>(begin);
      packet_->duration = count;
      av_packet_rescale_ts(packet_.get(), {1, kind_.sound_rate}, file_->streams[1]->time_base);
      Need(av_interleaved_write_frame(file_, packet_.get()));
    }
  }
  void Finish() {
    Send(nullptr);
    Need(av_write_trailer(file_));
    avio_flush(file_->pb);
  }

 private:
  static void Need(int code) {
    if (code < 0) throw std::runtime_error("test film: " + AvText(code));
  }
  void OpenEncoder() {
    const AVCodec* codec = avcodec_find_encoder_by_name(kind_.codec.c_str());
    encoder_.reset(avcodec_alloc_context3(codec));
    encoder_->width = kind_.width;
    encoder_->height = kind_.height;
    encoder_->pix_fmt = kind_.pixels;
    encoder_->time_base = {1, kind_.unit};
    encoder_->framerate = {kind_.rate, 1};
    encoder_->colorspace = kind_.matrix;
    encoder_->color_trc = kind_.transfer;
    encoder_->sample_aspect_ratio = kind_.aspect;
    encoder_->field_order = kind_.fields;
    encoder_->thread_count = 1;
    encoder_->strict_std_compliance = FF_COMPLIANCE_UNOFFICIAL;
    if (file_->oformat->flags & AVFMT_GLOBALHEADER) encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER;
    for (const auto& [key, value] : kind_.codec_options)
      Need(av_opt_set(encoder_->priv_data, key.c_str(), value.c_str(), 0));
    Need(avcodec_open2(encoder_.get(), codec, nullptr));
    frame_->format = kind_.pixels;
    frame_->width = kind_.width;
    frame_->height = kind_.height;
    Need(av_frame_get_buffer(frame_.get(), 0));
  }
  void Begin() {
    stream_ = avformat_new_stream(file_, nullptr);
    Need(avcodec_parameters_from_context(stream_->codecpar, encoder_.get()));
    stream_->codecpar->field_order = kind_.fields;
    stream_->time_base = encoder_->time_base;
    stream_->avg_frame_rate = encoder_->framerate;
    stream_->sample_aspect_ratio = kind_.aspect;
    if (kind_.pixels == AV_PIX_FMT_YUVA420P) av_dict_set(&stream_->metadata, "alpha_mode", "1", 0);
    if (kind_.turn != DisplayMatrix{})
      *reinterpret_cast<DisplayMatrix*>(av_stream_new_side_data(
          stream_, AV_PKT_DATA_DISPLAYMATRIX, sizeof(DisplayMatrix))) = kind_.turn;
    if (kind_.sound_rate > 0) BeginSound();
    AVDictionary* options = nullptr;
    for (const auto& [key, value] : kind_.format_options)
      av_dict_set(&options, key.c_str(), value.c_str(), 0);
    const int code = avformat_write_header(file_, &options);
    av_dict_free(&options);
    Need(code);
  }
  void BeginSound() {
    AVStream* sound = avformat_new_stream(file_, nullptr);
    sound->codecpar->codec_type = AVMEDIA_TYPE_AUDIO;
    sound->codecpar->codec_id = AV_CODEC_ID_PCM_S16LE;
    sound->codecpar->format = AV_SAMPLE_FMT_S16;
    sound->codecpar->sample_rate = kind_.sound_rate;
    sound->codecpar->bits_per_coded_sample = 16;
    sound->codecpar->block_align = 2;
    av_channel_layout_default(&sound->codecpar->ch_layout, 1);
    sound->time_base = {1, kind_.sound_rate};
    file_->max_interleave_delta = 0;  // the sound waits for the pictures
  }
  void Send(const AVFrame* frame) {
    Need(avcodec_send_frame(encoder_.get(), frame));
    while (avcodec_receive_packet(encoder_.get(), packet_.get()) >= 0) {
      packet_->duration = kind_.unit / kind_.rate;
      av_packet_rescale_ts(packet_.get(), encoder_->time_base, stream_->time_base);
      packet_->stream_index = 0;
      Need(av_interleaved_write_frame(file_, packet_.get()));
    }
  }

  TestFilmKind kind_;
  AVFormatContext* file_ = nullptr;
  AVStream* stream_ = nullptr;
  AvEncoder encoder_;
  AvPacket packet_;
  AvFrame frame_;
};

/// The number that a picture of AddNumber holds.
inline int NumberIn(const Image8& picture) {
  int number = 0;
  for (int bit = 0; bit < 8; ++bit)
    number |= (*picture.at(16 * bit + 8, picture.height / 2) > 127) << bit;
  return number;
}

/// Pictures with the numbers 0, 1, 2, ... at these times [units of the kind].
inline void WriteTestFilm(const std::filesystem::path& path, const TestFilmKind& kind,
                          const std::vector<std::int64_t>& times) {
  TestFilm film(path, kind);
  int number = 0;
  for (const std::int64_t time : times) film.AddNumber(time, number++);
  film.Finish();
}

/// Times of a constant rate.
inline std::vector<std::int64_t> EvenTimes(int count, std::int64_t step, std::int64_t first = 0) {
  std::vector<std::int64_t> times;
  for (int i = 0; i < count; ++i) times.push_back(first + i * step);
  return times;
}

}  // namespace keypose
