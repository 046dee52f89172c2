#include "capture/shoot/devices/gphoto2_camera.h"

#include <gphoto2/gphoto2-camera.h>

#include <algorithm>
#include <cctype>
#include <deque>
#include <fstream>

#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

/// A file on the camera.
struct CameraFileName {
  std::string folder, name;
};

template <class T, int (*Free)(T*)>
struct Freed {
  void operator()(T* pointer) const { Free(pointer); }
};
using CameraHandle = std::unique_ptr<::Camera, Freed<::Camera, gp_camera_unref>>;
using FileHandle = std::unique_ptr<CameraFile, Freed<CameraFile, gp_file_unref>>;
using WidgetHandle = std::unique_ptr<CameraWidget, Freed<CameraWidget, gp_widget_unref>>;

void FreeContext(GPContext* context) { gp_context_unref(context); }

/// A name without what could lead out of a folder.
std::string PlainName(std::string name) {
  std::replace_if(
      name.begin(), name.end(),
      [](unsigned char c) { return !std::isalnum(c) && c != '.' && c != '_' && c != '-'; }, '_');
  return name.empty() || name.front() == '.' ? "photograph" + name : name;
}

std::string StemOf(const std::string& name) { return fs::path(name).stem().string(); }

class Gphoto2Camera final : public CameraDevice {
 public:
  void Connect(Patience& patience) override {
    patience.Wait(0);
    camera_.reset();
    ::Camera* camera = nullptr;
    Check(gp_camera_new(&camera), "be opened");
    camera_.reset(camera);
    try {
      Check(gp_camera_init(camera_.get(), context_.get()), "be opened");
    } catch (const DeviceFault&) {
      camera_.reset();
      throw;
    }
    CameraAbilities abilities = {};
    if (gp_camera_get_abilities(camera_.get(), &abilities) == GP_OK) name_ = abilities.model;
    DropEvents();
  }

  std::string Name() const override { return name_; }

  Exposure Take(const fs::path& into, bool fetch_again, Patience& patience) override {
    if (fetch_again && !last_.empty()) return Fetch(last_, into);
    RequireOpen();
    CameraFilePath path = {};
    Check(gp_camera_capture(camera_.get(), GP_CAPTURE_IMAGE, &path, context_.get()),
          "release the shutter");
    std::vector<CameraFileName> files = {{path.folder, path.name}};
    AddPartners(&files, patience);
    return Fetch(files, into);
  }

  std::optional<Exposure> Arrived(const fs::path& into, Patience& patience) override {
    if (!camera_) return std::nullopt;
    if (waiting_.empty()) NextEvent(10);
    if (waiting_.empty()) return std::nullopt;
    std::vector<CameraFileName> files = {waiting_.front()};
    waiting_.pop_front();
    AddPartners(&files, patience);
    return Fetch(files, into);
  }

  bool Focus(int i, int, Patience& patience) override {
    // The person sets the near end; steps go towards the far one.
    if (i == 0 || !camera_) return false;
    const bool moved = SetChoice("manualfocusdrive", {"Far 2", "Far 1"}) ||
                       SetRange("manualfocusdrive", kNikonFocusStep);
    if (moved) patience.Wait(0.7);
    return moved;
  }

  std::optional<std::string> Preview() override {
    if (!camera_) return std::nullopt;
    FileHandle file = NewFile();
    if (gp_camera_capture_preview(camera_.get(), file.get(), context_.get()) != GP_OK)
      return std::nullopt;
    return BytesOf(file.get());
  }

 private:
  static constexpr float kNikonFocusStep = 200;

  void Check(int result, const std::string& doing) {
    if (result >= GP_OK) return;
    const DeviceFault fault = FaultOfGphoto2(result, doing, gp_result_as_string(result));
    if (fault.code == "camera-gone" || fault.code == "camera-grabbed") camera_.reset();
    throw fault;
  }

  void RequireOpen() {
    if (!camera_) Check(GP_ERROR_MODEL_NOT_FOUND, "be opened");
  }

  static FileHandle NewFile() {
    CameraFile* file = nullptr;
    if (gp_file_new(&file) != GP_OK) throw std::bad_alloc();
    return FileHandle(file);
  }

  static std::string BytesOf(CameraFile* file) {
    const char* data = nullptr;
    unsigned long size = 0;
    gp_file_get_data_and_size(file, &data, &size);
    return std::string(data, size);
  }

