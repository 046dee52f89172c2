// Photographs of a pose that a person leaves out, as one text: the option `leave_out` of `capture`.
// They stay in the pose's folder, and no step reads them.
//
//     IMG_0012.jpg; lying/IMG_0007.jpg
//
// The characters % and ; of a name, a space at its begin or end, and control characters are written
// as %25, %3B, %20, ...
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose {

inline constexpr const char* kLeaveOutOption = "leave_out";

/// The names in a text, each once; spaces round them do not count.
std::vector<std::string> ParseLeftOut(const std::string& text);
/// The text that ParseLeftOut reads as these names; empty for none.
std::string LeftOutText(const std::vector<std::string>& names);

/// Whether a name of the list means a photograph: its path below the pose's folder, its file's name
/// alone, or the name under which `capture` would write it.
/// @param file     relative to the pose's folder
/// @param written  as capture writes it: "lying_IMG_0007.jpg" of lying/IMG_0007.heic
bool MeansPhotograph(const std::string& name, const std::filesystem::path& file,
                     const std::string& written);

}  // namespace keypose
