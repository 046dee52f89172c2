// What the writers of films share: owners of libav's objects.
#pragma once

#include <memory>
#include <string>

#include "views/film/late_libav.h"

namespace keypose {

template <class T, const auto& Free>
struct AvFree {
  void operator()(T* pointer) const { Free(&pointer); }
};
using AvEncoder = std::unique_ptr<AVCodecContext, AvFree<AVCodecContext, avcodec_free_context>>;
using AvFrame = std::unique_ptr<AVFrame, AvFree<AVFrame, av_frame_free>>;
using AvPacket = std::unique_ptr<AVPacket, AvFree<AVPacket, av_packet_free>>;

/// libav's words for one of its error codes.
std::string AvText(int code);

/// A file that encoded pictures and sound are written to, without times and versions of its own.
class AvFile {
 public:
  /// @param format  libavformat's name: "mp4", "gif"
  /// @throws DiskError  the file cannot be written
  AvFile(const std::string& path, const char* format);
  ~AvFile();
  AvFile(const AvFile&) = delete;
  AvFile& operator=(const AvFile&) = delete;

  /// Makes room for what the encoder will send.
  /// @return the number of the stream, for Send  @throws ToolError
  int AddStream(const AVCodecContext& encoder);
  /// Writes the header, after all streams were added.
  /// @param key, value  an option of the format; nullptr: none
  /// @throws DiskError
  void Begin(const char* key, const char* value);
  /// Encodes and writes a picture or some sound; nullptr: what the encoder still holds.
  /// @param duration  of a picture, in units of the encoder's time base; 0: the encoder knows
  /// @throws DiskError, ToolError
  void Send(int stream, AVCodecContext& encoder, const AVFrame* frame, std::int64_t duration);
  /// @throws DiskError
  void End();

  AVFormatContext* context() { return context_; }
  /// @throws ToolError  code < 0: the encoder failed
  void Encoded(int code) const;

 private:
  void Written(int code) const;

  std::string path_;
  AVFormatContext* context_ = nullptr;
  AvPacket packet_;
};

}  // namespace keypose
