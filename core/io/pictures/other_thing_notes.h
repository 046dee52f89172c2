// Photographs of a pose that `capture` has left out: other_things.json beside capture.json.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace keypose {

/// Why each was left out, for the user, by the name that it has among the others.
using OtherThingNotes = std::map<std::string, std::string>;

/// @param folder  of the image set
/// @return empty where none was
/// @throws InputError  the file is damaged
OtherThingNotes ReadOtherThingNotes(const std::filesystem::path& folder);

/// Writes nothing where none was left out.
/// @throws DiskError
void WriteOtherThingNotes(const std::filesystem::path& folder, const OtherThingNotes& notes);

}  // namespace keypose
