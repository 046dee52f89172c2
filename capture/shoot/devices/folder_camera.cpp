#include "capture/shoot/devices/folder_camera.h"

#include <algorithm>
#include <map>
#include <set>

#include "capture/shoot/devices/device_fault.h"
#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

struct Seen {
  std::uintmax_t bytes = 0;
  double since = 0;  ///< when it was first seen with this size
};

class FolderCamera final : public CameraDevice {
 public:
  FolderCamera(const fs::path& folder, const FolderTimes& times) : folder_(folder), times_(times) {}

  void Connect(Patience&) override {
    if (!fs::is_directory(folder_))
      throw DeviceFault("camera-gone", "the folder " + folder_.string() + " is not there",
                        "make it, or let the tethering program make it; it goes on by itself",
                        false);
    if (connected_) return;
    for (const fs::path& file : Pictures()) used_.insert(file.filename());
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
    for (const fs::path& file : fresh) used_.insert(file.filename());
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

  /// The files of the oldest photograph that is complete; none if there is none.
  std::vector<fs::path> Fresh(Patience& patience) {
    std::map<std::string, std::vector<fs::path>> photographs;
    for (const fs::path& file : Pictures())
      if (!used_.contains(file.filename())) photographs[file.stem().string()].push_back(file);
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

  /// Whether none of them has grown for a while. A single file waits longer once pairs were seen.
  bool AllStill(const std::vector<fs::path>& files, double now) {
    bool still = true;
    pairs_ = pairs_ || files.size() > 1;
    const double wait_s = pairs_ && files.size() == 1 ? times_.pair_s : times_.still_s;
    for (const fs::path& file : files) {
      std::error_code gone;
      const std::uintmax_t bytes = fs::file_size(file, gone);
      auto [entry, is_new] = seen_.try_emplace(file.filename().string(), Seen{bytes, now});
      if (gone || entry->second.bytes != bytes) entry->second = {gone ? 0 : bytes, now};
      still = still && !gone && bytes > 0 && now - entry->second.since >= wait_s;
    }
    return still;
  }

  fs::path folder_;
  FolderTimes times_;
  std::set<fs::path> used_;
  std::map<std::string, Seen> seen_;
  bool connected_ = false, pairs_ = false;
};

}  // namespace

std::unique_ptr<CameraDevice> MakeFolderCamera(const fs::path& folder, const FolderTimes& times) {
  return std::make_unique<FolderCamera>(folder, times);
}

}  // namespace keypose::capture::shoot
