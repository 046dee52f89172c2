#include "studio/runs/shoot_control.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "pipeline/session.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A session of many days repeats itself; pages want its end.
constexpr std::size_t kMostEvents = 20000;
constexpr char kLive[] = R"({"command": "live", "on": true})";
constexpr char kEnd[] = R"({"command": "end"})";

std::string EventOf(const std::string& line) {
  const json value = json::parse(line, nullptr, false);
  if (!value.is_object() || !value.contains("event") || !value["event"].is_string()) return "";
  return value["event"];
}

/// Each new state replaces the one before.
void Keep(const std::string& event, const std::string& line, std::vector<std::string>* events) {
  if (event == "live") return;
  if (event == "state" && !events->empty() && EventOf(events->back()) == "state")
    events->pop_back();
  if (events->size() == kMostEvents) events->erase(events->begin());
  events->push_back(line);
}

std::vector<std::string> WordsFor(const ShootSetup& setup, const fs::path& project,
                                  const fs::path& live) {
  // In one word with its flag, no value can be taken for another flag.
  return {(pipeline::ProgramFolder() / "keypose-shoot").string(),
          "-C",
          project.string(),
          "--pose=" + setup.pose,
          "--camera=" + setup.camera,
          "--turntable=" + setup.turntable,
          fmt::format("--rings={}", fmt::join(setup.rings_deg, ",")),
          fmt::format("--angles={}", setup.angles),
          fmt::format("--flips={}", setup.flips),
          "--commands",
          "--live=" + live.string()};
}

}  // namespace

ShootControl::ShootControl(fs::path project, Listener listener)
    : project_(std::move(project)), listener_(std::move(listener)) {}

ShootControl::~ShootControl() {
  leave_ = true;
  if (relay_.joinable()) relay_.join();
  if (child_) child_->Say(kEnd);
}

fs::path ShootControl::File(const char* name) const { return project_ / ".keypose/studio" / name; }

void ShootControl::Start(const ShootSetup& setup) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (story_.running) throw LockedError("a session is at work already; end it first");
  if (relay_.joinable()) relay_.join();
  fs::create_directories(File(""));
  std::error_code ignored;
  fs::remove(LiveFile(), ignored);
  child_ = std::make_unique<TalkingChild>(WordsFor(setup, project_, LiveFile()), project_,
                                          File("shoot.txt"));
  child_->Say(kLive);
  story_ = {true, story_.number, {}, 0, ""};
  relay_ = std::thread([this] { Relay(); });
}

void ShootControl::Say(const std::string& command) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!story_.running || !child_->Say(command))
    throw UsageError("no session is at work; begin one");
}

void ShootControl::Interrupt() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (story_.running) child_->Interrupt();
}

ShootStory ShootControl::Story() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return story_;
}

void ShootControl::Relay() {
  std::string line;
  while (!leave_) {
    const TalkingChild::Heard heard = child_->Hear(&line);
    if (heard == TalkingChild::Heard::kLine) Take(line);
    if (heard == TalkingChild::Heard::kEnd) return End();
  }
}

void ShootControl::Take(const std::string& line) {
  const std::string event = EventOf(line);
  if (event.empty()) return;
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    Keep(event, line, &story_.events);
    number = ++story_.number;
  }
  listener_.event(number, line);
}

void ShootControl::End() {
  const int code = child_->Wait();
  const std::string said = code == 0 ? "" : WhatItSaid(File("shoot.txt"), code);
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    story_.running = false;
    story_.exit_code = code;
    story_.message = said;
    number = ++story_.number;
  }
  listener_.ended(number, code, said);
}

}  // namespace keypose::studio
