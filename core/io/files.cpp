#include "core/io/files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <numeric>
#include <sstream>

#include "core/errors.h"

namespace keypose {
namespace fs = std::filesystem;

std::string ReadFile(const fs::path& path) {
  if (fs::is_directory(path)) throw DiskError(path.string() + " is a folder, but a file is needed");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError("cannot open " + path.string() + ": " + std::strerror(errno));
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad()) throw DiskError("cannot read " + path.string() + ": " + std::strerror(errno));
  return std::move(text).str();
}

void WriteFile(const fs::path& path, std::string_view text) {
  errno = 0;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!out) throw DiskError("cannot write " + path.string() + ": " + std::strerror(errno));
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) {
    const int reason = errno;
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);  // never a device
    throw DiskError("cannot write " + path.string() + ": " + (reason ? std::strerror(reason) : "the disk took only a part") +
                    (reason == ENOSPC ? "; free some space and run again" : ""));
  }
}

void WriteFileAtomically(const fs::path& path, std::string_view text) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  // /dev/stdout, a FIFO: renamed over, the device itself would be gone.
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status)) return WriteFile(path, text);
  const fs::path temporary = path.string() + ".tmp" + std::to_string(::getpid());
  WriteFile(temporary, text);
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw DiskError("cannot replace " + path.string() + ": " + error.message());
  }
}

std::string NearestWord(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t best_distance = std::string::npos;
  for (const std::string& candidate : words) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i] != candidate[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({row[j + 1] + 1, row[j] + 1, substituted});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

}  // namespace keypose
