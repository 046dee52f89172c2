// A film's file as libav reads it: packets and decoded frames of its video.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "views/film/libav.h"

namespace keypose {

using AvInput = std::unique_ptr<AVFormatContext, AvFree<AVFormatContext, avformat_close_input>>;

class FilmFile {
 public:
  /// Opens the file and finds its video: the first one that is no cover picture.
  /// @throws DiskError, InputError
  explicit FilmFile(const std::filesystem::path& path);

  const AVFormatContext& format() const { return *format_; }
  const AVStream& stream() const { return *stream_; }

  /// @return null at the film's end
  /// @throws InputError  cut off within the packet
  const AVPacket* NextPacket();
  /// The next frame in the order of showing, without those that an edit list cuts away.
  /// @return null at the film's end
  /// @throws InputError  there is no decoder; the frame is of a kind that is not read
  const AVFrame* NextFrame();

  /// The EXIF orientation that makes its frames upright.
  /// @throws InputError  turned by another angle than quarters
  int Orientation(const AVFrame& frame) const;

  /// @throws InputError  always: "the video X " + what
  [[noreturn]] void Fail(const std::string& what) const;

 private:
  void FindVideo();
  void RequireFlat() const;
  void OpenDecoder();
  void SendPacket();
  void Check(AVFrame& frame);

  std::filesystem::path path_;
  AvInput format_;
  AVStream* stream_ = nullptr;
  AvEncoder decoder_;
  AvPacket packet_;
  AvFrame frame_;
  int width_ = 0, height_ = 0, count_ = 0, faults_ = 0;
  bool ended_ = false;
};

}  // namespace keypose
