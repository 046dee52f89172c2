// What belongs to each filmed picture: its matte, and the plate of the set.
#pragma once

#include <filesystem>
#include <vector>

#include "composite/film/film_files.h"

namespace keypose::composite {

/// A picture for all, a folder of numbered ones, or a video, of which the frames that are asked for
/// are decoded.
class CompanionFilm {
 public:
  /// @param what  its name for messages, such as "matte"
  /// @param show  of pictures that are scene light; may be none
  CompanionFilm(const std::filesystem::path& path, std::string what, ShowLight show = {});
  bool single() const { return single_; }
  bool is_video() const { return files_.is_video(); }
  /// The first picture is for all.
  void TakeFirst() { single_ = true; }
  /// @param a_frame  numbers of this film for each filmed frame
  void Decode(const std::vector<int>& film_frames, int a_frame, Progress* progress);
  int last() const { return files_.pictures().back().frame; }
  /// Where all numbers in this film's names are among those of the filmed pictures, each belongs to
  /// the picture of its own number, also when the first ones are missing. Else, and without this
  /// call, both count from their first pictures.
  void MatchNumbers(const std::vector<FilmPicture>& film);
  /// All whose times lie between two filmed frames, with their times on the film's clock.
  std::vector<std::pair<double, std::filesystem::path>> Within(int first, int last,
                                                               int a_frame) const;
  /// @throws InputError  none of that number; names the picture that it belongs to
  const std::filesystem::path& For(const FilmPicture& picture, int a_frame = 1) const;

 private:
  FilmFiles files_;
  std::string what_;
  bool single_;
  int offset_ = 0;  // the filmed frame of this film's first picture
};

}  // namespace keypose::composite
