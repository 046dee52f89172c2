#include "composite/film/film_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <optional>
#include <utility>

#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
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

bool AreLight(const std::vector<FilmPicture>& pictures) {
  const std::string ending = LowerExtension(pictures.front().path);
  return ending == ".exr" || ending == ".dpx";
}

}  // namespace

std::vector<FilmPicture> LightPictures(const fs::path& film) {
  if (IsFilmFile(film)) return {};
  std::vector<FilmPicture> pictures = FilmPictures(film, FilmKinds::kPicturesOrLight);
  return AreLight(pictures) ? pictures : std::vector<FilmPicture>{};
}

int PlatesAFrame(int last_plate, int last_frame) {
  return last_frame > 0 ? std::max(1, last_plate / last_frame) : 1;
}

FilmFiles::FilmFiles(const fs::path& film, ShowLight show) : film_(film) {
  if (!IsFilmFile(film)) {
    pictures_ = FilmPictures(film, FilmKinds::kPicturesOrLight);
    is_light_ = AreLight(pictures_);
    if (!is_light_ || !show) return;
    show_ = std::move(show);
    scratch_ = NewFolder();
    for (FilmPicture& picture : pictures_) {
      light_.push_back(picture.path);
      picture.path = scratch_ / picture.path.filename();  // a PNG of its name, read by content
    }
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

std::vector<std::string> FilmFiles::notes() const {
  std::vector<std::string> notes;
  if (is_video())
    for (const std::string& note : index_->notes)
      notes.push_back("the video " + PrintableName(film_.filename()) + " " + note);
  return notes;
}

void FilmFiles::Decode(const std::vector<int>& frames, Progress* progress) {
  if (!is_video() && !show_) return;
  std::optional<FilmDecoder> decoder;
  if (is_video()) decoder.emplace(film_, index_);
  int done = 0;
  for (int i = 0; i < SizeOf(pictures_); ++i) {
    const FilmPicture& picture = pictures_[static_cast<std::size_t>(i)];
    if (!std::binary_search(frames.begin(), frames.end(), picture.frame)) continue;
    ReportProgress(progress, static_cast<double>(done++) / SizeOf(frames), "decoding the film");
    if (fs::exists(picture.path)) continue;
    WritePng(picture.path, decoder ? decoder->Read(i, index_->has_alpha ? 4 : 3, progress)
                                   : show_(light_[static_cast<std::size_t>(i)]));
  }
}

void FilmFiles::DecodeAll(Progress* progress) {
  std::vector<int> frames;
  for (const FilmPicture& picture : pictures_) frames.push_back(picture.frame);
  Decode(frames, progress);
}

}  // namespace keypose::composite
