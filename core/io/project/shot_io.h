// Reads and writes shot.json: the camera of a filmed shot, and the character's place in its frames.
// Also lists the pictures of a film, and the films of several cameras.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/values/filmed_shot.h"

namespace keypose {

/// docs/file-formats.md has the fields.
/// @throws DiskError   cannot be opened
/// @throws InputError  malformed; a field that is missing, of the wrong kind or out of range;
/// frames that are not in order; a still camera that moves; names file, frame and field
FilmedShot ReadShot(const std::filesystem::path& path);
FilmedShot ParseShot(const std::string& json, const std::string& source);
std::string ShotText(const FilmedShot& shot);

/// A picture of a film.
struct FilmPicture {
  int frame = 0;  ///< counts from the first picture, which is 0
  std::filesystem::path path;
  int number = 0;  ///< in its name; of a video, and of one picture alone, its frame
};

/// The last number in a name without its ending, such as 12 of "take2_0012"; -1: none, or of more
/// than nine digits.
long FrameNumberIn(const std::string& stem);

/// Pictures as they should look; or also light, OpenEXR and DPX, where there are no others.
enum class FilmKinds { kPictures, kPicturesOrLight };

/// Those of a folder's files that are pictures of a film; see FilmPictures.
/// @param names  of the files, in any order
/// @return empty if none is a picture
/// @throws InputError  a name without a number beside others; a number twice
std::vector<FilmPicture> NumberedPictures(const std::filesystem::path& folder,
                                          const std::vector<std::string>& names,
                                          FilmKinds kinds = FilmKinds::kPictures);

/// The pictures of a film's folder, or the one picture that `path` is. The number that differs from
/// name to name (NumberNames) is a picture's frame, counted from the first picture's: what a film
/// leaves out (0000.png, 0004.png) takes time. Dates and times only give the order. Other files,
/// hidden files and folders are left out.
/// @throws InputError  no picture; a name without a number beside others; a number twice
std::vector<FilmPicture> FilmPictures(const std::filesystem::path& path,
                                      FilmKinds kinds = FilmKinds::kPictures);

/// What lies in a folder for one of several cameras that filmed together: a folder of pictures, or
/// a video.
struct CameraFilm {
  std::string name;                             ///< of the folder, or of the video without ending
  std::vector<std::filesystem::path> pictures;  ///< in the order of their frames; empty: a video
  std::filesystem::path video;                  ///< empty: pictures
};

/// A folder's content without hidden files, numbers in names as numbers.
/// @throws DiskError  it cannot be read
std::vector<std::filesystem::path> NumberedContent(const std::filesystem::path& folder);
/// JPEG, PNG and TIFF, by the name: what films of several cameras may consist of.
bool IsFramePicture(const std::filesystem::path& path);

/// The frames that pictures' names count (NumberNames); empty: they cannot be told.
std::vector<long> FrameNumbersOf(const std::vector<std::filesystem::path>& pictures);

/// Those of a folder, but for what is called masks and background; sorted, numbers as numbers.
/// Folders without a picture are left out; none where there is no such folder.
/// @throws DiskError   it cannot be read
/// @throws InputError  two of one name
std::vector<CameraFilm> CameraFilms(const std::filesystem::path& folder);

}  // namespace keypose
