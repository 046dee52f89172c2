#include "pipeline/disk/zip_writer.h"

#include <archive.h>
#include <archive_entry.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <vector>

#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void Fail(const fs::path& file, const std::string& what) {
  throw DiskError(fmt::format("{}: {}", file.string(), what));
}

[[noreturn]] void FailWithReason(const fs::path& file) { Fail(file, std::strerror(errno)); }

/// An open file descriptor.
struct Descriptor {
  int fd = -1;
  explicit Descriptor(int opened) : fd(opened) {}
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
};

/// Photographs and films do not get smaller; trying costs most of the time that packing takes.
bool IsCompressed(const std::string& name) {
  constexpr std::array<std::string_view, 11> kEndings = {
      ".jpg", ".jpeg", ".png", ".heic", ".webp", ".mp4", ".mov", ".gif", ".zip", ".gz", ".glb"};
  const std::string ending = LowerExtension(name);
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

fs::path FolderOf(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

}  // namespace

struct ZipWriter::Parts {
  fs::path file, unfinished;  ///< `unfinished` is empty while the file has no name
  Descriptor out{-1};
  archive* zip = nullptr;

  void Check(int result) const {
    if (result < ARCHIVE_WARN) Fail(file, archive_error_string(zip));
  }

  /// Where the file system has no files without names, it gets one that says what it is.
  void Open() {
    out.fd = open(FolderOf(file).c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0666);
    if (out.fd >= 0) return;
    if (errno != EOPNOTSUPP && errno != EISDIR) FailWithReason(file);
    const fs::path named = file.string() + ".part";
    out.fd = open(named.c_str(), O_CREAT | O_TRUNC | O_RDWR | O_CLOEXEC, 0666);
    if (out.fd < 0) FailWithReason(file);
    unfinished = named;
  }

  /// A link, unlike a rename, never replaces what has the name already.
  void GiveName() {
    const fs::path from =
        unfinished.empty() ? fs::path(fmt::format("/proc/self/fd/{}", out.fd)) : unfinished;
    if (linkat(AT_FDCWD, from.c_str(), AT_FDCWD, file.c_str(), AT_SYMLINK_FOLLOW) != 0)
      FailWithReason(file);
  }

  void Copy(const fs::path& from, const Descriptor& in, std::int64_t size) {
    std::vector<char> buffer(1 << 20);
    std::int64_t copied = 0;
    while (copied < size) {
      const std::size_t wanted = std::min<std::int64_t>(size - copied, std::ssize(buffer));
      const ssize_t got = read(in.fd, buffer.data(), wanted);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) FailWithReason(from);
      if (got == 0) Fail(from, "got shorter while it was packed; pack again");
      if (archive_write_data(zip, buffer.data(), static_cast<std::size_t>(got)) != got)
        Fail(file, archive_error_string(zip));
      copied += got;
    }
  }
};

ZipWriter::ZipWriter(const fs::path& file) : parts_(std::make_unique<Parts>()) {
  parts_->file = file;
  if (fs::exists(file)) Fail(file, "exists already; remove it, or give another name with --output");
  parts_->Open();
  parts_->zip = archive_write_new();
  parts_->Check(archive_write_set_format_zip(parts_->zip));
  parts_->Check(archive_write_set_options(parts_->zip, "zip:hdrcharset=UTF-8"));
  parts_->Check(archive_write_open_fd(parts_->zip, parts_->out.fd));
}

ZipWriter::~ZipWriter() {
  if (parts_->zip) archive_write_free(parts_->zip);
  if (!parts_->unfinished.empty()) unlink(parts_->unfinished.c_str());
}

void ZipWriter::Add(const fs::path& from, const std::string& name) {
  const Descriptor in(open(from.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat stat = {};
  if (in.fd < 0 || fstat(in.fd, &stat) != 0) FailWithReason(from);
  archive* zip = parts_->zip;
  parts_->Check(IsCompressed(name) ? archive_write_zip_set_compression_store(zip)
                                   : archive_write_zip_set_compression_deflate(zip));
  const std::unique_ptr<archive_entry, void (*)(archive_entry*)> entry(archive_entry_new(),
                                                                       archive_entry_free);
  archive_entry_set_pathname_utf8(entry.get(), name.c_str());
  archive_entry_set_filetype(entry.get(), AE_IFREG);
  archive_entry_set_perm(entry.get(), stat.st_mode & S_IXUSR ? 0755 : 0644);
  archive_entry_set_size(entry.get(), stat.st_size);
  archive_entry_set_mtime(entry.get(), stat.st_mtim.tv_sec, stat.st_mtim.tv_nsec);
  parts_->Check(archive_write_header(zip, entry.get()));
  parts_->Copy(from, in, stat.st_size);
  parts_->Check(archive_write_finish_entry(zip));
}

std::uint64_t ZipWriter::Finish() {
  parts_->Check(archive_write_close(parts_->zip));
  struct stat stat = {};
  if (fsync(parts_->out.fd) != 0 || fstat(parts_->out.fd, &stat) != 0) FailWithReason(parts_->file);
  parts_->GiveName();
  return static_cast<std::uint64_t>(stat.st_size);
}

}  // namespace keypose::pipeline
