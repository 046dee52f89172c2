// Where the tests find programs and sources. Functions, not macros: a test's object then has no
// path in it, and the compiler cache finds it in every clone.
#pragma once

#include <filesystem>
#include <string>

namespace keypose {

/// The folder of the built programs, absolute, without a slash at its end.
const std::string& BinFolder();
/// The project's root, absolute, without a slash at its end.
const std::string& SourceFolder();
/// The folder of photographs, scans and pairs that are no part of the project: KEYPOSE_DATA where
/// that is set, else shared/data beside the project. It may be missing; tests then skip.
std::filesystem::path DataFolder();

}  // namespace keypose
