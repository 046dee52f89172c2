#include "composite/film/film_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/decode/film_decoder.h"

namespace keypose::composite {
namespace {

namespace fs = std::filesystem;

fs::path NewFolder() {
  std::string name = (fs::temp_directory_path() / "keypose_film_XXXXXX").string();
  if (!mkdtemp(name.data()))
    throw DiskError("cannot make a folder for a film's pictures in " +
                    PrintableName(fs::temp_directory_path()));
  return name;
}

}  // namespace

int PlatesAFrame(int last_plate, int last_frame) {
  return last_frame > 0 ? std::max(1, last_plate / last_frame) : 1;
}

FilmFiles::FilmFiles(const fs::path& film) : film_(film) {
  if (!IsFilmFile(film)) {
    pictures_ = FilmPictures(film);
    return;
  }
  index_ = std::make_shared<const FilmIndex>(ReadFilmIndex(film));
  fps_ = index_->rate.per_second;
  scratch_ = NewFolder();
  for (const int frame : FrameNumbers(index_->times_s, index_->rate))
    pictures_.push_back({frame, scratch_ / fmt::format("{:04}.png", frame), frame});
}

FilmFiles::~FilmFiles() {
  std::error_code ignored;
  if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
}

void FilmFiles::Decode(const std::vector<int>& frames, Progress* progress) {
  if (!is_video()) return;
  FilmDecoder decoder(film_, index_);
  int done = 0;
  for (int i = 0; i < SizeOf(pictures_); ++i) {
    const FilmPicture& picture = pictures_[static_cast<std::size_t>(i)];
    if (!std::binary_search(frames.begin(), frames.end(), picture.frame)) continue;
    ReportProgress(progress, static_cast<double>(done++) / SizeOf(frames), "decoding the film");
    if (!fs::exists(picture.path))
      WritePng(picture.path, decoder.Read(i, index_->has_alpha ? 4 : 3, progress));
  }
}

void FilmFiles::DecodeAll(Progress* progress) {
  std::vector<int> frames;
  for (const FilmPicture& picture : pictures_) frames.push_back(picture.frame);
  Decode(frames, progress);
}

}  // namespace keypose::composite
