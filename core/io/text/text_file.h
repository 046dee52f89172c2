// Texts that other programs write: with a byte order mark, or in UTF-16.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace keypose {

/// UTF-16, by its byte order mark or by the zero beside its first letter, as UTF-8; "" for a text
/// that is not UTF-16.
std::string FromUtf16(std::string_view bytes);

/// `bytes` as UTF-8 without a byte order mark.
std::string PlainText(std::string bytes);

/// The text of a file, see PlainText.
/// @throws DiskError
std::string ReadTextFile(const std::filesystem::path& path);

}  // namespace keypose
