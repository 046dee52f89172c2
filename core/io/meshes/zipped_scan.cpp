#include "core/io/meshes/zipped_scan.h"

#include <archive.h>
#include <archive_entry.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include "core/io/meshes/other_meshes.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

struct FreeArchive {
  void operator()(archive* opened) const { archive_read_free(opened); }
};
using OpenArchive = std::unique_ptr<archive, FreeArchive>;

class Unpacker {
 public:
  Unpacker(const fs::path& path, const fs::path& folder) : path_(path), folder_(folder) {}

  void Unpack() {
    const OpenArchive zip(archive_read_new());
    archive_read_support_format_zip(zip.get());
    constexpr std::size_t kReadAtOnce = 1 << 16;
    if (archive_read_open_filename(zip.get(), path_.c_str(), kReadAtOnce) != ARCHIVE_OK)
      FailDamaged(zip.get());
    archive_entry* entry = nullptr;
    int result = archive_read_next_header(zip.get(), &entry);
    for (int files = 0; result == ARCHIVE_OK || result == ARCHIVE_WARN; ++files) {
      if (files >= ZippedScan::kMostFiles) Fail("it holds too many files");
      if (archive_entry_filetype(entry) == AE_IFREG) Write(zip.get(), entry);
      result = archive_read_next_header(zip.get(), &entry);
    }
    if (result != ARCHIVE_EOF) FailDamaged(zip.get());
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError(fmt::format("{} cannot be read: {}; unpack it, and give the mesh itself",
                                 PrintableName(path_), why));
  }
  [[noreturn]] void FailDamaged(archive* zip) const {
    const char* reason = archive_error_string(zip);
    Fail(fmt::format("the ZIP file is damaged ({})", reason ? reason : "it ends too early"));
  }

  void Write(archive* zip, archive_entry* entry) {
    const char* given = archive_entry_pathname(entry);
    std::string name = given ? given : "";
    std::replace(name.begin(), name.end(), '\\', '/');
    if (!StaysBelow(name)) Fail(fmt::format("'{}' in it leads elsewhere", PrintableName(name)));
    const fs::path file = folder_ / name;
    fs::create_directories(file.parent_path());
    std::ofstream out(file, std::ios::binary);
    std::vector<char> block(1 << 16);
    for (;;) {
      const la_ssize_t bytes = archive_read_data(zip, block.data(), block.size());
      if (bytes < 0) FailDamaged(zip);
      if (bytes == 0) break;
      written_ += bytes;
      if (written_ > ZippedScan::kMostBytes) Fail("it holds more than 4 GiB");
      out.write(block.data(), bytes);
    }
    out.close();
    if (!out)
      throw DiskError(fmt::format("cannot unpack {}: the disk may be full", PrintableName(path_)));
  }

  const fs::path& path_;
  const fs::path& folder_;
  long long written_ = 0;
};

bool IsLitter(const fs::path& file) {
  return std::any_of(file.begin(), file.end(), [](const fs::path& part) {
    return part.string().starts_with(".") || part == "__MACOSX";
  });
}

/// All files below a folder, in the order of their names.
std::vector<fs::path> FilesBelow(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const fs::path name = entry.path().lexically_relative(folder);
    if (entry.is_regular_file() && !IsLitter(name)) files.push_back(name);
  }
  std::sort(files.begin(), files.end());
  return files;
}

fs::path MeshAmong(const fs::path& folder, const std::string& who) {
  const std::vector<fs::path> files = FilesBelow(folder);
  for (const char* extension : {".glb", ".gltf", ".obj", ".ply", ".stl", ".off"}) {
    std::vector<fs::path> meshes;
    for (const fs::path& file : files)
      if (LowerExtension(file) == extension) meshes.push_back(file);
    if (meshes.size() > 1)
      throw InputError(fmt::format(
          "{} holds {} meshes ({}, {}{}): unpack it, and give each as a pose of its own", who,
          meshes.size(), PrintableName(meshes[0]), PrintableName(meshes[1]),
          meshes.size() > 2 ? ", ..." : ""));
    if (!meshes.empty()) return folder / meshes[0];
  }
  for (const fs::path& file : files) {
    const OtherMesh other = OtherMeshNamed(file);
    if (other.kind.empty() || LowerExtension(file) == ".csv") continue;
    if (LowerExtension(file) == ".model")
      throw InputError(fmt::format("{} is a 3MF file, which is not read: {}", who, other.cure));
    if (other.kind == "a USD file")
      throw InputError(fmt::format(
          "{} holds a USD scene ({}), which is not read: export GLB or OBJ from the app, or open "
          "it in Blender and export it as OBJ",
          who, PrintableName(file)));
    throw InputError(fmt::format("{} holds {} ({}), which is not read: {}", who, other.kind,
                                 PrintableName(file), other.cure));
  }
  throw InputError(
      fmt::format("{} is a ZIP file without a mesh that is read (GLB, glTF, OBJ, PLY, "
                  "STL, OFF)",
                  who));
}

}  // namespace

ZippedScan::ZippedScan(const fs::path& path) {
  std::string pattern = (fs::temp_directory_path() / "keypose_scan_XXXXXX").string();
  if (!mkdtemp(pattern.data()))
    throw DiskError(fmt::format("cannot unpack {}: no folder can be made below {}",
                                PrintableName(path), fs::temp_directory_path().string()));
  folder_ = pattern;
  try {
    Unpacker(path, folder_).Unpack();
    mesh_ = MeshAmong(folder_, PrintableName(path));
  } catch (...) {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
    throw;
  }
}

ZippedScan::~ZippedScan() {
  std::error_code ignored;
  fs::remove_all(folder_, ignored);
}

}  // namespace keypose
