#include "composite/companion_film.h"

#include <fmt/format.h>

#include "core/values/errors.h"

namespace keypose::composite {

namespace fs = std::filesystem;

CompanionFilm::CompanionFilm(const fs::path& path, std::string what, ShowLight show)
    : files_(path, std::move(show)),
      what_(std::move(what)),
      single_(!fs::is_directory(path) && !files_.is_video()) {}

void CompanionFilm::MatchNumbers(const std::vector<FilmPicture>& film) {
  const int first = files_.pictures().front().number, last = files_.pictures().back().number;
  const bool within = first >= film.front().number && last <= film.back().number;
  if (within && !single_) offset_ = first - film.front().number;
}

void CompanionFilm::Decode(const std::vector<int>& film_frames, int a_frame, Progress* progress) {
  if (single_) return files_.Decode({0}, progress);
  std::vector<int> frames;
  for (const int frame : film_frames)
    if (frame * a_frame <= last()) frames.push_back(frame * a_frame);
  files_.Decode(frames, progress);
}

std::vector<std::pair<double, fs::path>> CompanionFilm::Within(int first, int last,
                                                               int a_frame) const {
  std::vector<std::pair<double, fs::path>> within;
  for (const FilmPicture& file : files_.pictures())
    if (const double time = 1.0 * (file.frame + offset_) / a_frame; time >= first && time <= last)
      within.push_back({time, file.path});
  return within;
}

const fs::path& CompanionFilm::For(const FilmPicture& picture, int a_frame) const {
  if (single_) return files_.pictures()[0].path;
  for (const FilmPicture& file : files_.pictures())
    if (file.frame + offset_ == picture.frame * a_frame) return file.path;
  throw InputError(
      fmt::format("locate: there is no {} for {}; {}s are numbered as the pictures are", what_,
                  picture.path.filename().string(), what_));
}

}  // namespace keypose::composite
