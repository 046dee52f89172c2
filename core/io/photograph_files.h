// Which files are photographs that Keypose reads, judged by their names.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose {

/// The kinds that are read, for messages.
inline const char* const kReadablePhotographs =
    ".jpg, .jpeg, .png, .tif, .tiff, .heic, .heif, .hif";

/// @return whether the name's extension (any case) is one of kReadablePhotographs
bool IsPhotographName(const std::filesystem::path& file);
/// HEIC, HEIF: what phones write.
bool IsHeicName(const std::filesystem::path& file);
/// Files that systems and file managers put there unasked: hidden ones, Thumbs.db, desktop.ini.
bool IsLitterName(const std::filesystem::path& file);

/// "12 .mov (IMG_1.mov, IMG_2.mov ...), 1 .txt (notes.txt)"; empty for none.
/// @param files  only their names count
std::string KindsOf(const std::vector<std::filesystem::path>& files);
/// What to do with files that are not read, where that is known of their kind: "export the RAW
/// files as JPEG"; may be empty.
std::string CureFor(const std::vector<std::filesystem::path>& files);

}  // namespace keypose
