#include "core/values/late_library.h"

#include <dlfcn.h>

#include <filesystem>
#include <string>
#include <system_error>

#include "core/values/errors.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

LateLibrary* first_late_library = nullptr;

/// In a build folder as under a prefix. Tests have programs in a folder of the programs' folder.
fs::path PlaceOfLibrary(const std::string& name) {
  std::error_code fault;
  const fs::path programs = fs::read_symlink("/proc/self/exe", fault).parent_path();
  const fs::path file = "lib/keypose/keypose_" + name + ".so";
  const fs::path inner = programs.parent_path().parent_path() / file;
  if (programs.filename() == "testing" && fs::exists(inner, fault)) return inner;
  return programs.parent_path() / file;
}

}  // namespace

LateLibrary::LateLibrary(const char* name, const char* purpose)
    : name_(name), purpose_(purpose), next_(first_late_library) {
  first_late_library = this;
}

void LateLibrary::Load() {
  const std::lock_guard<std::mutex> lock(loading_);
  // Functions are bound when they are called, as those of the libraries that a program starts with.
  if (!handle_) handle_ = dlopen(PlaceOfLibrary(name_).c_str(), RTLD_LAZY | RTLD_LOCAL);
}

void* LateLibrary::Find(const char* function) {
  Load();
  if (void* found = handle_ ? dlsym(handle_, function) : nullptr) return found;
  const char* reason = dlerror();
  throw ToolError("cannot load " + PlaceOfLibrary(name_).string() + ", which is needed to " +
                  purpose_ + " (" + (reason ? reason : "no reason is known") +
                  "): build or install Keypose again, and the Debian packages that ./dev setup "
                  "installs");
}

void LoadLateLibraries() {
  for (LateLibrary* library = first_late_library; library; library = library->next_)
    library->Load();
}

}  // namespace keypose
