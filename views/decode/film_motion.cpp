#include "views/decode/film_motion.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/decode/film_file.h"
#include "views/film/late_libav.h"

namespace keypose {
namespace {

constexpr int kCellsAcross = 96;
constexpr int kRowsRead = 288;  // of the picture: the others tell nothing new

/// Means of one component (luma, or a colour of RGB) over cells, in levels of 8 bits.
class Cells {
 public:
  explicit Cells(const AVFrame& frame)
      : format_(static_cast<AVPixelFormat>(frame.format)),
        description_(av_pix_fmt_desc_get(format_)),
        side_(std::max(1, frame.width / kCellsAcross)),
        columns_((frame.width + side_ - 1) / side_),
        row_(static_cast<std::size_t>(frame.width)) {}

  std::vector<float> Of(const AVFrame& frame) {
    const int rows = (frame.height + side_ - 1) / side_;
    const int step = std::max(1, frame.height / kRowsRead);
    std::vector<float> sums(static_cast<std::size_t>(rows) * columns_), counts(sums.size());
    for (int y = 0; y < frame.height; y += step) {
      ReadRow(frame, y);
      for (int x = 0; x < frame.width; ++x) {
        const std::size_t cell = static_cast<std::size_t>(y / side_) * columns_ + x / side_;
        sums[cell] += static_cast<float>(row_[x]);
        ++counts[cell];
      }
    }
    const float level = 255.0f / static_cast<float>((1 << description_->comp[0].depth) - 1);
    for (std::size_t i = 0; i < sums.size(); ++i) sums[i] *= level / std::max(1.0f, counts[i]);
    return sums;
  }

 private:
  void ReadRow(const AVFrame& frame, int y) {
    const AVComponentDescriptor& luma = description_->comp[0];
    const std::uint8_t* line =
        frame.data[luma.plane] + std::ptrdiff_t{y} * frame.linesize[luma.plane];
    const bool palette = (description_->flags & AV_PIX_FMT_FLAG_PAL) != 0;
    if (!palette && luma.depth == 8 && luma.step == 1) {
      std::copy(line, line + frame.width, row_.begin());
      return;
    }
    const std::uint8_t* data[4] = {frame.data[0], frame.data[1], frame.data[2], frame.data[3]};
    av_read_image_line2(row_.data(), data, frame.linesize, description_, 0, y, 0, frame.width,
                        palette, sizeof(std::uint32_t));
  }

  AVPixelFormat format_;
  const AVPixFmtDescriptor* description_;
  int side_, columns_;
  std::vector<std::uint32_t> row_;
};

/// Mean difference, without that of the whole picture's brightness.
double Change(const std::vector<float>& before, const std::vector<float>& now) {
  double mean = 0, sum = 0;
  for (std::size_t i = 0; i < now.size(); ++i) mean += now[i] - before[i];
  mean /= static_cast<double>(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) sum += std::abs(now[i] - before[i] - mean);
  return sum / static_cast<double>(now.size());
}

/// A picture that an encoder stores whole differs from those before by more than what moved.
void TakeOutBegins(const std::vector<bool>& whole, std::vector<double>* values) {
  for (int i = 1; i + 1 < SizeOf(*values); ++i)
    if (whole[i] && !whole[i - 1] && !whole[i + 1])
      (*values)[i] = 0.5 * ((*values)[i - 1] + (*values)[i + 1]);
}

}  // namespace

FilmMotion ReadFilmMotion(const std::filesystem::path& path, const FilmIndex& index, double most_s,
                          const Progress* progress) {
  FilmMotion motion;
  FilmFile film(path);
  std::vector<float> before;
  std::vector<bool> whole;
  for (int picture = 0; picture < index.frames();) {
    if (progress && progress->cancelled()) throw Cancelled();
    if (index.times_s[picture] - index.times_s[0] > most_s) break;
    const AVFrame* frame = film.NextFrame();
    if (!frame) break;
    if (!index.stamps.empty() && frame->best_effort_timestamp < index.stamps[picture]) continue;
    std::vector<float> cells = Cells(*frame).Of(*frame);
    if (cells.size() == before.size()) {
      const double begin = index.times_s[picture - 1], end = index.times_s[picture];
      motion.times_s.push_back(0.5 * (begin + end));
      motion.values.push_back(std::sqrt(Change(before, cells) / (end - begin)));
      whole.push_back(frame->key_frame != 0);
    }
    before = std::move(cells);
    ++picture;
  }
  TakeOutBegins(whole, &motion.values);
  return SizeOf(motion.values) < 2 ? FilmMotion{} : motion;
}

}  // namespace keypose
