#include "studio/project/kept_picture.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>

#include "core/numbers/sha256.h"
#include "pipeline/disk/real_disk.h"
#include "studio/project/not_found.h"

namespace keypose::studio {

namespace fs = std::filesystem;

fs::path KeptPicture(const fs::path& folder, const fs::path& source, const std::string& what,
                     const char* extension, const std::function<void(const fs::path&)>& make) {
  const auto stat = pipeline::RealDisk().Stat(source);
  if (!stat) throw NotFound(source.filename().string() + " is gone");
  const std::string key =
      Sha256Of(fmt::format("{} {} {} {}", source.string(), stat->size, stat->mtime_ns, what));
  const fs::path file = folder / (key.substr(0, 32) + extension);
  if (fs::exists(file)) return file;
  fs::create_directories(folder);
  // Two requests for one picture may come at once: each writes a file of its own.
  static std::atomic<int> number = 0;
  const fs::path writing = folder / fmt::format("writing_{}_{}{}", getpid(), number++, extension);
  make(writing);
  fs::rename(writing, file);
  return file;
}

}  // namespace keypose::studio
