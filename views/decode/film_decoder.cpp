#include "views/decode/film_decoder.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "core/io/text/files.h"
#include "core/pictures/image_turns.h"
#include "core/values/errors.h"
#include "views/decode/film_file.h"
#include "views/decode/film_pixels.h"

namespace keypose {
Image8 FilmLuma(const Image8& colors) {
  Image8 luma(colors.width, colors.height, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) {
    const std::uint8_t* color = colors.data.data() + static_cast<std::size_t>(colors.channels) * i;
    luma.data[i] = static_cast<std::uint8_t>(
        (9798 * color[0] + 19235 * color[1] + 3735 * color[2] + (1 << 14)) >> 15);
  }
  return luma;
}

struct FilmDecoder::State {
  std::filesystem::path path;
  std::shared_ptr<const FilmIndex> index;
  std::optional<FilmFile> file;
  int next = 0;

  [[noreturn]] void Missing(int picture) const {
    throw InputError(fmt::format(
        "picture {} of the video {}, at {:.3f} s, cannot be decoded; the video is damaged: copy or "
        "export it again",
        picture, PrintableName(path), index->times_s[static_cast<std::size_t>(picture)]));
  }

  /// The frame of the picture that is due.
  const AVFrame* Next() {
    for (;;) {
      const AVFrame* frame = file->NextFrame();
      if (!frame) Missing(next);
      if (index->stamps.empty()) return frame;
      const std::int64_t due = index->stamps[static_cast<std::size_t>(next)];
      if (frame->best_effort_timestamp > due) Missing(next);
      if (frame->best_effort_timestamp == due) return frame;
    }
  }
};

FilmDecoder::FilmDecoder(std::filesystem::path path, std::shared_ptr<const FilmIndex> index)
    : state_(std::make_unique<State>()) {
  state_->path = std::move(path);
  state_->index = std::move(index);
}
FilmDecoder::~FilmDecoder() = default;
FilmDecoder::FilmDecoder(FilmDecoder&&) noexcept = default;
FilmDecoder& FilmDecoder::operator=(FilmDecoder&&) noexcept = default;

const FilmIndex& FilmDecoder::index() const { return *state_->index; }

Image8 FilmDecoder::Read(int picture, int channels, const Progress* progress) {
  State& s = *state_;
  if (picture < 0 || picture >= s.index->frames())
    throw UsageError(
        fmt::format("picture {} was asked for, but the film has {}", picture, s.index->frames()));
  if (!s.file || picture < s.next) {
    s.file.emplace(s.path);
    s.next = 0;
  }
  const AVFrame* frame = nullptr;
  for (; s.next <= picture; ++s.next) {
    if (progress && progress->cancelled()) throw Cancelled();
    frame = s.Next();
  }
  Image8 image = Oriented(PixelsOf(*frame, channels == 4 ? 4 : 3), s.file->Orientation(*frame));
  return channels == 1 ? FilmLuma(image) : std::move(image);
}

}  // namespace keypose
