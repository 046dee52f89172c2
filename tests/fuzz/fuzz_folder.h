// Shared by the fuzz programs. A reader gets a file and may throw only its documented errors.
#pragma once

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::fuzz {

/// A folder in memory, private to this process.
inline const std::filesystem::path& Folder() {
  static const std::filesystem::path folder = [] {
    const std::filesystem::path made = "/dev/shm/keypose_fuzz_" + std::to_string(::getpid());
    std::filesystem::create_directories(made);
    return made;
  }();
  return folder;
}

inline std::filesystem::path Put(const std::string& name, std::string_view bytes) {
  WriteFile(Folder() / name, bytes);
  return Folder() / name;
}

inline std::string_view Bytes(const std::uint8_t* data, std::size_t size) {
  return {reinterpret_cast<const char*>(data), size};
}

/// Runs a reader. An exception other than keypose::Error ends the program, and libFuzzer keeps the
/// input.
template <class Read>
int Expect(const Read& read) {
  try {
    read();
  } catch (const Error&) {
  }
  return 0;
}

/// Whether a file was bound to another mesh than the one with this hash. Carrying it over is not
/// part of reading, and takes half a minute under the sanitizers.
inline bool IsOfAnotherMesh(std::string_view text, const std::string& hash) {
  return text.find("sha256") != std::string_view::npos && text.find(hash) == std::string_view::npos;
}

}  // namespace keypose::fuzz
