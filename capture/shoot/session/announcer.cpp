#include "capture/shoot/session/announcer.h"

#include <fmt/format.h>

#include "core/io/text/files.h"

namespace keypose::capture::shoot {

namespace fs = std::filesystem;
using nlohmann::json;

Announcer::Announcer(Conversation& talk, const fs::path& project)
    : talk_(talk), project_(project) {}

/// Relative to the project, if it is in it.
std::string Announcer::Shown(const fs::path& path) const {
  const fs::path relative = path.lexically_relative(project_);
  const bool within = !relative.empty() && *relative.begin() != "..";
  return WithoutOddBytes((within ? relative : path).generic_string());
}

/// The last pose's photograph of the same shot.
std::string Announcer::OnionOf(const std::string& name) const {
  if (onion_.empty()) return "";
  for (const char* extension : {".jpg", ".png", ".tif"})
    if (fs::exists(onion_ / (name + extension))) return Shown(onion_ / (name + extension));
  return "";
}

void Announcer::PoseOpened(const ShotBook& book, const fs::path& onion,
                           const std::string& bent_from) {
  onion_ = onion;
  const SideFile& side = book.side();
  json photographs = json::object(), skipped = json::array();
  for (const auto& [shot, entry] : side.photographs)
    photographs[book.Name(shot)] = EntryJson(side.plan, entry);
  for (const Shot& shot : side.skipped) skipped.push_back(book.Name(shot));
  talk_.Tell({{"event", "session"},
              {"pose", side.pose},
              {"folder", Shown(book.folder())},
              {"plan", PlanJson(side.plan)},
              {"total", book.Total()},
              {"done", book.Done()},
              {"resumed", book.resumed()},
              {"camera", side.camera},
              {"turntable", side.turntable},
              {"onion_pose", onion.filename().string()},
              {"bent_from", bent_from},
              {"photographs", photographs},
              {"skipped", skipped}});
}

void Announcer::State(const std::string& state, const ShotBook& book, const Shot& target) {
  const ShotPlan& plan = book.side().plan;
  const bool at_rest = state == "idle" || state == "ended" || state == "paused";
  const std::string name = at_rest && book.Complete() ? "" : book.Name(target);
  json event = {{"event", "state"},
                {"state", state},
                {"next", name},
                {"ring", target.ring},
                {"flip", target.flip},
                {"angle_deg", AngleOf(plan, target)},
                {"tilt_deg", TiltOf(plan, target)},
                {"done", book.Done()},
                {"total", book.Total()},
                {"onion", name.empty() ? "" : OnionOf(name)}};
  if (event == last_state_) return;
  last_state_ = event;
  talk_.Tell(event);
}

void Announcer::Asked(const std::string& ask, const std::string& words,
                      const std::string& what_to_do, const double* angle_deg) {
  json event = {{"event", "ask"}, {"ask", ask}, {"words", words}, {"do", what_to_do}};
  if (angle_deg) event["angle_deg"] = *angle_deg;
  talk_.Tell(event);
}

void Announcer::Landed(const ShotBook& book, const Shot& shot, bool again,
                       const std::vector<Shot>& changed) {
  const SideFile& side = book.side();
  const PhotographEntry& entry = side.photographs.at(shot);
  talk_.Tell({{"event", "photograph"},
              {"photograph", book.Name(shot)},
              {"path", Shown(book.folder() / entry.file)},
              {"entry", EntryJson(side.plan, entry)},
              {"done", book.Done()},
              {"total", book.Total()},
              {"again", again}});
  if (changed.empty()) return;
  json photographs = json::object();
  for (const Shot& other : changed)
    photographs[book.Name(other)] = FindingsJson(side.photographs.at(other).findings);
  talk_.Tell({{"event", "findings"}, {"photographs", photographs}});
}

void Announcer::RingChecked(const ShotBook& book, const Shot& first) {
  json event = RingJson(*book.side().FindRing(first.flip, first.ring));
  event["event"] = "ring";
  talk_.Tell(event);
}

void Announcer::Fault(const DeviceFault& fault) {
  talk_.Tell({{"event", "fault"},
              {"fault", fault.code},
              {"words", WithoutOddBytes(fault.what())},
              {"do", WithoutOddBytes(fault.what_to_do)},
              {"needs_hand", fault.needs_hand}});
}

void Announcer::Recovered(const std::string& fault_code, const std::string& device) {
  talk_.Tell({{"event", "recovered"},
              {"fault", fault_code},
              {"words", fmt::format("the {} works again", device)}});
}

void Announcer::Frame(const fs::path& file, int number, int width, int height) {
  talk_.Tell({{"event", "live"},
              {"path", WithoutOddBytes(file.string())},
              {"frame", number},
              {"width", width},
              {"height", height}});
}

void Announcer::Answer(const Command& command, const std::string& refusal) {
  json event = {{"event", refusal.empty() ? "accepted" : "refused"}, {"command", command.word}};
  if (!command.id.empty()) event["id"] = json::parse(command.id);
  if (!refusal.empty()) event["words"] = refusal;
  talk_.Tell(event);
}

void Announcer::PoseDone(const ShotBook& book) {
  int with_findings = 0;
  for (const auto& [shot, entry] : book.side().photographs)
    with_findings += !entry.findings.empty();
  for (const RingEntry& ring : book.side().rings) with_findings += !ring.findings.empty();
  talk_.Tell({{"event", "pose-done"},
              {"pose", book.side().pose},
              {"photographs", book.Done()},
              {"skipped", book.side().skipped.size()},
              {"with_findings", with_findings}});
}

void Announcer::Ended(const ShotBook& book) {
  const bool complete = book.Complete();
  const std::string& pose = book.side().pose;
  talk_.Tell(
      {{"event", "ended"},
       {"complete", complete},
       {"words", complete ? fmt::format("all {} photographs of {} are there", book.Done(), pose)
                          : fmt::format("{} of {} photographs of {} are there; the same command "
                                        "goes on",
                                        book.Done(), book.Total(), pose)}});
}

}  // namespace keypose::capture::shoot
