// A sound as libav reads it: decoded frames of the first sound of a film or sound file.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/progress.h"
#include "views/decode/film_file.h"

namespace keypose {

class SoundFile {
 public:
  explicit SoundFile(const std::filesystem::path& path);

  /// Why it has no sound that can be decoded, as "has no sound"; empty: it has one.
  const std::string& fault() const { return fault_; }
  /// Whether there are pictures too, other than a cover.
  bool is_film() const { return is_film_; }

  /// @param progress  asked for cancel; may be null
  /// @return null at the end
  const AVFrame* Next(const Progress* progress);
  /// When the frame begins [s], by the file's own clock. Containers round times: what differs from
  /// the end of the frame before by 0.03 s or less follows it without a gap.
  double begin_s() const { return begin_s_; }
  /// Packets that could not be decoded so far.
  int faults() const { return faults_; }

 private:
  void FindSound();
  void SendPacket(const Progress* progress);
  void TellTime();

  AvInput format_;
  AVStream* stream_ = nullptr;
  AvEncoder decoder_;
  AvPacket packet_;
  AvFrame frame_;
  std::string fault_;
  bool is_film_ = false, begun_ = false, drained_ = false;
  double begin_s_ = 0, next_s_ = 0;
  int faults_ = 0;
};

}  // namespace keypose
