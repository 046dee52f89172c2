// Pictures that are made once, and kept. For the other files of the project's pictures.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace keypose::studio {

/// A picture made from a file, kept under the file's stamp and the picture's name. Safe to call
/// from many threads.
/// @param folder  where pictures are kept
/// @param make    writes it to the path that it is given
/// @throws NotFound  the file is gone
std::filesystem::path KeptPicture(const std::filesystem::path& folder,
                                  const std::filesystem::path& source, const std::string& what,
                                  const char* extension,
                                  const std::function<void(const std::filesystem::path&)>& make);

}  // namespace keypose::studio
