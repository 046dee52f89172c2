#include "studio/runs/session_relay.h"

#include "core/values/errors.h"

namespace keypose::studio {

SessionRelay::SessionRelay(Ways ways, SessionListener listener)
    : ways_(std::move(ways)), listener_(std::move(listener)) {}

SessionRelay::~SessionRelay() {
  leave_ = true;
  if (thread_.joinable()) thread_.join();
  if (child_) child_->Say(ways_.farewell);
}

void SessionRelay::Start(const std::vector<std::string>& words, const std::filesystem::path& folder,
                         const std::filesystem::path& error_file,
                         const std::function<void()>& prepare, const std::string& greeting) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_.running) throw LockedError("a session is at work already; end it first");
  if (thread_.joinable()) thread_.join();
  std::filesystem::create_directories(error_file.parent_path());
  prepare();
  error_file_ = error_file;
  child_ = std::make_unique<TalkingChild>(words, folder, error_file);
  if (!greeting.empty()) child_->Say(greeting);
  state_ = {true, state_.number, {}, 0, ""};
  running_ = true;
  thread_ = std::thread([this] { Relay(); });
}

void SessionRelay::Say(const std::string& line) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!state_.running || !child_->Say(line)) throw UsageError("no session is at work; begin one");
}

void SessionRelay::Interrupt() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (state_.running) child_->Interrupt();
}

SessionState SessionRelay::State() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return state_;
}

void SessionRelay::Relay() {
  std::string line;
  while (!leave_) {
    const TalkingChild::Heard heard = child_->Hear(&line);
    if (heard == TalkingChild::Heard::kLine) Take(line);
    if (heard == TalkingChild::Heard::kEnd) return End();
  }
}

void SessionRelay::Take(const std::string& line) {
  if (!ways_.is_event(line)) return;
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ways_.keep(line, &state_.events);
    number = ++state_.number;
  }
  listener_.event(number, line);
}

void SessionRelay::End() {
  const int code = child_->Wait();
  const std::string said = code == 0 ? "" : WhatItSaid(error_file_, code);
  std::uint64_t number = 0;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    running_ = state_.running = false;
    state_.exit_code = code;
    state_.message = said;
    number = ++state_.number;
  }
  listener_.ended(number, code, said);
}

}  // namespace keypose::studio
