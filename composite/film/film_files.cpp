#include "composite/film/film_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/movie_header.h"
#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/shot/shot.h"

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

Image8 ReadMatte(const fs::path& path) {
  Image8 alpha = ReadAlpha(path);
  const bool opaque = std::all_of(alpha.data.begin(), alpha.data.end(),
                                  [](std::uint8_t value) { return value == 255; });
  return opaque ? ReadImage(path, 1) : alpha;
}

FilmFiles::FilmFiles(const fs::path& film) : film_(film) {
  if (!IsMovie(film)) {
    pictures_ = FilmPictures(film);
    return;
  }
  const MovieHeader header = ReadMovieHeader(film);
  fps_ = header.fps;
  codec_ = header.codec;
  scratch_ = NewFolder();
  for (int i = 0; i < header.frames; ++i)
    pictures_.push_back({i, scratch_ / fmt::format("{:04}.png", i), i});
}

FilmFiles::~FilmFiles() {
  std::error_code ignored;
  if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
}

void FilmFiles::Decode(const std::vector<int>& frames, Progress* progress) {
  if (!is_video()) return;
  FrameSource source;
  source.video = film_;
  source.frames = SizeOf(pictures_);
  FrameReader reader(source);
  int done = 0;
  for (const int frame : frames) {
    ReportProgress(progress, static_cast<double>(done) / SizeOf(frames), "decoding the film");
    const fs::path& to = pictures_.at(static_cast<std::size_t>(frame)).path;
    if (!fs::exists(to)) {
      try {
        WritePng(to, reader.Read(frame, 3, progress));
      } catch (const InputError& error) {
        if (done > 0 || frame > 0) throw;
        throw InputError(
            fmt::format("the video {} cannot be decoded (its codec is '{}'): {}; convert it to "
                        "H.264 in an .mp4, or to numbered pictures",
                        PrintableName(film_), codec_, error.what()));
      }
    }
    ++done;
  }
}

void FilmFiles::DecodeAll(Progress* progress) {
  std::vector<int> frames;
  for (const FilmPicture& picture : pictures_) frames.push_back(picture.frame);
  Decode(frames, progress);
}

}  // namespace keypose::composite
