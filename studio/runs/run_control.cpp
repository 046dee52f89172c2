#include "studio/runs/run_control.h"

#include <fmt/format.h>
#include <signal.h>
#include <sys/wait.h>

#include <chrono>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/runs/children.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr auto kPause = std::chrono::milliseconds(100);

/// Hands over the whole lines that were added to a file since the last call.
class Tail {
 public:
  explicit Tail(fs::path file) : file_(std::move(file)) {}
  template <class Take>
  void Read(const Take& take) {
    std::ifstream in(file_, std::ios::binary);
    in.seekg(at_);
    std::string line;
    while (std::getline(in, line) && !in.eof()) {
      at_ += static_cast<std::streamoff>(line.size()) + 1;
      if (json::accept(line)) take(line);
    }
  }

 private:
  fs::path file_;
  std::streamoff at_ = 0;
};

/// Whether the process is at work; a child that has ended is collected.
bool IsAlive(int pid, bool own, int* exit_code) {
  // Of a studio that is this process's own, it may have ended and not been collected.
  if (!own) return !MarkOfProcess(pid).empty();
  int status = 0;
  const pid_t done = waitpid(pid, &status, WNOHANG);
  if (done == 0) return true;
  if (done == pid) *exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return false;
}

/// Of the process that a file names; 0: none.
int NumberOf(const json& file) {
  const auto pid = file.is_object() ? file.find("pid") : file.end();
  return pid != file.end() && pid->is_number_integer() ? pid->get<int>() : 0;
}

void Add(std::vector<std::string>& words, const char* flag, const std::vector<std::string>& steps) {
  for (const std::string& step : steps) {
    words.push_back(flag);
    words.push_back(step);
  }
}

}  // namespace

RunControl::RunControl(fs::path project, Listener listener)
    : project_(std::move(project)), listener_(std::move(listener)) {}

RunControl::~RunControl() {
  leave_ = true;
  if (follower_.joinable()) follower_.join();
}

fs::path RunControl::File(const char* name) const { return project_ / ".keypose/studio" / name; }

void RunControl::Start(const RunSelection& selection) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (running_) throw LockedError("a run is at work already; stop it first");
  if (follower_.joinable()) follower_.join();
  fs::create_directories(File(""));
  std::vector<std::string> words = {(pipeline::ProgramFolder() / "keypose").string(),
                                    "run",
                                    "-C",
                                    project_.string(),
                                    "--progress",
                                    "jsonl"};
  Add(words, "--from", selection.from);
  Add(words, "--until", selection.until);
  Add(words, "--only", selection.only);
  Add(words, "--force", selection.force);
  pid_ = StartChild(words, project_, File("run.jsonl"), File("run.txt"));
  WriteFileAtomically(File("run.json"),
                      json{{"pid", pid_.load()}, {"process", MarkOfProcess(pid_)}}.dump());
  running_ = true;
  follower_ = std::thread([this, pid = pid_.load()] { Follow(pid, true); });
}

void RunControl::Stop() {
  if (running_ && pid_ > 0) kill(pid_, SIGINT);
}

void RunControl::TakeUp() {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (running_ || !fs::exists(File("run.json"))) return;
  const json value = json::parse(ReadFile(File("run.json")), nullptr, false);
  const int pid = NumberOf(value);
  if (pid <= 0 || value.value("process", json()) != MarkOfProcess(pid)) return;
  pid_ = pid;
  running_ = true;
  follower_ = std::thread([this, pid] { Follow(pid, false); });
}

void RunControl::Follow(int pid, bool own) {
  Tail lines(File("run.jsonl"));
  int exit_code = 0;
  bool alive = true;
  while (alive) {
    alive = IsAlive(pid, own, &exit_code);
    lines.Read(listener_.line);
    if (leave_) return;  // it goes on without this studio
    if (alive) std::this_thread::sleep_for(kPause);
  }
  std::error_code ignored;
  fs::remove(File("run.json"), ignored);
  running_ = false;
  const std::string message = WhatItSaid(File("run.txt"), exit_code);
  if (!own && !message.empty()) exit_code = 1;
  listener_.ended(exit_code, message);
}

}  // namespace keypose::studio
