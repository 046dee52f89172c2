#include "capture/shoot/session/helper.h"

#include <fmt/format.h>

#include "capture/shoot/devices/device_fault.h"
#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {

namespace fs = std::filesystem;

Helper::Helper(const ShootingOptions& options, const ShootingParts& parts, Announcer& announcer,
               UserRequests& requests, const fs::path& state_file)
    : setup_state(ReadSetupState(state_file)),
      options_(options),
      parts_(parts),
      announcer_(announcer),
      requests_(requests),
      state_file_(state_file) {}

void Helper::Ask(const std::string& ask, const std::string& words, const std::string& what_to_do,
                 std::optional<double> angle_deg) {
  announcer_.State("asking", *book_, requests_.target);
  announcer_.Asked(ask, words, what_to_do, angle_deg ? &*angle_deg : nullptr);
  requests_.done = options_.answers_itself;
  while (!requests_.done) {
    if (requests_.over()) throw EndAsked{};
    if (ask == "turn" && OwnRelease()) break;
    LiveFrame();
    requests_.Wait(0.05);
  }
  if (parts_.done_by_hand) parts_.done_by_hand(ask, requests_.target, angle_deg.value_or(0));
}

/// A photograph by the camera's own button answers the request to turn the table.
bool Helper::OwnRelease() {
  try {
    const UserRequests::Hold hold(requests_);  // what has arrived is not lost
    const fs::path into = book_->folder() / ".incoming" / "own";
    fs::create_directories(into);
    own_release_ = parts_.camera.Arrived(into, requests_);
  } catch (const DeviceFault&) {
    return false;  // told when the camera is needed
  }
  return own_release_.has_value();
}

void Helper::ConnectAll() {
  requests_.target = book_->Next().shot;
  Start([&] { parts_.camera.Connect(requests_); }, "camera");
  if (parts_.turntable) Start([&] { ConnectTable(); }, "turntable");
}

/// At the start there may be nobody who sees why nothing happens.
void Helper::Start(const Attempt& connect, const char* device) {
  if (options_.waits_for_devices) return Through([] {}, connect, device, false);
  try {
    connect();
  } catch (const DeviceFault& fault) {
    throw ToolError(std::string(fault.what()) + "; " + fault.what_to_do);
  }
}

void Helper::ConnectTable() {
  try {
    parts_.turntable->Connect(setup_state.table_deg, setup_state.turning_to.has_value(),
                              setup_state.memory, requests_);
  } catch (const PositionLost& lost) {
    announcer_.Fault(lost);
    SetTableByHand(setup_state.turning_to.value_or(setup_state.table_deg));
  }
}

void Helper::SetTableByHand(double angle_deg) {
  Ask("table-angle",
      fmt::format("turn the table by hand until its mark stands at {} degrees",
                  DegreesText(angle_deg)),
      "its motor may have to be switched off for that", angle_deg);
  TableIsAt(angle_deg);
}

void Helper::TableIsAt(double angle_deg) {
  if (parts_.turntable) parts_.turntable->Declare(angle_deg, requests_);
  setup_state.table_deg = WithinTurn(angle_deg);
  setup_state.turning_to.reset();
  SaveSetupState();
}

void Helper::WithTable(const Attempt& attempt) {
  Through(
      attempt, [&] { ConnectTable(); }, "turntable", true);
}

void Helper::WithCamera(const Attempt& attempt) {
  Through(
      attempt, [&] { parts_.camera.Connect(requests_); }, "camera", true);
}

void Helper::Through(const Attempt& attempt, const Attempt& connect, const char* device,
                     bool connected) {
  std::string told, code;
  while (true) {
    try {
      if (!connected) connect();
      connected = true;
      attempt();
      if (!code.empty()) announcer_.Recovered(code, device);
      return;
    } catch (const PositionLost&) {
      connected = false;  // connecting tells it, and asks for the table to be set
    } catch (const DeviceFault& fault) {
      connected = false;
      if (told != fault.what() || fault.needs_hand) announcer_.Fault(fault);
      told = fault.what();
      code = fault.code;
      if (fault.needs_hand)
        Ask(device, fault.what_to_do, "");
      else
        requests_.Wait(options_.retry_s);
    }
  }
}

void Helper::LiveFrame() {
  constexpr double kBetween_s = 0.2;
  const double now = requests_.Now();
  if (!requests_.live || options_.live_file.empty() || now - last_live_ < kBetween_s) return;
  last_live_ = now;
  try {
    const auto frame = parts_.camera.Preview();
    if (!frame) return;
    WriteFileAtomically(options_.live_file, *frame);
    const ImageInfo info = ReadImageInfo(options_.live_file);
    announcer_.Frame(options_.live_file, ++live_frames_, info.width, info.height);
  } catch (const InputError&) {
    return;  // half a frame; the next one is whole
  }
}

}  // namespace keypose::capture::shoot