  /// Waits for one event and keeps it if it is a new file.
  /// @return whether there was any event
  bool NextEvent(int timeout_ms) {
    CameraEventType type = GP_EVENT_UNKNOWN;
    void* data = nullptr;
    Check(gp_camera_wait_for_event(camera_.get(), timeout_ms, &type, &data, context_.get()),
          "tell what it does");
    if (type == GP_EVENT_FILE_ADDED && data) {
      const auto* path = static_cast<const CameraFilePath*>(data);
      if (IsPhotographName(path->name) || IsRawName(path->name))
        waiting_.push_back({path->folder, path->name});
    }
    std::free(data);
    return type != GP_EVENT_TIMEOUT;
  }

  /// Events of before the session.
  void DropEvents() {
    for (int i = 0; i < 50 && NextEvent(10); ++i) {
    }
    waiting_.clear();
  }

  /// The other file of a RAW and JPEG pair is announced a moment later.
  void AddPartners(std::vector<CameraFileName>* files, Patience& patience) {
    const double until = patience.Now() + (pairs_ ? 4.0 : 1.0);
    bool found = false;
    while (!found && patience.Now() < until) {
      patience.Wait(0);
      if (waiting_.empty()) NextEvent(100);
      for (auto it = waiting_.begin(); it != waiting_.end() && !found; ++it) {
        found = StemOf(it->name) == StemOf(files->front().name);
        if (!found) continue;
        files->push_back(*it);
        waiting_.erase(it);
        break;
      }
    }
    pairs_ = found;
  }

  Exposure Fetch(const std::vector<CameraFileName>& files, const fs::path& into) {
    RequireOpen();
    last_ = files;
    Exposure exposure;
    for (const CameraFileName& name : files) {
      FileHandle file = NewFile();
      Check(gp_camera_file_get(camera_.get(), name.folder.c_str(), name.name.c_str(),
                               GP_FILE_TYPE_NORMAL, file.get(), context_.get()),
            "hand over the photograph");
      const std::string bytes = BytesOf(file.get());
      const fs::path to = into / PlainName(name.name);
      std::ofstream out(to, std::ios::binary);
      out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
      out.close();
      if (!out)
        throw DiskError("cannot write " + to.string() + "; free some space and start again");
      exposure.files.push_back(to);
    }
    return exposure;
  }

  /// The configuration's entry, below its root; null if the camera has none of this name.
  CameraWidget* Entry(const char* name, WidgetHandle* root) {
    CameraWidget* whole = nullptr;
    if (gp_camera_get_config(camera_.get(), &whole, context_.get()) != GP_OK) return nullptr;
    root->reset(whole);
    CameraWidget* entry = nullptr;
    return gp_widget_get_child_by_name(whole, name, &entry) == GP_OK ? entry : nullptr;
  }

  bool SetChoice(const char* name, const std::vector<std::string>& choices) {
    WidgetHandle root;
    CameraWidget* entry = Entry(name, &root);
    if (!entry) return false;
    for (int i = 0; i < gp_widget_count_choices(entry); ++i) {
      const char* choice = nullptr;
      if (gp_widget_get_choice(entry, i, &choice) != GP_OK) continue;
      if (std::find(choices.begin(), choices.end(), choice) == choices.end()) continue;
      return gp_widget_set_value(entry, choice) == GP_OK && SendConfig(root.get());
    }
    return false;
  }

  bool SetRange(const char* name, float value) {
    WidgetHandle root;
    CameraWidget* entry = Entry(name, &root);
    CameraWidgetType type = GP_WIDGET_WINDOW;
    if (!entry || gp_widget_get_type(entry, &type) != GP_OK || type != GP_WIDGET_RANGE)
      return false;
    return gp_widget_set_value(entry, &value) == GP_OK && SendConfig(root.get());
  }

  bool SendConfig(CameraWidget* root) {
    return gp_camera_set_config(camera_.get(), root, context_.get()) == GP_OK;
  }

  std::unique_ptr<GPContext, decltype(&FreeContext)> context_{gp_context_new(), FreeContext};
  CameraHandle camera_;
  std::string name_ = "camera";
  std::deque<CameraFileName> waiting_;  // files that the camera has announced
  std::vector<CameraFileName> last_;
  bool pairs_ = true;  // wait for a pair until a photograph came alone
};

}  // namespace

std::unique_ptr<CameraDevice> MakeGphoto2Camera() { return std::make_unique<Gphoto2Camera>(); }

}  // namespace keypose::capture::shoot
