// Which files are films, judged by their names and first bytes, before any decoder reads them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace keypose {

/// A film's container, such as "Matroska or WebM"; "" for anything else, sound and pictures too.
/// @param head  the first 4096 bytes, or all of a shorter file
std::string FilmKindOf(std::string_view head);

/// Whether programs store films under the name's ending (any case), also kinds that are refused.
bool IsFilmName(const std::filesystem::path& file);

/// Whether the file is a film: by its name, or by its first bytes. No film: small copies that
/// cameras write beside theirs (.lrv), sound, pictures, what editors put aside (.bak).
bool IsFilm(const std::filesystem::path& file);

/// Why a file that is called a film cannot be read, with the cure, as "is a playlist ..."; empty:
/// nothing speaks against it.
std::string FilmFault(const std::filesystem::path& file);

}  // namespace keypose
