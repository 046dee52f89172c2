#include "capture/shoot/devices/folder_camera.h"

#include <algorithm>
#include <map>
#include <string>

#include "capture/shoot/devices/device_fault.h"
#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

/// A second file of a photograph does not come later.
constexpr double kLatePair_s = 20;

/// What changes when a file is written.
struct Signature {
  std::uintmax_t bytes = 0;
  fs::file_time_type time;
  bool operator==(const Signature&) const = default;
};

struct Seen {
  Signature signature;
  double since = 0;  ///< when it was first seen so
};

/// A file that was taken, or was there before.
struct Used {
  Signature signature;
  std::string digest;  ///< of its bytes; empty: not known
};

Signature SignatureOf(const fs::path& file, std::error_code& error) {
  Signature signature;
  signature.bytes = fs::file_size(file, error);
  if (!error) signature.time = fs::last_write_time(file, error);
  return signature;
}

/// Whether a picture's end has arrived. RAW files do not tell.
bool IsWhole(const fs::path& file) {
  if (IsRawName(file)) return true;
  const std::string bytes = ReadFile(file), kind = ImageKindOf(bytes.substr(0, 4096));
  return (kind != "jpeg" && kind != "png") || IsWholeImage(bytes, kind);
}

class FolderCamera final : public CameraDevice {
 public:
  FolderCamera(const fs::path& folder, const FolderTimes& times) : folder_(folder), times_(times) {}

  void Connect(Patience&) override {
    if (!fs::is_directory(folder_))
      throw DeviceFault("camera-gone", "the folder " + folder_.string() + " is not there",
                        "make it, or let the tethering program make it; it goes on by itself",
                        false);
    if (connected_) return;
    std::error_code gone;
    // Not their bytes: the folder may hold all photographs of a year.
    for (const fs::path& file : Pictures())
      used_[file.filename().string()] = {SignatureOf(file, gone), {}};
    connected_ = true;
  }

  std::string Name() const override { return "folder"; }
  bool OnlyArrives() const override { return true; }

  Exposure Take(const fs::path& into, bool, Patience& patience) override {
    while (true) {
      if (auto exposure = Arrived(into, patience)) return *exposure;
      patience.Wait(0.1);
    }
  }

  std::optional<Exposure> Arrived(const fs::path& into, Patience& patience) override {
    const std::vector<fs::path> fresh = Fresh(patience);
    if (fresh.empty()) return std::nullopt;
    Exposure exposure;
    for (const fs::path& file : fresh) {
      const fs::path to = into / file.filename();
      std::error_code error;
      fs::copy_file(file, to, fs::copy_options::overwrite_existing, error);
      if (error)
        throw DiskError("cannot copy " + file.string() + " to " + to.string() + ": " +
                        error.message() + "; free some space and start again");
      exposure.files.push_back(to);
    }
    for (const fs::path& file : fresh) Use(file, patience.Now());
    return exposure;
  }

 private:
  std::vector<fs::path> Pictures() const {
    std::vector<fs::path> files;
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored)) {
      const fs::path& file = entry.path();
      const bool picture = IsPhotographName(file) || IsRawName(file);
      if (picture && !IsLitterName(file) && entry.is_regular_file(ignored)) files.push_back(file);
    }
    std::sort(files.begin(), files.end());
    return files;
  }

  void Use(const fs::path& file, double now) {
    std::error_code gone;
    used_[file.filename().string()] = {SignatureOf(file, gone), Sha256Of(ReadFile(file))};
    taken_at_[file.stem().string()] = now;
  }

  /// Whether a file was taken already, or comes after the photograph that it belongs to.
  bool IsUsed(const fs::path& file, double now) {
    const auto entry = used_.find(file.filename().string());
    if (entry == used_.end()) return ComesLate(file, now);
    std::error_code gone;
    const Signature signature = SignatureOf(file, gone);
    if (gone || signature == entry->second.signature) return true;
    // Touched or copied again: the bytes tell.
    if (!IsStill(file, now) || Sha256Of(ReadFile(file)) != entry->second.digest) return false;
    entry->second.signature = signature;
    return true;
  }

  /// The RAW of a JPEG that was taken, or the other way round: the next pair is waited for longer.
  bool ComesLate(const fs::path& file, double now) {
    const auto taken = taken_at_.find(file.stem().string());
    if (taken == taken_at_.end() || now - taken->second > kLatePair_s) return false;
    for (const auto& [name, used] : used_) {
      const fs::path other(name);
      if (other.stem() != file.stem() || IsRawName(other) == IsRawName(file)) continue;
      pairs_ = true;
      times_.pair_s = std::max(times_.pair_s, now - taken->second + 2 * times_.still_s);
      Use(file, taken->second);
      return true;
    }
    return false;
  }

  bool IsStill(const fs::path& file, double now) {
    const auto seen = seen_.find(file.filename().string());
    return seen != seen_.end() && now - seen->second.since >= times_.still_s;
  }

  /// The files of the oldest photograph that is complete; none if there is none.
  std::vector<fs::path> Fresh(Patience& patience) {
    std::map<std::string, std::vector<fs::path>> photographs;
    for (const fs::path& file : Pictures())
      if (!IsUsed(file, patience.Now())) photographs[file.stem().string()].push_back(file);
    std::vector<fs::path> oldest;
    fs::file_time_type oldest_time = fs::file_time_type::max();
    for (const auto& [stem, files] : photographs) {
      std::error_code gone;
      const auto time = fs::last_write_time(files.front(), gone);
      if (!AllStill(files, patience.Now()) || gone || time >= oldest_time) continue;
      oldest = files;
      oldest_time = time;
    }
    return oldest;
  }

  /// Whether none of them has changed for a while, and all are whole. A single file waits longer
  /// once pairs were seen.
  bool AllStill(const std::vector<fs::path>& files, double now) {
    bool still = true;
    pairs_ = pairs_ || files.size() > 1;
    const double wait_s = pairs_ && files.size() == 1 ? times_.pair_s : times_.still_s;
    for (const fs::path& file : files) {
      std::error_code gone;
      const Signature signature = SignatureOf(file, gone);
      auto [entry, is_new] = seen_.try_emplace(file.filename().string(), Seen{signature, now});
      if (gone || entry->second.signature != signature) entry->second = {signature, now};
      const double rest_s = now - entry->second.since;
      still = still && !gone && signature.bytes > 0 && rest_s >= wait_s &&
              (rest_s >= times_.unfinished_s || IsWhole(file));
    }
    return still;
  }

  fs::path folder_;
  FolderTimes times_;
  std::map<std::string, Used> used_;        // by file name
  std::map<std::string, double> taken_at_;  // by stem
  std::map<std::string, Seen> seen_;
  bool connected_ = false, pairs_ = false;
};

}  // namespace

std::unique_ptr<CameraDevice> MakeFolderCamera(const fs::path& folder, const FolderTimes& times) {
  return std::make_unique<FolderCamera>(folder, times);
}

}  // namespace keypose::capture::shoot
